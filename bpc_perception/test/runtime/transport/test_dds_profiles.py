"""Where a node with our profiles of Fast DDS hears messages."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import os
from pathlib import Path
import re
import select
import subprocess
import sys
from typing import Any

import pytest

pytest.importorskip('rclpy')
from rclpy.node import Node
from std_msgs.msg import Empty

from bpc_perception.runtime.transport.dds_profiles import with_profile

pytestmark = pytest.mark.ros
LISTENS = """
from bpc_perception.runtime.run import run
from rclpy.node import Node
from std_msgs.msg import Empty

class Listens(Node):
    def __init__(self):
        super().__init__('listens')
        self.create_subscription(Empty, 'topic', lambda _: print('heard', flush=True), 1)

run(Listens, large_messages={})
"""


@pytest.fixture
def shared_memory_ports(graph: Any, ros_domain: int, monkeypatch: pytest.MonkeyPatch,
                        ) -> Callable[[bool], list[int]]:
    """Return the ports at which a node, killed afterwards, hears through shared memory."""
    for name, value in with_profile(os.environ).items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    node = graph.make(partial(Node, 'talks'))
    publisher = node.create_publisher(Empty, 'topic', 1)
    node.create_timer(0.02, lambda: publisher.publish(Empty()))
    own = range(7400 + 250 * ros_domain, 7650 + 250 * ros_domain)

    def ports(large_messages: bool) -> list[int]:
        with subprocess.Popen([sys.executable, '-c', LISTENS.format(large_messages)],
                              stdout=subprocess.PIPE) as process:
            try:
                graph.spin_until(lambda: select.select([process.stdout], [], [], 0)[0])
                assert process.stdout is not None
                assert process.stdout.readline() == b'heard\n'
                found = re.findall(r'fastrtps_port(\d+)_el', ' '.join(
                    os.readlink(file) for file in Path(f'/proc/{process.pid}/fd').iterdir()))
            finally:
                process.kill()
        return [int(number) for number in found if int(number) in own]

    return ports


def test_nodes_one_after_another_listen_on_different_ports(
        shared_memory_ports: Callable[[bool], list[int]]) -> None:
    """A process that wrote to a killed node may go on writing to its port for ever."""
    # There are 89 numbers, so four are equal once in 700 000 times.
    found = [shared_memory_ports(True) for _ in range(4)]
    assert {len(ports) for ports in found} == {1}
    assert len({port for port, in found}) > 1


def test_who_takes_no_captures_hears_nothing_through_shared_memory(
        shared_memory_ports: Callable[[bool], list[int]]) -> None:
    """There a killed publisher may leave a lock for which the node would wait a second."""
    assert shared_memory_ports(False) == []
