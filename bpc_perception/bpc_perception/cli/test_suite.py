"""``bpc test``: the linters and all tests, from fast to slow."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys
from typing import Annotated

import typer

TEST_FOLDERS = ('bootstrap', 'bpc_perception/test', 'bpc_sim/test', 'test')
PACKAGES = ('bpc_perception', 'bpc_sim')
# Tests that wait for nodes leave a core idle. A file stays in one worker, with its fixtures.
PARALLEL = ('-n', '2', '--dist', 'loadfile')


def run_tests(
    arguments: Annotated[list[str] | None, typer.Argument(
        metavar='-- [PYTEST ARGUMENTS]', help='Handed to pytest, instead of all folders.')] = None,
) -> None:
    """Run ruff, mypy and all tests."""
    root = Path(os.environ.get('BPC_ROOT', '.'))
    steps = [['ruff', 'check', '.'],
             ['mypy', *(f'-p{package}' for package in PACKAGES)],
             ['pytest', *(arguments or (*PARALLEL, *TEST_FOLDERS))]]
    for step in steps:
        print(f'bpc: {" ".join(step)}', flush=True)
        status = subprocess.run([sys.executable, '-m', *step], cwd=root, check=False).returncode
        if status:
            raise typer.Exit(1)
