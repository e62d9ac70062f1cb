"""Who can reach the suite: this computer, and none other unless it is told to."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import ipaddress
import os
from pathlib import Path
import resource
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
from bpc_perception.runtime.transport import dds_profiles
from bpc_perception.runtime.transport.dds_profiles import (
    DISCOVERY_RANGE_VARIABLE,
    FOLDER,
    PROFILE_VARIABLES,
    PROFILES,
    receive_profile,
    with_profile,
)
from bpc_perception.runtime.transport.shared_memory import clean
from bpc_system_tests.documentation import sros2_policy
from bpc_system_tests.parts.command_line import SAMPLE
from bpc_system_tests.parts.ros_graph import own_domain

LISTENING = '0A'  # of TCP, tcp_states.h of Linux
NAMESPACE = {'dds': 'http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles'}


@dataclass(frozen=True)
class Socket:
    """A socket that takes what anybody sends: TCP that listens, UDP that is not connected."""

    protocol: str
    address: str
    port: int
    waiting: int  # bytes that nobody has read


def address_of(text: str) -> tuple[str, int]:
    """Address and port as /proc/net writes them: words of the machine's byte order."""
    host, port = text.split(':')
    words = bytes.fromhex(host)
    if sys.byteorder == 'little':
        words = b''.join(words[i:i + 4][::-1] for i in range(0, len(words), 4))
    return str(ipaddress.ip_address(words)), int(port, 16)


def sockets(process: int) -> list[Socket]:
    """Those of a process."""
    own = set()
    for descriptor in Path(f'/proc/{process}/fd').iterdir():
        try:
            own.add(os.readlink(descriptor))
        except FileNotFoundError:  # closed meanwhile
            continue
    found = []
    for protocol in ('tcp', 'tcp6', 'udp', 'udp6'):
        table = Path(f'/proc/{process}/net/{protocol}')
        for line in table.read_text().splitlines()[1:] if table.exists() else ():
            fields = line.split()
            unconnected = int(fields[2].split(':')[1], 16) == 0
            listens = fields[3] == LISTENING if protocol.startswith('tcp') else unconnected
            if listens and f'socket:[{fields[9]}]' in own:
                found.append(Socket(protocol, *address_of(fields[1]),
                                    int(fields[4].split(':')[1], 16)))
    return found


def is_read(process: int, place: Socket) -> bool:
    """Whether somebody takes what comes to a UDP socket.

    Fast DDS sends through sockets of its own, at ports that change, and never reads from them.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        unspecified = ipaddress.ip_address(place.address).is_unspecified
        host = '127.0.0.1' if unspecified else place.address
        sender.sendto(b'knock', (host, place.port))
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        now = {(each.protocol, each.port): each.waiting for each in sockets(process)}
        if now.get((place.protocol, place.port), 0) > place.waiting:
            return False  # it waits there
        time.sleep(0.01)
    return True


def open_to_others(process: int, allowed: str = '127.0.0.1') -> list[Socket]:
    """Sockets that read what comes from other computers, or from others than is allowed."""
    found = []
    for each in sockets(process):
        address = ipaddress.ip_address(each.address)
        if address.is_loopback or each.address == allowed or address.is_multicast:
            continue
        if each.protocol.startswith('tcp') or is_read(process, each):
            found.append(each)
    return found


def address_in_the_network() -> str:
    """Of this computer, towards others; empty where it has no network."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as towards:
        try:
            towards.connect(('198.51.100.1', 9))  # reserved for documents, and nothing is sent
        except OSError:
            return ''
        return str(towards.getsockname()[0])


