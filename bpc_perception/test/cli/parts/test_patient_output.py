"""Whoever does not take the output of a command holds up neither it nor its nodes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from bpc_perception.cli.parts import patient_output
from bpc_perception.cli.parts.patient_output import PatientStream

LINE = 'x' * 99 + '\n'


@pytest.fixture(autouse=True)
def without_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patient_output, 'LAST_WORDS_PATIENCE_S', 0.05)


def test_what_nobody_takes_is_dropped_by_whole_lines_and_counted() -> None:
    reading, writing = os.pipe()
    stream = PatientStream(writing, 'utf-8')
    for _ in range(20_000):  # 2 MB
        stream.write(LINE)
    lost = stream.lost
    assert lost > 5_000
    taken = b''
    while len(taken) < (20_000 - lost) * len(LINE):
        taken += os.read(reading, 65536)
    assert taken == LINE.encode() * (20_000 - lost)
    stream.write('the next line\n')  # there is room again
    assert os.read(reading, 100) == b'the next line\n'
    stream.finish()
    assert stream.lost == lost


@pytest.mark.parametrize('flags', [0, os.O_NONBLOCK])
def test_what_somebody_takes_slowly_is_all_there(flags: int) -> None:
    reading, writing = os.pipe2(flags)
    os.set_blocking(reading, True)
    stream = PatientStream(writing, 'utf-8')
    for _ in range(5_000):  # more than a pipe holds
        stream.write(LINE)
    taken = b''
    while len(taken) < 5_000 * len(LINE):
        taken += os.read(reading, 4096)
    assert taken == LINE.encode() * 5_000
    stream.finish()
    assert stream.lost == 0


def test_a_reader_that_has_gone_and_a_full_disk_are_no_error() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    for handle in (writing, os.open('/dev/full', os.O_WRONLY)):
        stream = PatientStream(handle, 'utf-8')
        stream.write(LINE)
        stream.write('no whole line')
        stream.finish()
        assert stream.lost == 1


# Its output goes nowhere. It says on another descriptor when it has said all.
TALKER = """
import os, sys
from bpc_perception.cli.parts.monitor import monitoring
from bpc_perception.cli.parts.terminal import Terminal

terminal = Terminal()
with monitoring(terminal) as monitor:
    for _ in range(300):  # more than a pipe holds
        terminal.say('x' * 100)
        terminal.warn('y' * 100)
        monitor.node.get_logger().warning('z' * 100)
    os.write(int(sys.argv[1]), b'said')
    monitor.spin_until(lambda: False)
os.write(int(sys.argv[1]), b'ended')
"""


@pytest.mark.ros
def test_a_command_whose_output_goes_nowhere_goes_on_and_can_be_ended(
        ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    _, unread = os.pipe()
    listening, telling = os.pipe()
    with subprocess.Popen([sys.executable, '-c', TALKER, str(telling)], pass_fds=(telling,),
                          stdout=unread, stderr=unread) as process:
        try:
            os.close(telling)
            assert os.read(listening, 10) == b'said'
            process.send_signal(signal.SIGINT)
            assert os.read(listening, 10) == b'ended'
            assert process.wait(10) == 0
        finally:
            process.kill()


CLOSED = """
import os, sys
from bpc_perception.__main__ import open_standard_streams
open_standard_streams()
print('nobody reads it')
print('nor this', file=sys.stderr)
sys.exit(os.open(os.devnull, os.O_RDONLY))
"""


def test_what_is_opened_is_not_taken_for_an_output_that_was_closed() -> None:
    program = ['sh', '-c', 'exec "$@" <&- >&- 2>&-', 'sh', sys.executable, '-c', CLOSED]
    assert subprocess.run(program, check=False, timeout=60).returncode >= 3
