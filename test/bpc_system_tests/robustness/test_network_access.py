"""Who can reach the running nodes: this computer only, unless it is told otherwise."""

from __future__ import annotations

from collections.abc import Iterator
import ipaddress
import os
from pathlib import Path
import socket
import subprocess
import sys
from threading import Thread
import time
from xml.etree import ElementTree

import pytest
from rclpy.node import Node

from bpc_perception.messages import topics
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import Graph
from bpc_perception.runtime.transport.dds_profiles import (
    DISCOVERY_RANGE_VARIABLE,
    FOLDER,
    PROFILE_VARIABLES,
)
from bpc_system_tests.documentation import sros2_policy
from bpc_system_tests.parts.command_line import PATIENCE_S, SAMPLE
from bpc_system_tests.parts.ros_graph import own_domain
from bpc_system_tests.parts.sockets import (
    address_in_the_network,
    is_read,
    open_to_others,
    sockets,
)


@pytest.fixture(scope='module')
def running_suite(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Nodes, Node]]:
    """All nodes on the sample recording, as the commands start them; and a listener."""
    with own_domain() as domain, pytest.MonkeyPatch.context() as patch:
        for name in PROFILE_VARIABLES:
            patch.delenv(name, raising=False)
        assert os.environ[DISCOVERY_RANGE_VARIABLE] == 'LOCALHOST'
        graph = Graph(domain)
        listener = graph.make(Node, 'listener')
        folder = tmp_path_factory.mktemp('doors')
        design = folder / 'line.csv'  # with one there is a topic more
        design.write_text('x_mm,y_mm,z_mm\n0,0,0\n20,0,0\n')
        try:
            with Nodes(SAMPLE / 'params.yaml', {'use_sim_time': True}) as nodes:
                calibration = str(SAMPLE / 'hand_eye.calib')
                nodes.start('bpc_perception.nodes.path_recorder')
                nodes.start('bpc_perception.nodes.composed', **{
                    'back_end': 'bag', 'bag': str(SAMPLE), 'hand_eye_file': calibration,
                    'design.file': str(design)})
                nodes.start('bpc_perception.nodes.bag_recorder', bag=str(folder / 'bag'))
                nodes.start('bpc_perception.nodes.bag_player', bag=str(SAMPLE))
                nodes.start('bpc_perception.nodes.extruder_bridge', back_end='bool')
                wanted = {'path_recorder', 'camera_driver', 'thickness', 'bag_recorder',
                          'bag_player', 'extruder_bridge'}

                def there() -> bool:
                    nodes.check()
                    return wanted <= set(listener.get_node_names())

                graph.spin_until(there, PATIENCE_S)
                yield nodes, listener
        finally:
            graph.close()


@pytest.fixture
def suite(running_suite: tuple[Nodes, Node]) -> Nodes:
    """The running nodes."""
    return running_suite[0]


@pytest.mark.parametrize('name', ['path_recorder', 'composed', 'bag_recorder', 'bag_player',
                                  'extruder_bridge'])
def test_only_this_computer_is_listened_to(suite: Nodes, name: str) -> None:
    places = sockets(suite.pid(name))
    assert any(ipaddress.ip_address(each.address).is_loopback for each in places)
    assert open_to_others(suite.pid(name)) == []


def test_the_check_finds_doors() -> None:
    with (socket.create_server(('', 0)) as server,
          socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as read,
          socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as unread):
        for each in (read, unread):
            each.bind(('', 0))
        reader = Thread(target=read.recv, args=(100,), daemon=True)
        reader.start()
        ports = {server.getsockname()[1], read.getsockname()[1]}
        assert ports <= {each.port for each in open_to_others(os.getpid())}
        reader.join()
        places = {each.port: each for each in sockets(os.getpid())}
        assert not is_read(os.getpid(), places[unread.getsockname()[1]])


# DDS security


