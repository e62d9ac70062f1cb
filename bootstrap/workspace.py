"""Builds the colcon workspace."""

from dataclasses import dataclass
import os
from pathlib import Path
import re

from bootstrap import environment, places, stamps
from bootstrap.progress import note, run_logged, SetupError
from bootstrap.venv import check_compiler, Venv

NEEDED_SPACE_BYTES = 0.1e9
# What a build is tried with: Python, ROS and our messages fit together.
TRIAL = 'import rclpy, bpc_interfaces.msg'


@dataclass(frozen=True)
class Workspace:
    """A colcon build.

    Attributes:
        venv: the environment that it was built in
        path: folder of the build
    """

    venv: Venv
    path: Path

    @property
    def places(self) -> tuple[Path, Path]:
        """The folders that must stay while something runs."""
        return self.venv.path, self.path

    def is_current(self) -> bool:
        """Tell whether it is complete and as it would be built now."""
        built = all((self.path / 'build' / package).is_dir() for package in stamps.PYTHON_PACKAGES)
        return built and places.stamp_of(self.path) == stamp(self.venv)


def stamp(venv: Venv) -> str:
    """Return the stamp of a workspace that is built from the present files."""
    return places.stamp_of(venv.path) + stamps.workspace_manifest(venv.root)


def find(venv: Venv) -> Workspace | None:
    """Return a build that is current."""
    found = (Workspace(venv, place) for place in places.existing(venv.root))
    return next((built for built in found if built.is_current()), None)


def why_colcon_failed(log_text: str) -> str:
    """Return the packages that failed, or the last line of colcon's log."""
    failed = re.findall(r'^Failed\s+<<< (\S+)', log_text, re.MULTILINE)
    if failed:
        return f'{", ".join(failed)} failing'
    return next((line for line in reversed(log_text.splitlines()) if line.strip()), 'an error')


def build(venv: Venv, log: Path) -> Workspace:
    """Run `colcon build` beside the builds that are there; the stamp is of the files before it."""
    check_compiler()
    places.check_space(venv.root, NEEDED_SPACE_BYTES)
    target = stamp(venv)
    log.write_bytes(b'')
    with places.new(venv.root, 'build') as path:
        note('[3/3] building the workspace')
        folders = [f'--{name}-base={path / name}' for name in ('build', 'install')]
        colcon = [str(venv.python), '-m', 'colcon', 'build', *folders]
        # Without, colcon lets a core rest while others on the machine work.
        given = {'MAKEFLAGS': f'-j{os.cpu_count() or 1}', **os.environ,
                 **environment.variables(venv, os.environ, None)}  # fmt: skip
        if not run_logged(colcon, log, cwd=venv.root, environment=given):
            reason = why_colcon_failed(log.read_text(errors='replace'))
            raise SetupError(
                f'expected colcon to build the workspace, found {reason} (log: {log})'
            )
        trial = [str(venv.python), '-c', TRIAL]
        given = {**os.environ, **environment.variables(venv, os.environ, path)}
        del given['RMW_IMPLEMENTATION']  # it may be missing, and most commands need none
        if not run_logged(trial, log, cwd=venv.root, environment=given):
            raise SetupError(f'expected ROS and our messages to load, found an error (log: {log})')
        places.complete(path, target)
    return Workspace(venv, path)
