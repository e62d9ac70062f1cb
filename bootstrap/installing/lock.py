"""Reads a lock: which packages belong to which part of the product.

The comments that uv writes say why each package is there: for a file of requirements, or for
another package.
"""

from collections.abc import Collection, Iterator
import re


def entries(lock: str) -> Iterator[tuple[str, str]]:
    """Yield name and text of each entry; some packages have one for each of two Pythons."""
    for entry in re.split(r'^(?=[A-Za-z0-9])', lock, flags=re.MULTILINE):
        name = re.match(r'([A-Za-z0-9._-]+)(==| @ )', entry)
        if name:
            yield name.group(1), entry


def reasons_of(entry: str) -> set[str]:
    """Return the files and packages that ask for an entry; without a comment, the main file."""
    found = re.findall(r'^ +#(?: +via)? +(\S.*)$', entry, re.MULTILINE)
    return {reason.removeprefix('-r bootstrap/') for reason in found if reason != 'via'} or {
        'requirements.in'
    }


def part(lock: str, files: Collection[str]) -> dict[str, str]:
    """Return the entries by package that these files of requirements ask for, one way or another.

    Args:
        lock: text of the lock
        files: names such as `page.in`
    """
    text: dict[str, str] = {}
    wanted_by: dict[str, set[str]] = {}
    for name, entry in entries(lock):
        text[name] = text.get(name, '') + entry
        wanted_by.setdefault(name, set()).update(reasons_of(entry))
    found, before = set(files), -1
    while len(found) > before:
        before = len(found)
        found |= {name for name, reasons in wanted_by.items() if reasons & found}
    return {name: text[name] for name in text if name in found}