def allowed(enclave: str, node: str, kind: str, action: str) -> set[str]:
    """Return the full names that the policy allows a node of an enclave."""
    root = ElementTree.parse(sros2_policy.FILE).getroot()
    profile = root.find(f"./enclaves/enclave[@path='/bpc/{enclave}']/profiles/"
                        f"profile[@node='{node}']")
    assert profile is not None
    assert profile.get('ns') == '/'
    names = [str(each.text) for each in profile.iterfind(f'./{kind}[@{action}="ALLOW"]/*')]
    return {name.replace('~', f'/{node}') if name.startswith('~') else
            name if name.startswith('/') else f'/{name}' for name in names}


# Names that depend on parameters: the clock, and the source of poses.
OPTIONAL = {'/clock', '/parameter_events', *(f'/{name.lstrip("/")}'
                                             for name in sros2_policy.POSES)}


@pytest.mark.parametrize(('enclave', 'node'), [
    ('path_recorder', 'path_recorder'), ('composed', 'camera_driver'), ('composed', 'thickness'),
    ('bag_recorder', 'bag_recorder'), ('extruder_bridge', 'extruder_bridge')])
def test_the_policy_allows_what_nodes_do_and_no_more(
        running_suite: tuple[Nodes, Node], enclave: str, node: str) -> None:
    _, listener = running_suite
    for kind, action, look in (
            ('topics', 'publish', listener.get_publisher_names_and_types_by_node),
            ('topics', 'subscribe', listener.get_subscriber_names_and_types_by_node),
            ('services', 'reply', listener.get_service_names_and_types_by_node),
            ('services', 'request', listener.get_client_names_and_types_by_node)):
        found = {name for name, _ in look(node, '/')}
        permitted = allowed(enclave, node, kind, action)
        assert found <= permitted, action
        if enclave == node == 'extruder_bridge':
            permitted -= {'/plunger_joint_states'}  # used by another back end
        if enclave == 'composed' and action == 'subscribe':
            permitted -= {f'/{name}' for name in topics.CAMERA}  # handed over in memory instead
        assert permitted - found <= OPTIONAL, action


def test_without_its_plug_ins_security_is_refused_not_left_out(tmp_path: Path) -> None:
    """Fast DDS of the wheels has no plug-ins: with security asked for, no node starts."""
    enclave = tmp_path / 'enclaves' / 'bpc'
    enclave.mkdir(parents=True)
    for name in ('identity_ca.cert.pem', 'cert.pem', 'key.pem', 'permissions_ca.cert.pem',
                 'governance.p7s', 'permissions.p7s'):
        (enclave / name).touch()
    with own_domain():
        ended = subprocess.run(
            [sys.executable, '-m', 'bpc_perception.nodes.path_recorder', '--ros-args',
             '--enclave', '/bpc'], stdin=subprocess.DEVNULL, capture_output=True, text=True,
            timeout=60, check=False, env={
                **os.environ, 'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Enforce',
                'ROS_SECURITY_KEYSTORE': str(tmp_path)})
    assert ended.returncode != 0
    assert 'security' in ended.stderr


# Opening one network


def test_a_lab_opens_one_network_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As docs/security.md says: a copy of a profile with the address of one interface."""
    host = address_in_the_network()
    if not host:
        pytest.skip('needs a network interface beside the loopback')
    profile = tmp_path / 'lab.xml'
    profile.write_text((FOLDER / 'local.xml').read_text().replace(
        '<address>127.0.0.1</address>', f'<address>{host}</address>'))
    monkeypatch.setenv(DISCOVERY_RANGE_VARIABLE, 'SUBNET')
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(profile))
    with own_domain(), Nodes() as nodes:
        nodes.start('bpc_perception.nodes.path_recorder')
        process = nodes.pid('path_recorder')
        end = time.monotonic() + 30
        while not any(each.address == host for each in sockets(process)):
            nodes.check()
            assert time.monotonic() < end
            time.sleep(0.02)
        assert open_to_others(process, allowed=host) == []
