"""How soon faults are seen and over, in a live print where every node is a process.

``python -m bpc_system_tests.robustness.fault_times --count 10``, in the folder ``test``: the robot
is killed, then nodes of ``bpc live`` are, again and again. The program prints the time from the
kill until /diagnostics reports it, and until a capture taken after it is measured, as the live
view hears it.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager, ExitStack
import os
from pathlib import Path
import signal
import statistics
import subprocess
import tempfile
import time

from diagnostic_msgs.msg import DiagnosticStatus

from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.transport.dds_profiles import choose_profile, receive_profile
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_sim.printer.settings import SettingsFiles, write_settings
from bpc_system_tests.parts.command_line import command
from bpc_system_tests.parts.ros_graph import Listener, listening, own_domain, start_delay

SCENARIO, SPEED_M_PER_S, TARGET_M = 'spiral_gaps', 0.0005, 2e-3  # a print of six minutes
CAMERA_RATE_HZ = 2.0
REST_S = 35.0  # between two kills of a node: three in a minute would end `bpc live`
SUPERVISED = ('thickness', 'path_recorder')  # killed in turn


@contextmanager
def live(folder: Path, settings: SettingsFiles) -> Iterator[None]:
    """Run ``bpc live`` during the block."""
    with (folder / 'live.log').open('w') as log, subprocess.Popen(
            command('live', '--handeye', settings.hand_eye, '--params', settings.parameters,
                    '--out', folder / 'prints'),
            stdin=subprocess.DEVNULL, stdout=log, stderr=log,
            env=os.environ | {'XDG_STATE_HOME': str(folder)}) as process:
        try:
            yield
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(20)


class Stopwatch:
    """Takes the time from a kill until the listener has heard something."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self._begun = 0.0

    def kill(self, pid: int) -> None:
        """Kill a process, and start the time."""
        self._listener.heard['/diagnostics'].clear()
        self._begun = time.monotonic()
        os.kill(pid, signal.SIGKILL)

    def until(self, condition: Callable[[], bool]) -> float:
        """Wait for a condition; return the time since the kill [s]."""
        self._listener.wait(condition)
        return time.monotonic() - self._begun

    def until_reported(self, name: str) -> float:
        """Wait until the status of a name is a warning or worse; return the time [s]."""
        return self.until(lambda: any(
            status.name == name and status.level >= DiagnosticStatus.WARN
            and status.level != DiagnosticStatus.STALE
            for message in self._listener.heard['/diagnostics'] for status in message.status))

    def until_measured(self) -> float:
        """Wait until a capture taken from now on is measured; return the time [s]."""
        now_ns = time.time_ns()
        return self.until(lambda: any(stamp_to_ns(profile.header.stamp) > now_ns
                                      for profile in self._listener.profiles[-3:]))


def pid_of(listener: Listener, name: str) -> int:
    """Return the process id that the supervisor reports of a node."""
    def found() -> list[str]:
        return [value.value for message in listener.heard['/diagnostics']
                for status in message.status
                if status.name == f'supervisor: {name}' and status.level == DiagnosticStatus.OK
                for value in status.values if value.key == 'pid']

    listener.wait(found)
    return int(found()[-1])


@contextmanager
def running_print(listener: Listener, folder: Path) -> Iterator[Nodes]:
    """Run a print with ``bpc live``, robot, extruder and camera; wait for its first profiles."""
    settings = write_settings(SCENARIOS[SCENARIO](SPEED_M_PER_S), TARGET_M, folder)
    with live(folder, settings), Nodes(settings.parameters) as nodes:
        begun = time.monotonic()
        pid_of(listener, 'thickness')
        start_ns = time.time_ns() + round(start_delay(time.monotonic() - begun) * 1e9)
        common = {'scenario': SCENARIO, 'speed': SPEED_M_PER_S, 'start_time_ns': start_ns}
        nodes.start('bpc_sim.nodes.robot', **common)
        nodes.start('bpc_sim.nodes.extruder', **common)
        nodes.start('bpc_perception.nodes.camera_driver', back_end='synthetic',
                    rate=CAMERA_RATE_HZ, **common)
        listener.wait(lambda: len(listener.profiles) > 3)
        yield nodes


def take_times(listener: Listener, nodes: Nodes, count: int) -> dict[str, list[float]]:
    """Kill the robot and a node of ``bpc live`` in turn; return the times [s] by fault."""
    times: dict[str, list[float]] = {}
    stopwatch = Stopwatch(listener)
    for number in range(count):
        rested = time.monotonic() + REST_S
        node = SUPERVISED[number % len(SUPERVISED)]
        node_pid = pid_of(listener, node)
        stopwatch.kill(nodes.pid('robot'))
        times.setdefault('robot killed: said', []).append(
            stopwatch.until_reported('path_recorder'))
        nodes.start_again('robot')
        times.setdefault('robot killed: measured again', []).append(stopwatch.until_measured())

        stopwatch.kill(node_pid)
        times.setdefault(f'{node} killed: said', []).append(
            stopwatch.until_reported(f'supervisor: {node}'))
        times.setdefault(f'{node} killed: measured again', []).append(stopwatch.until_measured())
        listener.wait(lambda rested=rested: time.monotonic() > rested)
    return times


def main() -> None:
    """Kill processes, take the times, and print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--count', type=int, default=10)
    count = parser.parse_args().count
    choose_profile()
    with tempfile.TemporaryDirectory() as name, own_domain() as domain, ExitStack() as stack:
        with receive_profile(large_messages=False):
            listener = stack.enter_context(listening(domain))
        nodes = stack.enter_context(running_print(listener, Path(name)))
        times = take_times(listener, nodes, count)
    for what, taken in times.items():
        print(f'{what}: {statistics.median(taken):.2f} s in the median, {max(taken):.2f} s at '
              f'most of {len(taken)}')


if __name__ == '__main__':
    main()
