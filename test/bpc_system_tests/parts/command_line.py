"""The command line as a user runs it: another process, its exit status, its output."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import signal
import subprocess
import sys

ROOT = Path(__file__).resolve().parents[3]
SAMPLE = ROOT / 'bags' / 'spiral_gaps'
OUTPUTS = {'profile.csv', 'summary.json', 'report.html'}
SAMPLE_OUTPUTS = {*OUTPUTS, 'repair.csv'}  # the sample print has a gap

PATIENCE_S = 60.0  # for what takes a few seconds on an idle machine
REFUSED_STATUS = 2


def command(*arguments: object) -> list[str]:
    """Return the command that runs `bpc` with these arguments."""
    return [sys.executable, '-m', 'bpc_perception', *(str(item) for item in arguments)]


def run(*arguments: object, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run `bpc` to its end, in a folder."""
    return subprocess.run(command(*arguments), cwd=folder, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=PATIENCE_S, check=False)


def succeed(*arguments: object, folder: Path | None = None) -> str:
    """Run `bpc`, which has to succeed without a word on stderr; return its output."""
    ended = run(*arguments, folder=folder)
    assert (ended.returncode, ended.stderr) == (0, ''), ended.stderr
    return ended.stdout


def refusal(*arguments: object, folder: Path | None = None) -> str:
    """Run `bpc`, which has to refuse; return its line on stderr."""
    ended = run(*arguments, folder=folder)
    assert ended.returncode == REFUSED_STATUS, ended.stderr or ended.stdout
    lines = ended.stderr.splitlines()
    assert len(lines) == 1, ended.stderr
    assert 'Traceback' not in ended.stdout
    return lines[0]


@contextmanager
def running(*arguments: object) -> Iterator[subprocess.Popen[str]]:
    """Run `bpc` during the block; then end it as by Ctrl-C, so that it ends its nodes."""
    process = subprocess.Popen(command(*arguments), stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               start_new_session=True)
    try:
        with process:
            try:
                yield process
            finally:
                if process.poll() is None:
                    process.send_signal(signal.SIGINT)
                    process.communicate(timeout=PATIENCE_S)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
