"""Builds the colcon workspace."""

import os
from pathlib import Path
import re
import shutil

from bootstrap import environment, stamps
from bootstrap.progress import note, run_logged, SetupError
from bootstrap.venv import check_compiler, STAMP_NAME, Venv


def stamp(venv: Venv) -> str:
    """Return the stamp of a workspace that is built from the present files."""
    return stamps.read(venv.path / STAMP_NAME) + stamps.workspace_manifest(venv.root)


def is_current(venv: Venv) -> bool:
    """Tell whether there is nothing to build."""
    built = all((venv.root / 'build' / package).is_dir() for package in stamps.PYTHON_PACKAGES)
    return built and stamps.read(venv.root / 'install' / STAMP_NAME) == stamp(venv)


def can_build_upon(made_from: str, target: str) -> bool:
    """Tell from the stamps whether colcon can continue from an earlier build.

    It cannot in another environment, since the build contains paths of the environment; nor after
    a file was removed, since a link to it remains and makes the build fail.
    """
    before, now = (
        {line.partition(' ')[2] for line in stamp.splitlines()} for stamp in (made_from, target)
    )
    return bool(made_from) and before <= now | {''}


def why_colcon_failed(log_text: str) -> str:
    """Return the packages that failed, or the last line of colcon's log."""
    failed = re.findall(r'^Failed\s+<<< (\S+)', log_text, re.MULTILINE)
    if failed:
        return f'{", ".join(failed)} failing'
    return next((line for line in reversed(log_text.splitlines()) if line.strip()), 'an error')


def build(venv: Venv, log: Path) -> None:
    """Run `colcon build`; the stamp describes the files at its beginning."""
    check_compiler()
    root = venv.root
    target = stamp(venv)
    if not can_build_upon(stamps.read(root / 'install' / STAMP_NAME), target):
        for folder in ('build', 'install'):
            shutil.rmtree(root / folder, ignore_errors=True)
    (root / 'install').mkdir(exist_ok=True)
    (root / 'install' / STAMP_NAME).write_text('unfinished\n' + target)
    note('[3/3] building the workspace')
    log.write_bytes(b'')
    given = {**os.environ, **environment.variables(venv, os.environ, built=False)}
    command = [str(venv.python), '-m', 'colcon', 'build']
    if not run_logged(command, log, cwd=root, environment=given):
        reason = why_colcon_failed(log.read_text(errors='replace'))
        raise SetupError(f'expected colcon to build the workspace, found {reason} (log: {log})')
    (root / 'install' / STAMP_NAME).write_text(target)
