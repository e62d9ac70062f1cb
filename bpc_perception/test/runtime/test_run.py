"""Nodes as processes: how they start, fail and end."""

from __future__ import annotations

import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip('rclpy')
from rclpy.node import Node

from bpc_perception.messages import topics
from bpc_perception.runtime.run import _make

pytestmark = pytest.mark.ros


def test_a_node_that_cannot_start_says_why_in_one_line_and_exits_with_2() -> None:
    ended = subprocess.run(
        [sys.executable, '-m', 'bpc_perception.nodes.thickness', '--ros-args', '-p',
         'hand_eye_file:=/nowhere/camera.calib'],
        capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 2
    line, = ended.stderr.splitlines()
    assert '/nowhere/camera.calib: expected a readable YAML file, found' in line


def test_a_node_that_cannot_even_say_why_it_does_not_start_exits_with_2(
        monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> Node:
        raise ValueError('expected something else')

    def full(_: str) -> None:
        raise OSError('No space left on device')

    monkeypatch.setattr(sys, 'stderr', SimpleNamespace(write=full))
    with pytest.raises(SystemExit) as ended:
        _make(refuse, large_messages=False)
    assert ended.value.code == 2


def test_a_node_with_a_broken_parameter_file_names_it_with_line_in_one_line(
        tmp_path: Path) -> None:
    file = tmp_path / 'params.yaml'
    file.write_text('path_recorder:\n  ros__parameters: [\n')
    ended = subprocess.run(
        [sys.executable, '-m', 'bpc_perception.nodes.path_recorder', '--ros-args',
         '--params-file', str(file)], capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 2
    line, = [line for line in ended.stderr.splitlines() if '[rcl]' not in line]
    assert line.startswith('PathRecorderNode: expected ROS arguments that can be read, found: ')
    assert f'{file}' in line
    assert 'line 2' in line


@pytest.mark.parametrize('numbers', [
    [signal.SIGTERM],
    [signal.SIGHUP],
    [signal.SIGINT, signal.SIGINT],  # from the terminal and from ros2 launch
    # From the kernel, one for each thread of a killed parent; and from an impatient user.
    [signal.SIGTERM] * 1000,
    [signal.SIGINT] * 1000,
], ids=['SIGTERM', 'SIGHUP', 'SIGINT', 'many SIGTERM', 'many SIGINT'])
def test_a_node_ends_when_told_to(graph: Any, ros_domain: int, numbers: list[signal.Signals],
                                  monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    peer = graph.make(Node, 'peer')
    with subprocess.Popen([sys.executable, '-m', 'bpc_perception.nodes.path_recorder'],
                          stderr=subprocess.PIPE, text=True) as process:
        try:
            graph.spin_until(lambda: 'path_recorder' in peer.get_node_names(), 30)
            for number in numbers:
                process.send_signal(number)
                time.sleep(0.005)  # otherwise two equal signals become one
                if process.poll() is not None:
                    break
            _, errors = process.communicate(timeout=20)
        finally:
            process.kill()
    assert process.returncode == 0
    assert 'Traceback' not in errors
    # It left the graph in order. Otherwise the graph keeps its publishers for another 20 s.
    graph.spin_until(lambda: peer.count_publishers(topics.PATH) == 0, 10)


FAILING = """
from bpc_perception.runtime.run import run
from rclpy.node import Node

class Failing(Node):
    def __init__(self):
        super().__init__('failing')
        self.create_timer(0.1, self.fail)

    def fail(self):
        raise RuntimeError('the node has failed')

"""


@pytest.mark.parametrize('made', ['Failing()', "(Failing(), Node('good'))",
                                  "(Node('good'), Failing())"])
def test_a_node_that_fails_says_so_and_takes_its_process_with_it(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch, made: str) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    ended = subprocess.run([sys.executable, '-c', f'{FAILING}run(lambda: {made})'],
                           capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1
    assert 'RuntimeError: the node has failed' in ended.stderr


ENDING = """
from bpc_perception.runtime.run import run
from rclpy.node import Node

class Ending(Node):
    def __init__(self):
        super().__init__('ending')
        print('made', flush=True)
        if FAILS:
            self.create_timer(0.1, self.fail)

    def fail(self):
        raise RuntimeError('the node has failed')

run(Ending, on_purpose=lambda node: print('on purpose', node.get_name(), flush=True))
"""


@pytest.mark.parametrize('fails', [False, True])
def test_a_node_knows_whether_it_is_ended_on_purpose(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch, fails: bool) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    with subprocess.Popen([sys.executable, '-c', f'FAILS = {fails}{ENDING}'], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == 'made\n'
        if not fails:
            process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=30)
    assert said == ('' if fails else 'on purpose ending\n')


HANGS = """
import ctypes
from bpc_perception.runtime.run import run
from rclpy.node import Node

class Hangs(Node):
    def __init__(self):
        super().__init__('hangs')
        print('made', flush=True)

    def destroy_node(self):
        ctypes.PyDLL(None).sleep(60)  # with the interpreter's lock

run(Hangs)
"""


def test_a_child_whose_end_hangs_in_cpp_ends_all_the_same(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    monkeypatch.setenv('BPC_PARENT', str(os.getpid()))
    with subprocess.Popen([sys.executable, '-c', HANGS], stdout=subprocess.PIPE,
                          text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == 'made\n'
            process.terminate()
            process.wait(30)
        finally:
            process.kill()
    assert process.returncode == -signal.SIGALRM


TOLD = """
import os, signal, sys, time
from bpc_perception.runtime.run import run
import rclpy
from rclpy.node import Node
from std_msgs.msg import Empty

# As the command line does; a node may run in its process.
signal.signal(signal.SIGTERM, signal.default_int_handler)

class Told(Node):
    def __init__(self):
        super().__init__('told')
        if sys.argv[2] == 'half':
            os.kill(os.getpid(), int(sys.argv[1]))
            time.sleep(0.3)
        self.create_publisher(Empty, 'topic', 1)
        print('made', flush=True)
        if sys.argv[2] == 'made':
            os.kill(os.getpid(), int(sys.argv[1]))

    def destroy_node(self):
        print('completed', flush=True)
        super().destroy_node()

def init(before=rclpy.init, **given):
    if sys.argv[2] == 'early':
        os.kill(os.getpid(), int(sys.argv[1]))
    before(**given)

rclpy.init = init
run(Told)
"""


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(('moment', 'words'), [
    ('early', ''), ('half', 'made\ncompleted\n'), ('made', 'made\ncompleted\n')])
def test_told_to_end_while_it_starts_a_node_leaves_nothing_half_made(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch, number: signal.Signals, moment: str,
        words: str) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    ended = subprocess.run([sys.executable, '-c', TOLD, str(int(number)), moment],
                           capture_output=True, text=True, timeout=60, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, words, '')
