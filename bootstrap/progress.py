"""Shows the progress of the set-up on stderr; runs long commands with their output in a log."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import get_terminal_size
import subprocess
import sys
import time

NOTE_INTERVAL_S = 20.0  # between lines of progress where there is no terminal


# The user's settings for other Pythons, which break, garble or slow ours.
PYTHON_SETTINGS = (
    'PYTHONDONTWRITEBYTECODE', 'PYTHONHOME', 'PYTHONINSPECT', 'PYTHONOPTIMIZE',
    'PYTHONPLATLIBDIR', 'PYTHONSAFEPATH', 'PYTHONWARNINGS',
)  # fmt: skip


class SetupError(Exception):
    """The set-up cannot continue; the message is the one line that the user reads."""


def note(text: str) -> None:
    """Print one line about the set-up."""
    print(f'bpc: {text}', file=sys.stderr, flush=True)


def last_line(log: Path) -> str:
    """Return the last line of a growing log that is not empty."""
    with log.open('rb') as file:
        file.seek(max(0, log.stat().st_size - 2000))
        lines = file.read().decode(errors='replace').split('\n')
    return next((line.strip() for line in reversed(lines) if line.strip()), '')


def without_settings(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without the user's settings for other Pythons."""
    return {name: value for name, value in environment.items() if name not in PYTHON_SETTINGS}


def run_logged(
    command: Sequence[str], log: Path, *, cwd: Path, environment: Mapping[str, str]
) -> bool:
    """Run a command, appending its output to a log; tell whether it succeeded.

    It ends with this process, with all that it started.
    """
    terminal = sys.stderr.isatty()
    start = shown = time.monotonic()
    guarded = [sys.executable, '-I', str(Path(__file__).with_name('guard.py')), *command]
    with log.open('ab') as output, subprocess.Popen(
        guarded, cwd=cwd, env=without_settings(environment), stdin=subprocess.PIPE,
        stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
    ) as process:  # fmt: skip
        try:
            while True:
                try:
                    return process.wait(timeout=0.3) == 0
                except subprocess.TimeoutExpired:
                    now = time.monotonic()
                    if terminal:
                        line = f'     {now - start:3.0f} s  {last_line(log)}'
                        width = get_terminal_size().columns - 1
                        print(f'\r\x1b[K{line[:width]}', end='', file=sys.stderr, flush=True)
                    elif now - shown >= NOTE_INTERVAL_S:
                        note(f'  {now - start:.0f} s so far')
                        shown = now
        finally:
            if terminal:
                print('\r\x1b[K', end='', file=sys.stderr, flush=True)
