"""How soon faults are seen and over, in a live print with every node a process.

``python -m bpc_system_tests.robustness.fault_times --count 10``, in the folder ``test``: the robot
is killed, then nodes of ``bpc live`` are, again and again. Printed are the times from the kill
until /diagnostics says so, and until a capture taken after it is measured, as the live view hears
it.
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
import yaml

from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.transport.dds_profiles import choose_profile, receive_profile
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_system_tests.parts.command_line import command
from bpc_system_tests.parts.ros_graph import Listener, listening, own_domain, start_delay

SCENARIO, SPEED, TARGET = 'spiral_gaps', 0.0005, 2e-3  # a print of six minutes
CAMERA_RATE = 2.0  # [Hz]
REST = 35.0  # between two deaths: three in a minute would end it all [s]


@contextmanager
def live(folder: Path, calibration: Path, settings: Path) -> Iterator[None]:
    """``bpc live`` while the block runs."""
    with (folder / 'live.log').open('w') as log, subprocess.Popen(
            command('live', '--handeye', calibration, '--params', settings),
            stdin=subprocess.DEVNULL, stdout=log, stderr=log,
            env=os.environ | {'XDG_STATE_HOME': str(folder)}) as process:
        try:
            yield
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(20)


class Clock:
    """Takes the time until the listener has heard something."""

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self._begun = 0.0

    def kill(self, pid: int) -> None:
        """From now on."""
        self._listener.heard['/diagnostics'].clear()
        self._begun = time.monotonic()
        os.kill(pid, signal.SIGKILL)

    def until(self, condition: Callable[[], bool]) -> float:
        """Seconds since the kill when it holds."""
        self._listener.wait(condition)
        return time.monotonic() - self._begun

    def until_said(self, name: str, level: bytes) -> float:
        """Seconds since the kill when a status of this name has this level, or a worse one."""
        return self.until(lambda: any(
            status.name == name and DiagnosticStatus.WARN <= level <= status.level
            and status.level != DiagnosticStatus.STALE
            for message in self._listener.heard['/diagnostics'] for status in message.status))

    def until_measured(self) -> float:
        """Seconds since the kill when a capture taken after it is measured."""
        now_ns = time.time_ns()
        return self.until(lambda: any(stamp_to_ns(profile.header.stamp) > now_ns
                                      for profile in self._listener.profiles[-3:]))


def pid_of(listener: Listener, name: str) -> int:
    """The process id that the supervisor tells of a node."""
    def found() -> list[str]:
        return [value.value for message in listener.heard['/diagnostics']
                for status in message.status
                if status.name == f'supervisor: {name}' and status.level == DiagnosticStatus.OK
                for value in status.values if value.key == 'pid']

    listener.wait(found)
    return int(found()[-1])


def main() -> None:
    """Kill and take the time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--count', type=int, default=10)
    count = parser.parse_args().count
    job = SCENARIOS[SCENARIO](SPEED)
    times: dict[str, list[float]] = {}
    choose_profile()
    with tempfile.TemporaryDirectory() as name, own_domain() as domain, ExitStack() as stack:
        with receive_profile(large_messages=False):
            listener = stack.enter_context(listening(domain))
        folder = Path(name)
        calibration, settings = folder / 'cell.calib', folder / 'cell.yaml'
        calibration.write_text(yaml.safe_dump(hand_eye_calibration(job)))
        settings.write_text(yaml.safe_dump(node_parameters(job, TARGET)))
        with live(folder, calibration, settings), Nodes(settings) as nodes:
            begun = time.monotonic()
            pid_of(listener, 'thickness')
            start_ns = time.time_ns() + round(start_delay(time.monotonic() - begun) * 1e9)
            common = {'scenario': SCENARIO, 'speed': SPEED, 'start_time_ns': start_ns}
            nodes.start('bpc_sim.nodes.robot', **common)
            nodes.start('bpc_sim.nodes.extruder', **common)
            nodes.start('bpc_perception.nodes.camera_driver', back_end='synthetic',
                        rate=CAMERA_RATE, **common)
            listener.wait(lambda: len(listener.profiles) > 3)
            clock = Clock(listener)
            for number in range(count):
                rested = time.monotonic() + REST
                for fault, victim in (
                        ('robot', nodes.pid('robot')),
                        (watched := ('thickness', 'path_recorder')[number % 2],
                         pid_of(listener, watched))):
                    clock.kill(victim)
                    said = clock.until_said('path_recorder' if fault == 'robot'
                                            else f'supervisor: {fault}', DiagnosticStatus.WARN)
                    times.setdefault(f'{fault} killed: said', []).append(said)
                    if fault == 'robot':
                        nodes.start_again('robot')
                    times.setdefault(f'{fault} killed: measured again', []).append(
                        clock.until_measured())
                listener.wait(lambda rested=rested: time.monotonic() > rested)
    for what, taken in times.items():
        print(f'{what}: {statistics.median(taken):.2f} s in the median, {max(taken):.2f} s at '
              f'most of {len(taken)}')


if __name__ == '__main__':
    main()
