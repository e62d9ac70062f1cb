"""Sets up what is missing, then runs the product's command line."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import fcntl
import os
from pathlib import Path
from typing import NoReturn

from bootstrap import environment, ros, venv, workspace
from bootstrap.progress import note, SetupError


@contextmanager
def only_one(logs: Path) -> Iterator[None]:
    """Let only one ./bpc at a time set up this checkout."""
    with (logs / 'lock').open('w') as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            note('waiting for another ./bpc that is setting this checkout up')
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def is_current(target: venv.Venv) -> bool:
    """Tell whether everything is set up."""
    return target.is_current() and workspace.is_current(target)


def set_up(target: venv.Venv) -> None:
    """Make what is missing or out of date."""
    logs = target.root / 'log' / 'setup'
    logs.mkdir(parents=True, exist_ok=True)
    with only_one(logs):
        if not target.is_current():
            if 'ROS_DISTRO' in os.environ and target.rclpy is None:
                note('the sourced ROS has no rclpy that this Python can load; using wheels')
            venv.check_prerequisites(target.root)
            venv.make(target, logs / 'pip.log')
        if not workspace.is_current(target):
            workspace.build(target, logs / 'colcon.log')
    note('ready')


def run_command_line(target: venv.Venv, arguments: Sequence[str]) -> NoReturn:
    """Replace this process by the command line."""
    values = environment.variables(target, os.environ)
    Path(values['ROS_LOG_DIR']).mkdir(parents=True, exist_ok=True)
    command = [str(target.python), '-m', 'bpc_perception', *arguments]
    os.execve(target.python, command, {**os.environ, **values})


def main(root: str, arguments: Sequence[str]) -> int:
    """Run ./bpc; return the exit status unless the command line replaces this process."""
    folder = Path(root).resolve()
    try:
        target = venv.Venv(folder, ros.stock_rclpy(os.environ, folder / '.venv'))
        if not is_current(target):
            set_up(target)
        if list(arguments) == ['env']:
            print(environment.exports(environment.variables(target, os.environ)), end='')
            return 0
        run_command_line(target, arguments)
    except SetupError as error:
        note(str(error))
        return 2
    except OSError as error:  # a full disk, a folder without write permission
        note(f'expected to set up {folder}, found: {error}')
        return 2
    except KeyboardInterrupt:
        note('interrupted; the next ./bpc goes on from here')
        return 130