@pytest.fixture(scope='module')
def running_suite(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Nodes, Node]]:
    """Every node, on the sample recording, as the commands start them; and one that looks."""
    nodes_of = 'bpc_perception.nodes.'
    with own_domain() as domain, pytest.MonkeyPatch.context() as patch:
        for name in PROFILE_VARIABLES:
            patch.delenv(name, raising=False)
        assert os.environ[DISCOVERY_RANGE_VARIABLE] == 'LOCALHOST'
        graph = Graph(domain)
        listener = graph.make(Node, 'listener')
        folder = tmp_path_factory.mktemp('doors')
        try:
            with Nodes(SAMPLE / 'params.yaml', {'use_sim_time': True}) as nodes:
                calibration = str(SAMPLE / 'hand_eye.calib')
                nodes.start(f'{nodes_of}path_recorder')
                nodes.start(f'{nodes_of}composed', back_end='bag', bag=str(SAMPLE),
                            hand_eye_file=calibration)
                nodes.start(f'{nodes_of}bag_recorder', bag=str(folder / 'bag'))
                nodes.start(f'{nodes_of}bag_player', bag=str(SAMPLE))
                nodes.start(f'{nodes_of}extruder_bridge', back_end='bool')
                wanted = {'path_recorder', 'camera_driver', 'thickness', 'bag_recorder',
                          'bag_player', 'extruder_bridge'}

                def there() -> bool:
                    nodes.check()
                    return wanted <= set(listener.get_node_names())

                graph.spin_until(there, 60.0)
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
    """Full names that the policy allows a node of an enclave."""
    root = ElementTree.parse(sros2_policy.FILE).getroot()
    profile = root.find(f"./enclaves/enclave[@path='/bpc/{enclave}']/profiles/"
                        f"profile[@node='{node}']")
    assert profile is not None
    assert profile.get('ns') == '/'
    names = [str(each.text) for each in profile.iterfind(f'./{kind}[@{action}="ALLOW"]/*')]
    return {name.replace('~', f'/{node}') if name.startswith('~') else
            name if name.startswith('/') else f'/{name}' for name in names}


# Depend on parameters: the clock, and which of several is the source of poses.
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
            permitted -= {'/plunger_joint_states'}  # of another back end
        if enclave == 'composed' and action == 'subscribe':
            permitted -= {f'/{name}' for name in topics.CAMERA}  # handed over instead
        assert permitted - found <= OPTIONAL, action


def test_without_its_plug_ins_security_is_refused_not_left_out(tmp_path: Path) -> None:
    """Fast DDS of the wheels has none: who asks for security gets that, or no node."""
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


# The profiles


def test_profiles_differ_in_what_they_are_for_only() -> None:
    for (local, captures), file in PROFILES.items():
        root = ElementTree.parse(file).getroot()
        assert [each.text for each in root.iterfind('.//dds:address', NAMESPACE)] == (
            ['127.0.0.1'] if local else [])
        assert [each.text for each in root.iterfind('.//dds:segment_size', NAMESPACE)] == (
            ['67108864'] if captures else [])
        assert [each.text for each in root.iterfind('.//dds:port_queue_capacity', NAMESPACE)] == [
            '2048']
        types = [each.text for each in root.iterfind('.//dds:type', NAMESPACE)]
        assert types == ['SHM', 'UDPv4']
        assert [float(root.findtext(f'.//dds:leaseAnnouncement/dds:{unit}', '', NAMESPACE))
                for unit in ('sec', 'nanosec')] == [0, 5e8]
        # Or else Fast DDS adds its own transports, which listen everywhere.
        assert root.findtext('.//dds:useBuiltinTransports', None, NAMESPACE) == 'false'
        used = {each.text for each in root.iterfind('.//dds:userTransports/*', NAMESPACE)}
        assert used == {each.text for each in root.iterfind(
            './/dds:transport_descriptor/dds:transport_id', NAMESPACE)}


@pytest.mark.parametrize(('reach', 'captures', 'file'), [
    ('LOCALHOST', False, 'local.xml'), ('LOCALHOST', True, 'local_transport.xml'),
    ('SUBNET', True, 'transport.xml'), ('SUBNET', False, 'network.xml'),
    (None, False, 'network.xml')])
def test_the_profile_follows_the_range(reach: str | None, captures: bool,
                                       file: str) -> None:
    # Also where a shell has another of ours from before.
    given = {PROFILE_VARIABLES[0]: str(FOLDER / 'local.xml'), 'HOME': '/'} | (
        {DISCOVERY_RANGE_VARIABLE: reach} if reach else {})
    chosen = with_profile(given, captures)
    assert [chosen.get(name) for name in PROFILE_VARIABLES] == [str(FOLDER / file)] * 2
    assert chosen['HOME'] == '/'


def test_a_users_own_profile_is_left_alone() -> None:
    given = {PROFILE_VARIABLES[1]: '/home/my.xml', DISCOVERY_RANGE_VARIABLE: 'LOCALHOST'}
    assert with_profile(given, captures=True) == given


