"""Finds what changed since the environment and the workspace were made."""

from collections.abc import Iterable, Iterator
import hashlib
from pathlib import Path

PACKAGES = ('bpc_interfaces', 'bpc_perception', 'bpc_sim', 'test')
PYTHON_PACKAGES = ('bpc_perception', 'bpc_sim')

# A change in the content of these files needs a build...
BUILT = ('CMakeLists.txt', 'package.xml', 'setup.py', 'setup.cfg', 'msg/*', 'srv/*', 'resource/*')
# ...of these only a new or a removed file does, since they are installed as links.
LINKED = ('config/*', 'launch/*', 'rviz/*', 'foxglove/*')
WORKSPACE_FILES = ('colcon_defaults.yaml', 'colcon.meta')


def matching(folder: Path, patterns: Iterable[str]) -> Iterator[Path]:
    """Yield the files in a folder that match one of the patterns, in a fixed order."""
    for pattern in patterns:
        yield from sorted(path for path in folder.glob(pattern) if path.is_file())


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file's content."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def workspace_manifest(root: Path) -> str:
    """Return lines of hash and file; they change exactly when `colcon build` is necessary."""
    built = list(matching(root, WORKSPACE_FILES))
    linked: list[Path] = []
    for package in PACKAGES:
        built += matching(root / package, BUILT)
        linked += matching(root / package, LINKED)
    lines = [f'{file_hash(path)} {path.relative_to(root)}' for path in built]
    lines += [f'link {path.relative_to(root)}' for path in linked]
    return ''.join(f'{line}\n' for line in lines)


def read(stamp: Path) -> str:
    """Return the content of a stamp; empty if it was never written."""
    try:
        return stamp.read_text()
    except OSError:
        return ''
