"""Nodes that die are started again; small programs stand in for nodes."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import shutil
import signal
import subprocess
import tempfile
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from bpc_perception.runtime import child_processes, run, supervisor
from bpc_perception.runtime.child_processes import NodeError, Nodes
from bpc_perception.runtime.supervisor import Supervisor
from bpc_perception.runtime.transport.shared_memory import SHARED_MEMORY, used_by

pytestmark = pytest.mark.ros

PROGRAMS = {
    'lives': """
import os, time
pipe = int(os.environ['BPC_HEARTBEAT'])
while True:
    os.write(pipe, b'lives\\n')
    time.sleep(0.05)
""",
    'hangs': """
import os, time
os.write(int(os.environ['BPC_HEARTBEAT']), b'hangs\\n')
time.sleep(60)
""",
    'never_begins': "import time\ntime.sleep(60)",
    'half_hangs': """
import os, time
pipe = int(os.environ['BPC_HEARTBEAT'])
os.write(pipe, b'hangs\\n')
while True:
    os.write(pipe, b'lives\\n')
    time.sleep(0.05)
""",
    'dies': "raise SystemExit('the last words')",
    'refuses': "import sys\nprint('what is wrong')\nsys.exit(2)",
    'refuses_once': """
import os, pathlib, sys, time
lives = pathlib.Path(__file__).with_suffix('.lives')
with lives.open('a') as file:
    file.write('I')
if len(lives.read_text()) == 2:
    time.sleep(0.3)  # to load
    print('not free yet')
    sys.exit(2)
while True:
    os.write(int(os.environ['BPC_HEARTBEAT']), b'refuses_once\\n')
    time.sleep(0.05)
""",
    'lingers': """
import mmap, os, signal, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
with open(f'/dev/shm/fastrtps_{os.getpid():016x}', 'w+b') as file:  # as Fast DDS does
    file.truncate(mmap.PAGESIZE)
    kept = mmap.mmap(file.fileno(), mmap.PAGESIZE)
