"""Sets up what is missing, then runs the product's command line."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
import fcntl
import os
from pathlib import Path
from subprocess import SubprocessError
import sys
from typing import NoReturn

from bootstrap import environment, places, ros, venv, workspace
from bootstrap.installing import extras
from bootstrap.progress import note, SetupError, without_settings
from bootstrap.workspace import Workspace

LOGS = Path('log', 'setup')


@contextmanager
def only_one(root: Path, wait: bool = True) -> Iterator[None]:
    """Let only one ./bpc at a time change what is set up in this checkout.

    Raises:
        BlockingIOError: there is another, and this one is not to wait for it.
    """
    logs = root / LOGS
    logs.mkdir(parents=True, exist_ok=True)
    with (logs / 'lock').open('w') as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if not wait:
                raise
            note('waiting for another ./bpc that is setting this checkout up')
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def what_is_there(root: Path, rclpy: Path | None) -> Workspace | None:
    """Return environment and build if both are as they would be made now, and hold them."""
    made = venv.find(root, rclpy)
    built = workspace.find(made) if made else None
    return built if built and all(map(places.hold, built.places)) else None


def set_up(root: Path, rclpy: Path | None) -> Workspace:
    """Make what is missing or out of date, beside what is there, and hold it."""
    with only_one(root):
        places.remove_unused(places.unfinished(root))  # it takes room
        made = venv.find(root, rclpy)
        if made is None:
            if 'ROS_DISTRO' in os.environ and rclpy is None:
                note('the sourced ROS has no rclpy that this Python can load; using wheels')
            venv.check_prerequisites(root)
            made = venv.make(root, rclpy, root / LOGS / 'packages.log')
        built = workspace.find(made) or workspace.build(made, root / LOGS / 'colcon.log')
        for place in built.places:
            places.hold(place)
    note('ready')
    return built


def add_extras(root: Path, made: venv.Venv, arguments: Sequence[str]) -> None:
    """Add what the command needs beside what all need, if it is not there yet."""
    if not extras.missing(made, arguments):
        return
    may_lack_them = list(arguments) == ['env']  # a shell does without them
    try:
        with only_one(root):
            log = root / LOGS / 'extras.log'
            extras.add(made, extras.missing(made, arguments), log, patient=not may_lack_them)
    except (SetupError, OSError) as error:
        if not may_lack_them:
            raise
        note(f'{error}; going on without')


def tidy(root: Path, built: Workspace) -> None:
    """Let .venv name this environment, and remove what nothing uses."""
    with suppress(OSError):  # another ./bpc does it, or the folder is somebody else's
        if places.superfluous(root, built.places) or extras.unfinished(built.venv):
            with only_one(root, wait=False):
                places.remove_unused(places.superfluous(root, built.places))
                extras.remove_unfinished(built.venv)
        places.point_to(root, built.venv.path)


def run_command_line(built: Workspace, arguments: Sequence[str]) -> NoReturn:
    """Replace this process by the command line."""
    values = environment.variables(built.venv, os.environ, built.path)
    with suppress(OSError):  # nodes log elsewhere then
        Path(values['ROS_LOG_DIR']).mkdir(parents=True, exist_ok=True)
    python = built.venv.python
    command = [str(python), '-m', 'bpc_perception', *arguments]
    os.execve(python, command, {**without_settings(os.environ), **values})


def main(root: str, arguments: Sequence[str]) -> int:
    """Run ./bpc; return the exit status unless the command line replaces this process."""
    folder = Path(root).resolve()
    try:
        rclpy = ros.stock_rclpy(os.environ, folder)
        built = what_is_there(folder, rclpy) or set_up(folder, rclpy)
        tidy(folder, built)
        add_extras(folder, built.venv, arguments)
        if list(arguments) == ['env']:
            values = environment.variables(built.venv, os.environ, built.path)
            sys.stdout.buffer.write(os.fsencode(environment.exports(values, os.environ)))
            return 0
        run_command_line(built, arguments)
    except SetupError as error:
        note(str(error))
        return 2
    except (OSError, SubprocessError) as error:  # a full disk, no permission, a broken Python
        note(f'expected to set up {folder}, found: {error}')
        return 2
    except KeyboardInterrupt:
        note('interrupted; what was set up before is as it was')
        return 130
