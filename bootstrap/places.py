"""The folders of environments and builds: made beside each other, and kept while in use.

Each is made under a name that was never used before. So nothing that runs is touched, and what an
interrupted set-up left running works in a folder that nobody will use. A stamp, written last,
makes it complete.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
import fcntl
import os
from pathlib import Path
import secrets
import shutil
import time

from bootstrap import stamps
from bootstrap.progress import note, SetupError

FOLDER = '.environments'
LINK = '.venv'  # the name by which editors know the environment of the last start
STAMP_NAME = 'bpc-stamp'
IN_USE_NAME = 'in-use'  # locked by those who use the place; its time is that of the last start
KEPT_S = 86400.0  # for shells with `./bpc env`: nothing tells whether they are still open


@contextmanager
def new(root: Path, name: str) -> Iterator[Path]:
    """Make a place; it is removed again if what is done in it fails."""
    place = root / FOLDER / f'{name}-{secrets.token_hex(4)}'
    place.mkdir(parents=True)
    try:
        (place / IN_USE_NAME).touch()
        yield place
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)  # it may have filled the disk
        raise


def check_space(root: Path, needed: float) -> None:
    """Raise SetupError if the disk has not enough room for a new place, in bytes."""
    free = shutil.disk_usage(root).free
    if free < needed:
        raise SetupError(
            f'needs {needed / 1e9:.1f} GB of disk for the set-up, '
            f'found {free / 1e9:.1f} GB free at {root}'
        )


def complete(place: Path, stamp: str) -> None:
    """Tell that a place is complete."""
    (place / STAMP_NAME).write_text(stamp)


def stamp_of(place: Path) -> str:
    """Return the stamp of a place; empty if it is not complete."""
    return stamps.read(place / STAMP_NAME)


def existing(root: Path) -> list[Path]:
    """Return all places, that of the last start first."""
    last = (root / LINK).resolve()
    found = (place for place in (root / FOLDER).glob('*') if not place.is_symlink())
    return sorted(found, key=lambda place: (place != last, place))


def hold(place: Path) -> bool:
    """Keep a place until this process ends, whatever it executes; tell whether it is there."""
    try:
        file = os.open(place / IN_USE_NAME, os.O_RDONLY)
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:  # it is being removed
        return False
    os.set_inheritable(file, True)
    with suppress(OSError):  # a folder of somebody else
        os.utime(place / IN_USE_NAME)
    return bool(stamp_of(place))


def point_to(root: Path, place: Path) -> None:
    """Let the link name a place, at once; a folder of this name stays."""
    link, temporary = root / LINK, root / FOLDER / f'link-{os.getpid()}'
    if link.resolve() == place or (link.is_dir() and not link.is_symlink()):
        return
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(place.relative_to(root))
    os.replace(temporary, link)


def running() -> bytes:
    """Return the programs, arguments and loaded files of all processes.

    This tells of those without a lock: nodes, and what was started from an editor or a shell.
    """
    texts = []
    for process in Path('/proc').glob('[0-9]*'):
        with suppress(OSError):  # it has ended, or is somebody else's
            words = (process / 'cmdline').read_bytes()
            folder = os.fsencode(os.readlink(process / 'cwd'))
            program = os.path.normpath(os.path.join(folder, words.partition(b'\0')[0]))
            texts += [program, b'\n', words, (process / 'maps').read_bytes()]
    return b''.join(texts)


def is_held(place: Path) -> bool:
    """Tell whether somebody holds a place; if not, nobody can until this process ends."""
    try:
        file = os.open(place / IN_USE_NAME, os.O_RDWR)
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:  # nobody ever could
        return False
    except OSError:
        return True
    return False


def is_recent(place: Path) -> bool:
    """Tell whether something was started from a complete place not long ago."""
    try:
        age = time.time() - (place / IN_USE_NAME).stat().st_mtime
    except OSError:
        return False
    return bool(stamp_of(place)) and age < KEPT_S


def of_earlier_versions(root: Path) -> list[Path]:
    """Return the folders that earlier versions of the set-up made, which belong together."""
    venv, build, install = root / LINK, root / 'build', root / 'install'
    found = [venv] if venv.is_dir() and not venv.is_symlink() else []
    return found + ([build, install] if stamp_of(install) else [])  # others are not ours


def unfinished(root: Path) -> list[list[Path]]:
    """Return what an interrupted set-up left."""
    return [[place] for place in existing(root) if not stamp_of(place)]


def superfluous(root: Path, used: Collection[Path]) -> list[list[Path]]:
    """Return what is to be removed once nothing uses it, whoever made it."""
    old = [place for place in existing(root) if place not in used and not is_recent(place)]
    groups = [*([place] for place in old), of_earlier_versions(root)]
    return [group for group in groups if group]


def remove_unused(groups: Iterable[Sequence[Path]]) -> None:
    """Remove groups of places of which nothing is used."""
    processes = running()
    for group in groups:
        loaded = any(os.fsencode(f'{place}{os.sep}') in processes for place in group)
        if not loaded and not any(map(is_held, group)):
            for place in group:
                remove(place)


def remove(place: Path) -> None:
    """Remove a place."""
    note(f'removing {place}, which nothing uses any more')
    (place / STAMP_NAME).unlink(missing_ok=True)
    shutil.rmtree(place, ignore_errors=True)
