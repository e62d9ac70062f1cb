"""Chooses the Python that everything runs on.

This module has no f-strings, and newer types are in quotes: an old Python 3 can parse it and say
what is wrong.
"""

import os
import shutil
import subprocess
import sys

TYPE_CHECKING = False  # not imported from typing, which an old Python 3 may lack
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    Probe = Callable[..., 'tuple[int, ...] | None']

OLDEST = (3, 10)
NEWEST = (3, 13)
CANDIDATES = ('python3.13', 'python3.12', 'python3.11', 'python3.10')
JAZZY_PYTHON = (3, 12)  # of Ubuntu 24.04
JAZZY_CANDIDATES = ('python3.12', '/usr/bin/python3')
CHOSEN_VARIABLE = '_BPC_PYTHON_CHOSEN'  # tells the second start that the choice is made

# Prints the version. With a sourced ROS the interpreter must also be the one ROS was built for.
PROBE = 'import sys; print("%d.%d" % sys.version_info[:2])'
PROBE_ROS = PROBE + '; import rclpy'


def is_suitable(version: 'tuple[int, ...]') -> bool:
    """Tell whether there are wheels for a version (major, minor, ...)."""
    return OLDEST <= tuple(version[:2]) <= NEWEST


def probe(command: str, code: str = PROBE) -> 'tuple[int, ...] | None':
    """Return (major, minor) of a Python command, or None if it does not run, as some shims."""
    try:
        output = subprocess.check_output([command, '-c', code], stderr=subprocess.DEVNULL)
        return tuple(int(part) for part in output.decode().strip().split('.'))
    except (OSError, ValueError, subprocess.CalledProcessError):
        return None


def first_suitable(commands: 'Sequence[str]', code: str, probe: 'Probe') -> 'str | None':
    """Return the first Python command that is suitable and runs some code, or None."""
    for command in commands:
        if is_suitable(probe(command, code) or (0, 0)):
            return command
    return None


def check_asked(command: str, probe: 'Probe') -> 'tuple[str | None, str | None]':
    """Return the Python command that the user asked for and None, or None and a complaint."""
    version = probe(command)
    if version is not None and is_suitable(version):
        return command, None
    found = ' does not run' if version is None else ' is ' + '.'.join(map(str, version))
    return None, 'BPC_PYTHON should name a Python 3.10-3.13, but ' + command + found


def choose(
    environment: 'Mapping[str, str]', own_version: 'tuple[int, ...]', probe: 'Probe' = probe
) -> 'tuple[str | None, str | None]':
    """Return the command to run on instead of this interpreter (None: stay), or a complaint.

    Args:
        environment: environment variables
        own_version: version of this interpreter
        probe: see the function of that name

    Returns:
        (command or None, complaint or None)
    """
    if environment.get('BPC_PYTHON'):
        return check_asked(environment['BPC_PYTHON'], probe)
    if environment.get('ROS_DISTRO') == 'jazzy' and tuple(own_version[:2]) != JAZZY_PYTHON:
        command = first_suitable(JAZZY_CANDIDATES, PROBE_ROS, probe)
        if command:
            return command, None
    if is_suitable(own_version):
        return None, None
    command = first_suitable(CANDIDATES, PROBE, probe)
    if command:
        return command, None
    found = '.'.join(map(str, own_version[:3]))
    return None, (
        'needs Python 3.10-3.13, found ' + found + ' and none of ' + ', '.join(CANDIDATES) + '; '
        'install one, or name one in BPC_PYTHON'
    )


def run_on_suitable_python() -> None:
    """Return if this interpreter is suitable; otherwise run ./bpc on another, or end with 2."""
    if os.environ.pop(CHOSEN_VARIABLE, None):
        return
    command, complaint = choose(os.environ, tuple(sys.version_info[:3]))
    if complaint:
        sys.stderr.write('bpc: ' + complaint + '\n')
        sys.exit(2)
    if command:
        os.environ[CHOSEN_VARIABLE] = '1'
        executable = shutil.which(command) or command
        os.execv(executable, [executable, *sys.argv])
