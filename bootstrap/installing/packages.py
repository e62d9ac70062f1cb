"""Installs packages of a lock: with uv where it can be had, or with pip, ten times as slowly."""

import ast
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
import os
from pathlib import Path
import re
import shutil
import subprocess

from bootstrap.progress import note, run_logged, SetupError, without_settings

# What is installed first: packages published as source only are built with it.
BUILD_TOOLS = ('setuptools', 'wheel')
INSTALLER = 'uv'
ONLY_THE_LOCK = ('--require-hashes', '--no-deps', '--no-build-isolation')
# Patterns in the log of pip or uv, and what they mean. The first that matches is the reason.
FAILURES = (
    (r'No space left on device', 'the disk is full'),
    (r'DO NOT MATCH THE HASHES|Hash mismatch', 'a package whose content differs from the lock'),
    (
        r'Retrying \(|NewConnectionError|ConnectTimeout|ProxyError|error sending request|'
        r'Network connectivity is disabled',
        'no connection',
    ),
)
# Settings of pip, and the variables of uv that mean the same, with what separates their values.
VARIABLES = {
    'index-url': ('UV_DEFAULT_INDEX', ' '),
    'extra-index-url': ('UV_INDEX', ' '),
    'find-links': ('UV_FIND_LINKS', ','),
    'trusted-host': ('UV_INSECURE_HOST', ' '),
    'cert': ('SSL_CERT_FILE', ' '),
    'proxy': ('ALL_PROXY', ' '),
}
SECTIONS = ('global', 'install', ':env:')  # of pip's settings; the later ones win
TRUE = ('1', 'true', 't', 'yes', 'y', 'on')
# For who can do without the packages: no time is lost where there is no network.
HASTY = {'UV_HTTP_TIMEOUT': '5', 'UV_HTTP_RETRIES': '0'}


@dataclass(frozen=True)
class Packages:
    """Packages to install, and where.

    Attributes:
        entries: of the lock, by package
        source: name of the lock
        python: the interpreter that will import them
        folder: to write to; None: the site-packages of the interpreter
    """

    entries: Mapping[str, str]
    source: str
    python: Path
    folder: Path | None = None

    def of(self, names: Collection[str]) -> 'Packages':
        """Return these packages only."""
        entries = {name: self.entries[name] for name in names if name in self.entries}
        return Packages(entries, self.source, self.python, self.folder)


def install(packages: Packages, log: Path, patient: bool = True) -> None:
    """Install exactly these packages; without patience only if uv gets them at once.

    Raises:
        SetupError: they cannot be had.
    """
    with working_folder(packages.python) as work:
        if packages.folder is None:
            tools = packages.of((*BUILD_TOOLS, INSTALLER))
            if not with_pip(tools, work, log):
                note('uv cannot be had; pip takes some minutes')
                demand(with_pip(packages.of(BUILD_TOOLS), work, log), packages, log)
        installed = with_uv(packages, work, log, {} if patient else HASTY)
        if not installed and patient:
            installed = with_pip(packages, work, log)
        demand(installed, packages, log)


@contextmanager
def working_folder(python: Path) -> Iterator[Path]:
    """Make a folder for downloads: on the disk that was looked at."""
    work = python.parent.parent / 'downloads'
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    try:
        yield work
    finally:
        shutil.rmtree(work, ignore_errors=True)


def demand(installed: bool, packages: Packages, log: Path) -> None:
    """Raise SetupError if packages were not installed."""
    if not installed:
        raise SetupError(
            f'expected the packages of bootstrap/{packages.source} from the package index, '
            f'found: {why_it_failed(log.read_text(errors="replace"))} (log: {log})'
        )


def with_pip(packages: Packages, work: Path, log: Path) -> bool:
    """Install with pip; tell whether it succeeded."""
    command = [
        *(str(packages.python), '-m', 'pip', 'install', '--no-compile', '--use-pep517'),
        *ONLY_THE_LOCK, *arguments(packages, work),
    ]  # fmt: skip
    return run_logged(command, log, cwd=work, environment={**settings(), 'TMPDIR': str(work)})


def with_uv(packages: Packages, work: Path, log: Path, how: Mapping[str, str]) -> bool:
    """Install with uv, from where pip would take the packages; tell whether it succeeded."""
    uv = packages.python.with_name(INSTALLER)
    if not uv.exists():
        return False
    given = pip_settings(packages.python)
    # The user's settings of uv are for other projects, and may lead elsewhere.
    command = [
        *(str(uv), 'pip', 'install', '--python', str(packages.python), '--no-progress'),
        *('--no-config', '--index-strategy', 'unsafe-best-match'),  # as pip; the hash decides
        *(('--no-index',) if given.get('no-index', '').lower() in TRUE else ()),
        *ONLY_THE_LOCK, *arguments(packages, work),
    ]  # fmt: skip
    environment = {
        key: value for key, value in settings().items()
        if not key.startswith('UV_') or key == 'UV_CACHE_DIR'
    }  # fmt: skip
    environment |= {**uv_variables(given), **how}
    return run_logged(command, log, cwd=work, environment=environment)


def arguments(packages: Packages, work: Path) -> list[str]:
    """Return what pip and uv are called with alike, after writing what they read."""
    requirements = work / 'packages.lock'
    requirements.write_text(''.join(packages.entries.values()))
    target = [] if packages.folder is None else ['--target', str(packages.folder)]
    return ['-r', str(requirements), *target]


def settings() -> dict[str, str]:
    """Return the user's environment, and how pip is to be in it."""
    return {
        **{key: value for key, value in os.environ.items() if key != 'PYTHONPATH'},
        '_ROS_WHEELS_BOOTSTRAP_COMPLETE': '1',  # pip needs none of the ROS libraries
        'PIP_DISABLE_PIP_VERSION_CHECK': '1',
        'PIP_NO_INPUT': '1',
        'PIP_PROGRESS_BAR': 'off',
    }


def pip_settings(python: Path) -> dict[str, str]:
    """Return how pip is set, by files and by the environment, since uv reads neither."""
    command = [str(python), '-m', 'pip', 'config', 'list']
    ended = subprocess.run(
        command, env=without_settings(settings()), stdin=subprocess.DEVNULL, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    return read_settings(ended.stdout)


def read_settings(listed: str) -> dict[str, str]:
    """Return the values that `pip config list` printed; those in the environment win."""
    found = re.findall(r"^(\S+?)\.([\w-]+)=('.*'|\".*\")$", listed, re.MULTILINE)
    ranked = sorted(
        (SECTIONS.index(section), name, value)
        for section, name, value in found if section in SECTIONS
    )  # fmt: skip
    return {name: str(ast.literal_eval(value)) for _, name, value in ranked}


def uv_variables(given: Mapping[str, str]) -> dict[str, str]:
    """Return the variables of uv that mean the same as settings of pip.

    They may hold passwords, which everybody could read in a command.
    """
    return {
        variable: separator.join(given[name].split())
        for name, (variable, separator) in VARIABLES.items() if name in given
    }  # fmt: skip


def why_it_failed(log_text: str) -> str:
    """Return the reason of a failed installation in a few words, and the first error of pip."""
    meaning = next((text for pattern, text in FAILURES if re.search(pattern, log_text)), '')
    errors = re.findall(r'^\s*ERROR: (.*)$', log_text, re.MULTILINE)
    return '; '.join(part for part in (meaning, *errors[:1]) if part) or 'an error'
