"""The command line run as a user runs it: another process, its exit status, what it says."""

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

PATIENCE = 60.0  # for what takes a few seconds on an idle machine [s]
REFUSED = 2


def command(*arguments: object) -> list[str]:
    """What runs `bpc` with these arguments."""
    return [sys.executable, '-m', 'bpc_perception', *(str(item) for item in arguments)]


def run(*arguments: object, folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run `bpc` to its end."""
    return subprocess.run(command(*arguments), cwd=folder, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=PATIENCE, check=False)


def succeed(*arguments: object, folder: Path | None = None) -> str:
    """Run `bpc`, which is to succeed and to have nothing to complain of; its output."""
    ended = run(*arguments, folder=folder)
    assert (ended.returncode, ended.stderr) == (0, ''), ended.stderr
    return ended.stdout


def refusal(*arguments: object, folder: Path | None = None) -> str:
    """Run `bpc`, which is to refuse; the line that it says on stderr."""
    ended = run(*arguments, folder=folder)
    assert ended.returncode == REFUSED, ended.stderr or ended.stdout
    lines = ended.stderr.splitlines()
    assert len(lines) == 1, ended.stderr
    assert 'Traceback' not in ended.stdout
    return lines[0]


@contextmanager
def running(*arguments: object) -> Iterator[subprocess.Popen[str]]:
    """`bpc` while it runs; ended, if it has not, as by Ctrl-C, so that it ends its nodes."""
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
                    process.communicate(timeout=PATIENCE)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