def offsets(name: str) -> list[str | None]:
    """The offset of the port for messages, of the profile that is given."""
    return [each.text for each in ElementTree.parse(os.environ[name]).getroot().iterfind(
        './/dds:participant/dds:rtps/dds:port/dds:offsetd3', NAMESPACE)]


@pytest.mark.parametrize('profile', PROFILES.values(), ids=lambda profile: profile.name)
def test_each_process_listens_on_a_port_of_its_domain(monkeypatch: pytest.MonkeyPatch,
                                                      profile: Path) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(profile))
    found = set()
    for _ in range(1000):
        with receive_profile(large_messages=True):
            (offset,), others = offsets(PROFILE_VARIABLES[0]), offsets(PROFILE_VARIABLES[1])
            assert others == [offset]
            found.add(int(offset or ''))
            made = Path(os.environ[PROFILE_VARIABLES[0]])
        assert not made.exists()
        assert [os.environ[name] for name in PROFILE_VARIABLES] == [str(profile)] * 2
    # Odd numbers, as those of discovery are even; with up to 32 participants below the next 250.
    assert found <= set(range(11, 250 - 2 * 31, 2))
    assert len(found) > 80


def test_nobody_removes_the_profile_of_a_process_that_reads_it(
        monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(FOLDER / 'local.xml'))
    with receive_profile(large_messages=True):
        made = Path(os.environ[PROFILE_VARIABLES[0]])
        clean(made.parent, settled=0.0, among={made.name})
        assert made.exists()


@pytest.mark.parametrize('profile', PROFILES.values(), ids=lambda profile: profile.name)
def test_small_messages_are_heard_by_udp(monkeypatch: pytest.MonkeyPatch, profile: Path) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(profile))
    with receive_profile(large_messages=False):
        rtps = ElementTree.parse(os.environ[PROFILE_VARIABLES[0]]).getroot().find(
            './/dds:participant/dds:rtps', NAMESPACE)
        assert rtps is not None
        assert [each.tag.partition('}')[2] for each in rtps.iterfind(
            'dds:defaultUnicastLocatorList/dds:locator/*', NAMESPACE)] == ['udpv4']
        assert rtps.find('dds:port', NAMESPACE) is None
    assert [os.environ[name] for name in PROFILE_VARIABLES] == [str(profile)] * 2


def test_who_has_no_udp_hears_small_messages_through_shared_memory(
        monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    profile = tmp_path / 'my.xml'
    profile.write_text((FOLDER / 'local.xml').read_text().replace('UDPv4', 'SHM'))
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(profile))
    with receive_profile(large_messages=False):
        assert len(offsets(PROFILE_VARIABLES[0])) == 1


@pytest.mark.parametrize('text', ['<port>', '<defaultUnicastLocatorList>', None,
                                  '\N{DEGREE SIGN}'])
@pytest.mark.parametrize('name', PROFILE_VARIABLES)
def test_a_profile_that_says_where_to_hear_is_left_as_it_is(
        monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str, text: str | None) -> None:
    """So is one that cannot be read, and none."""
    for variable in PROFILE_VARIABLES:
        monkeypatch.delenv(variable, raising=False)
    with receive_profile(large_messages=True):
        assert not any(variable in os.environ for variable in PROFILE_VARIABLES)
    profile = tmp_path / 'my.xml'
    if text is not None:
        profile.write_text(text, encoding='latin-1')
    monkeypatch.setenv(name, str(profile))
    with receive_profile(large_messages=True):
        assert os.environ[name] == str(profile)


def test_without_room_for_a_profile_the_port_is_as_ever(monkeypatch: pytest.MonkeyPatch,
                                                        tmp_path: Path) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(FOLDER / 'local.xml'))
    monkeypatch.setattr(dds_profiles, 'SHARED_MEMORY', tmp_path / 'none')
    with receive_profile(large_messages=True):
        assert os.environ[PROFILE_VARIABLES[0]] == str(FOLDER / 'local.xml')


def test_a_profile_that_cannot_be_written_whole_is_not_used(
        monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PROFILE_VARIABLES:
        monkeypatch.setenv(name, str(FOLDER / 'local.xml'))
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        with receive_profile(large_messages=True):
            assert os.environ[PROFILE_VARIABLES[0]] == str(FOLDER / 'local.xml')
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


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
