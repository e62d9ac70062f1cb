"""How long the first set-up of a checkout takes, with empty caches, and how large it gets."""

from __future__ import annotations

import os
from pathlib import Path
import re
import shutil
import subprocess
import tempfile
import time

from bpc_sim.benchmarks.timing import no_progress, Progress

STEPS = ('virtual environment', 'packages', 'workspace')
BEGINS = re.compile(r'^bpc: \[(\d)/3\]')
ENDS = 'bpc: ready'
# What the environment of this checkout sets; a sourced ROS needs its paths.
OURS = ('BPC_ROOT', 'VIRTUAL_ENV', 'PYTHONPATH', 'AMENT_PREFIX_PATH', 'CMAKE_PREFIX_PATH',
        'LD_LIBRARY_PATH', '_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'ROS_DISTRO')


def run(root: Path, progress: Progress = no_progress) -> list[dict[str, object]]:
    """Set a copy of a checkout up, and tell how long each step takes.

    Raises ValueError if it fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / 'checkout'
        copy_checkout(root, copy)
        times = timed(copy, Path(folder), progress)
        places = sorted((copy / '.environments').iterdir())
        size = sum(file.stat().st_size for place in places for file in place.rglob('*')
                   if file.is_file() and not file.is_symlink())
        rows = [{'what': step, 'seconds': end - begin}
                for step, begin, end in zip(STEPS, times, times[1:], strict=False)]
        return [*rows, {'what': 'all', 'seconds': times[-1] - times[0], 'mb': size / 1e6}]


def copy_checkout(root: Path, copy: Path) -> None:
    """Copy what git knows of a checkout, or does not know yet. Raises ValueError."""
    command = ['git', '-C', str(root), 'ls-files', '-co', '--exclude-standard', '-z']
    listed = subprocess.run(command, capture_output=True, check=False)
    if listed.returncode:
        raise ValueError(f'bench setup: expected a git checkout at {root}, found: '
                         f'{listed.stderr.decode(errors="replace").strip()}')
    for name in filter(None, os.fsdecode(listed.stdout).split('\0')):
        if (root / name).is_file():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(root / name, copy / name)


def timed(checkout: Path, folder: Path, progress: Progress) -> list[float]:
    """Return when each step of the set-up of a checkout began, and when the last ended [s]."""
    environment = {name: value for name, value in os.environ.items() if name not in OURS}
    environment |= {'UV_CACHE_DIR': f'{folder}/uv', 'PIP_CACHE_DIR': f'{folder}/pip',
                    'PATH': path_of_user()}
    times, said = [], []
    with subprocess.Popen([checkout / 'bpc', '--help'], env=environment, text=True,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        assert process.stderr
        for line in process.stderr:
            said.append(line)
            if BEGINS.match(line) or line.startswith(ENDS):
                times.append(time.monotonic())
                progress(len(times), len(STEPS) + 1)
    if process.returncode or len(times) != len(STEPS) + 1:
        raise ValueError(f'bench setup: expected a set-up, found {"".join(said[-1:]).strip()}')
    return times


def path_of_user() -> str:
    """Return the search path for programs without those of this environment."""
    own = os.environ.get('VIRTUAL_ENV', '')
    return os.pathsep.join(part for part in os.environ.get('PATH', '').split(os.pathsep)
                           if not (own and part.startswith(own)))