os.write(int(os.environ['BPC_HEARTBEAT']), b'lingers\\n')
time.sleep(60)
""",
}


class Suite:
    """Programs under supervision, and what /diagnostics say of them."""

    def __init__(self, graph: Any, nodes: Nodes) -> None:
        self._graph = graph
        self.nodes = nodes
        self.said: list[DiagnosticStatus] = []
        self._node = graph.make(Node, 'bpc_monitor')
        self._node.create_subscription(
            DiagnosticArray, '/diagnostics', lambda message: self.said.extend(message.status), 10)

    def supervise(self, *names: str) -> None:
        for name in names:
            self.nodes.start(name)
        self._supervisor = Supervisor(self.nodes, self._node)

    def until(self, condition: Any) -> None:
        def looked_after() -> Any:
            self._supervisor.check()
            return condition()

        self._graph.spin_until(looked_after)

    def until_it_speaks(self, name: str) -> None:
        self._graph.spin_until(lambda: self.nodes.silence(name)[1])

    def level(self, name: str) -> bytes | None:
        levels = [each.level for each in self.said if each.name == f'supervisor: {name}']
        return levels[-1] if levels else None


@pytest.fixture
def suite(graph: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Suite]:
    for name, text in PROGRAMS.items():
        (tmp_path / f'{name}.py').write_text(text)
    monkeypatch.setenv('PYTHONPATH', f'{tmp_path}:{os.environ.get("PYTHONPATH", "")}')
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'logs'))
    with Nodes() as nodes:
        yield Suite(graph, nodes)


def test_a_killed_node_is_started_again_with_its_parameters(suite: Suite) -> None:
    suite.supervise('lives')
    suite.until(lambda: suite.level('lives') == DiagnosticStatus.OK)
    before = suite.nodes.pid('lives')
    arguments = Path(f'/proc/{before}/cmdline').read_bytes()
    os.kill(before, signal.SIGKILL)
    suite.until(lambda: suite.nodes.pid('lives') != before
                and suite.level('lives') == DiagnosticStatus.OK)
    assert Path(f'/proc/{suite.nodes.pid("lives")}/cmdline').read_bytes() == arguments
    words, = {each.message for each in suite.said if each.level == DiagnosticStatus.ERROR}
    assert words.startswith('ended with status -9: no output; it is started again')


def test_a_node_is_started_again_where_no_log_can_be_written(
        suite: Suite, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        caplog: pytest.LogCaptureFixture) -> None:
    suite.supervise('lives')
    suite.until(lambda: suite.level('lives') == DiagnosticStatus.OK)
    shutil.rmtree(tmp_path / 'logs')
    (tmp_path / 'logs').touch()  # no folder
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path / 'logs'))
    before = suite.nodes.pid('lives')
    os.kill(before, signal.SIGKILL)
    suite.until(lambda: suite.nodes.pid('lives') != before
                and suite.level('lives') == DiagnosticStatus.OK)
    suite.nodes.start('dies')
    suite.until(lambda: suite.nodes.ended('dies'))
    assert suite.nodes.end_of('dies') == 'ended with status 1: the last words'
    words, = {record.getMessage() for record in caplog.records}  # held, it is said once
    assert words == f'logs: expected to write into {tmp_path / "logs"}, found: File exists'


def test_where_no_process_can_be_started_it_is_tried_again(
        suite: Suite, monkeypatch: pytest.MonkeyPatch) -> None:
    suite.supervise('lives')
    suite.until(lambda: suite.level('lives') == DiagnosticStatus.OK)
    before = suite.nodes.pid('lives')
    left = [4]  # more than the deaths that end all
    started = subprocess.Popen

    def start(*given: Any, **more: Any) -> Any:
        left[0] -= 1
        if left[0] >= 0:
            raise BlockingIOError('too many processes')
        return started(*given, **more)

    monkeypatch.setattr(supervisor.BackOff, 'waiting', lambda *_: 0.0)
    monkeypatch.setattr(child_processes.subprocess, 'Popen', start)
    os.kill(before, signal.SIGKILL)
    suite.until(lambda: suite.nodes.pid('lives') != before
                and suite.level('lives') == DiagnosticStatus.OK)
    assert left == [-1]
    assert suite._supervisor._lives['lives'].cause == 'cannot be started: too many processes'


def test_three_deaths_end_it_all_and_name_the_cause(suite: Suite) -> None:
    suite.supervise('lives', 'dies')
    with pytest.raises(NodeError, match=r'3 deaths within .*(dies ended.*the last words.*){3}'):
        suite.until(lambda: False)


def test_a_node_that_refuses_to_start_is_not_asked_twice(suite: Suite) -> None:
    suite.supervise('refuses')
    with pytest.raises(NodeError, match=r'refuses: .* status 2: what is wrong'):
        suite.until(lambda: False)


def test_a_node_that_ran_before_and_then_refuses_is_asked_again(suite: Suite) -> None:
    """A file may not be written yet, or a device not free yet."""
    suite.supervise('refuses_once')
    suite.until(lambda: suite.level('refuses_once') == DiagnosticStatus.OK)
    os.kill(suite.nodes.pid('refuses_once'), signal.SIGKILL)
    suite.until(lambda: suite.level('refuses_once') == DiagnosticStatus.ERROR)
    suite.until(lambda: suite.level('refuses_once') == DiagnosticStatus.OK)
    causes = [each.message for each in suite.said if each.level == DiagnosticStatus.ERROR]
    assert 'status 2: not free yet; it is started again' in causes[-1]


@pytest.mark.parametrize('name', ['hangs', 'half_hangs', 'never_begins'])
def test_a_node_that_hangs_is_stale_and_then_started_again(
        suite: Suite, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setattr(supervisor, 'HANG_TIME_S', 0.6)
    suite.supervise(name)
    suite.until(lambda: suite.level(name) == DiagnosticStatus.STALE)
    before = suite.nodes.pid(name)
    suite.until(lambda: suite.nodes.pid(name) != before)
    assert any('hung for' in each.message for each in suite.said)
    assert name != 'never_begins' or suite.level(name) != DiagnosticStatus.OK


def test_who_cannot_be_killed_holds_up_nobody(
        suite: Suite, monkeypatch: pytest.MonkeyPatch) -> None:
    """For example a process that waits in the kernel for a device."""
    monkeypatch.setattr(child_processes, 'KILL_PATIENCE_S', 0.1)
    suite.nodes.start('lingers')
    suite.until_it_speaks('lingers')
    kill = subprocess.Popen.kill
    with monkeypatch.context() as context:
        context.setattr(subprocess.Popen, 'kill', lambda _: None)
        suite.nodes.kill('lingers')
        assert not suite.nodes.ended('lingers')
        context.setattr(child_processes, 'END_PATIENCE_S', 0.1)
        suite.nodes.__exit__(None, None, None)
        assert not suite.nodes.ended('lingers')
    kill(suite.nodes._children['lingers'].process)


class Blocked:
    """An executor that hangs in the first callback, and reads signs of life from before it."""

    pipe, signs = -1, b''

    def add_node(self, _: object) -> None:
        pass

    def spin_once(self, **_: float) -> None:
        Blocked.signs = os.read(self.pipe, 100)
        raise TimeoutError


def test_a_node_speaks_before_its_first_callback(monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise nobody would miss one of two nodes in a process that hangs from the start."""
    Blocked.pipe, into = os.pipe()
    os.set_blocking(Blocked.pipe, False)
    monkeypatch.setattr(run, 'SingleThreadedExecutor', Blocked)
    failures: list[Exception] = []
    try:
        run._spin_one(SimpleNamespace(get_name=lambda: 'blocked'),  # type: ignore[arg-type]
                      run._Ending(), failures, into)
    finally:
        os.close(Blocked.pipe)
        os.close(into)
    assert [type(error) for error in failures] == [TimeoutError]
    assert Blocked.signs == b'blocked\n'


def test_who_does_not_end_is_killed_together_with_the_others(
        suite: Suite, tmp_path: Path) -> None:
    suite.supervise('lives', 'lingers')
    suite.until(lambda: suite.level('lives') == DiagnosticStatus.OK
                and suite.nodes._children['lingers'].beats)
    pids = [suite.nodes.pid(name) for name in ('lives', 'lingers')]
    name, = used_by(pids[1])
    suite.nodes.__exit__(None, None, None)
    assert not (SHARED_MEMORY / name).exists()
    assert [suite.nodes.status(name) for name in ('lives', 'lingers')] == [
        -signal.SIGTERM, -signal.SIGKILL]
    assert not any(Path(f'/proc/{pid}').exists() for pid in pids)
    assert list((tmp_path / 'logs').iterdir()) == []
