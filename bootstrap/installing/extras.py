"""What only some commands need: added to an environment when one of them is first called."""

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
import os
from pathlib import Path
import secrets
import shutil

from bootstrap import places
from bootstrap.installing import lock, packages
from bootstrap.installing.packages import Packages
from bootstrap.progress import note, SetupError
from bootstrap.venv import at_first, Venv

FOLDER, UNFINISHED = 'extras', '.part-'
PATH_FILE = 'bpc_extras.pth'
# By file of requirements: what for, and how much room is needed on the way [bytes].
EXTRAS = {
    'batch': ('batch', 0.5e9),
    'figures': ('--figures', 0.2e9),
    'page': ('--page', 0.2e9),
    'printability': ('printability and testprint', 0.1e9),
    'tables': ('--xlsx', 0.1e9),
    'tests': ('test and env', 0.6e9),
    'window': ('window', 0.4e9),
}
ALL = frozenset(EXTRAS)
NEEDED_BY_COMMAND = {
    'batch': {'batch'},
    'printability': {'printability'},
    'testprint': {'printability'},
    'window': {'window'},
    'study windows': {'window'},
    'test': ALL,
    'env': ALL,
}
NEEDED_BY_OPTION = {'--figures': {'figures'}, '--page': {'page'}, '--xlsx': {'tables'}}


def needed(arguments: Sequence[str]) -> set[str]:
    """Return the extras that a command line needs."""
    if '--help' in arguments or not arguments:
        return set()
    commands = arguments[0], ' '.join(arguments[:2])
    found: set[str] = set().union(*(NEEDED_BY_COMMAND.get(command, ()) for command in commands))
    return found.union(*(NEEDED_BY_OPTION.get(word, ()) for word in arguments))


def missing(venv: Venv, arguments: Sequence[str]) -> list[str]:
    """Return the extras that a command line needs and an environment lacks."""
    return sorted(name for name in needed(arguments) if not (venv.path / FOLDER / name).is_dir())


def programs(venv: Venv) -> list[Path]:
    """Return the folders with the programs of extras that are there."""
    folders = (venv.path / FOLDER / name / 'bin' for name in EXTRAS)
    return [folder for folder in folders if folder.is_dir()]


def add(venv: Venv, names: Collection[str], log: Path, patient: bool = True) -> None:
    """Add extras: each is there completely, or not at all.

    Nothing that is there is changed, so that what runs goes on.

    Raises:
        SetupError: they cannot be had; the message names what needs them.
    """
    log.write_bytes(b'')
    text = venv.lock.read_text()
    there = at_first(text)
    for name in names:
        what_for, room = EXTRAS[name]
        entries = {package: entry for package, entry in lock.part(text, [f'{name}.in']).items()
                   if package not in there}  # fmt: skip
        note(f'adding {len(entries)} packages for {what_for}')
        places.check_space(venv.root, room)
        with new(venv) as folder:
            try:
                packages.install(
                    Packages(entries, f'{name}.in', venv.python, folder), log, patient
                )
            except SetupError as error:
                raise SetupError(f'for {what_for}: {error}') from error
            put_on_path(venv)
            os.replace(folder, venv.path / FOLDER / name)


@contextmanager
def new(venv: Venv) -> Iterator[Path]:
    """Make a folder for an extra, and remove it and what killed set-ups left, unless it moved."""
    parent = venv.path / FOLDER
    parent.mkdir(exist_ok=True)
    folder = parent / f'{UNFINISHED}{secrets.token_hex(4)}'
    try:
        yield folder
    finally:
        remove_unfinished(venv)


def unfinished(venv: Venv) -> list[Path]:
    """Return what an interrupted set-up left of extras."""
    return list((venv.path / FOLDER).glob(f'{UNFINISHED}*'))


def remove_unfinished(venv: Venv) -> None:
    """Remove it; nobody else may be adding an extra."""
    for left in unfinished(venv):
        shutil.rmtree(left, ignore_errors=True)


def put_on_path(venv: Venv) -> None:
    """Let the interpreter look for modules in extras, which need not be there."""
    (packages_of,) = venv.path.glob('lib/python3*/site-packages')
    lines = ''.join(f'{os.path.relpath(venv.path / FOLDER / name, packages_of)}\n'
                    for name in EXTRAS)  # fmt: skip
    written = packages_of / f'{PATH_FILE}.new'
    written.write_text(lines)
    os.replace(written, packages_of / PATH_FILE)
