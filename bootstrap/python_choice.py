"""Chooses the Python that everything runs on.

Without f-strings and with newer types in quotes, so that an old Python 3 parses it and says
what is wrong.
"""

import os
import shutil
import subprocess
import sys

TYPE_CHECKING = False  # typing has it, but not for every Python 3
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    Probe = Callable[..., 'tuple[int, ...] | None']

OLDEST = (3, 10)
NEWEST = (3, 13)
CANDIDATES = ('python3.13', 'python3.12', 'python3.11', 'python3.10')
CHOSEN = '_BPC_PYTHON_CHOSEN'  # tells the second start that the choice is made

# Prints the version; with a sourced ROS the interpreter must also be the one ROS was built for.
PROBE = 'import sys; print("%d.%d" % sys.version_info[:2])'
PROBE_ROS = PROBE + '; import rclpy'


def is_suitable(version: 'tuple[int, ...]') -> bool:
    """Whether (major, minor, ...) is a version that the wheels exist for."""
    return OLDEST <= tuple(version[:2]) <= NEWEST


def probe(command: str, code: str = PROBE) -> 'tuple[int, ...] | None':
    """The (major, minor) of a Python command, or None if it does not run (a shim may not)."""
    try:
        output = subprocess.check_output([command, '-c', code], stderr=subprocess.DEVNULL)
        return tuple(int(part) for part in output.decode().strip().split('.'))
    except (OSError, ValueError, subprocess.CalledProcessError):
        return None


def choose(
    environment: 'Mapping[str, str]', own_version: 'tuple[int, ...]', probe: 'Probe' = probe
) -> 'tuple[str | None, str | None]':
    """The command to run on instead of this interpreter (None: stay), or a complaint.

    Args:
        environment: environment variables
        own_version: version of this interpreter
        probe: as the function of that name

    Returns:
        (command or None, complaint or None)
    """
    asked = environment.get('BPC_PYTHON')
    if asked:
        version = probe(asked)
        if version is not None and is_suitable(version):
            return asked, None
        found = ' does not run' if version is None else ' is ' + '.'.join(map(str, version))
        return None, 'BPC_PYTHON should name a Python 3.10-3.13, but ' + asked + found
    if environment.get('ROS_DISTRO') == 'jazzy' and tuple(own_version[:2]) != (3, 12):
        for command in ('python3.12', '/usr/bin/python3'):  # Ubuntu 24.04's
            if is_suitable(probe(command, PROBE_ROS) or (0, 0)):
                return command, None
    if is_suitable(own_version):
        return None, None
    for command in CANDIDATES:
        if is_suitable(probe(command) or (0, 0)):
            return command, None
    found = '.'.join(map(str, own_version[:3]))
    return None, (
        'needs Python 3.10-3.13, found ' + found + ' and none of ' + ', '.join(CANDIDATES) + '; '
        'install one, or name one in BPC_PYTHON'
    )


def run_on_suitable_python() -> None:
    """Return if this interpreter will do, else run ./bpc again on a better one or end with 2."""
    if os.environ.pop(CHOSEN, None):
        return
    command, complaint = choose(os.environ, tuple(sys.version_info[:3]))
    if complaint:
        sys.stderr.write('bpc: ' + complaint + '\n')
        sys.exit(2)
    if command:
        os.environ[CHOSEN] = '1'
        executable = shutil.which(command) or command
        os.execv(executable, [executable, *sys.argv])
