"""docs/dependencies.md: every package of the lock and its licence.

Run as a program, writes it anew, from what the installed packages say of themselves.
"""

from __future__ import annotations

from importlib import metadata
from pathlib import Path
import re
import sys
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[3]
LOCKS = [ROOT / 'bootstrap' / name for name in ('requirements.lock', 'stock.lock')]
FILE = ROOT / 'docs' / 'dependencies.md'
# What packages call their licence, in the words of SPDX; BSD = they do not say which.
WORDS = {
    'Apache Software License': 'Apache-2.0', 'Apache 2.0': 'Apache-2.0',
    'Apache License 2.0': 'Apache-2.0', 'Apache License, Version 2.0': 'Apache-2.0',
    'Apache 2': 'Apache-2.0', 'Apache License Version 2.0': 'Apache-2.0',
    'MIT License': 'MIT', 'BSD License': 'BSD', 'BSD License 2.0': 'BSD-3-Clause',
    '3-Clause BSD License': 'BSD-3-Clause', 'Mozilla Public License 2.0 (MPL 2.0)': 'MPL-2.0',
    'ISC License (ISCL)': 'ISC', 'Python Software Foundation License': 'PSF-2.0',
    'GNU General Public License (GPL)': 'GPL', 'Public Domain': 'public domain',
    'zlib License': 'Zlib', 'DFSG approved': '', 'OSI Approved': ''}
# Of packages that do not say it so that a program can read it, or that only other systems or
# Pythons need; from their own licence files.
KNOWN = {
    'async-timeout': 'Apache-2.0', 'cffi': 'MIT', 'pycparser': 'BSD-3-Clause',
    'apsw': 'any that the OSI approved', 'empy': 'LGPL-2.1-or-later', 'colorama': 'BSD-3-Clause',
    'coloredlogs': 'MIT', 'exceptiongroup': 'MIT', 'humanfriendly': 'MIT',
    'pyreadline3': 'BSD-3-Clause', 'pytz': 'MIT', 'pywin32': 'PSF-2.0', 'six': 'MIT',
    'tomli': 'MIT',
    'setuptools': 'MIT', 'ros-fastcdr': 'Apache-2.0', 'ros-fastrtps': 'Apache-2.0',
    'ros-wheels-bootstrapper': 'Apache-2.0'}
# Each lets a program under Apache-2.0 use the package. With MPL-2.0 changes of the package itself
# have to be published; with LGPL it has to stay exchangeable, as a wheel is.
COMPATIBLE = {
    '0BSD', 'Apache-2.0', 'BSD', 'BSD-2-Clause', 'BSD-3-Clause', 'CC0-1.0', 'ISC', 'MIT',
    'MPL-2.0', 'PSF-2.0', 'Python-2.0', 'Unlicense', 'Zlib', 'LGPL-2.1-or-later',
    'MIT-CMU', 'BSL-1.0', 'CNRI-Python', 'public domain', 'any that the OSI approved'}
HEADER = """# Dependencies

Every package that `./bpc` fetches, with its versions and its licence. bpc contains none of them.

This page is made by `python test/bpc_system_tests/documentation/dependencies.py` from the locks in
`bootstrap/` and from what the packages say of themselves. A test checks that it fits the locks,
and that every licence is compatible with Apache-2.0. `test/mcap_reader` has the licences of its
four packages in its own lock.

The table does not show what wheels contain in binary form. NumPy, SciPy and OpenCV contain
OpenBLAS (BSD-3-Clause) and the run-time library of GNU Fortran (GPL-3.0 with the exception for
programs that use it). OpenCV also contains FFmpeg, Shapely GEOS (both LGPL-2.1). Each is a
library of its own. Their licences are in the wheels.

| package | version | licence |
|---|---|---|
"""


def locked() -> dict[str, set[str]]:
    """Each package of the locks and its versions, of which a Python has one."""
    found: dict[str, set[str]] = {}
    for lock in LOCKS:
        for name, version in re.findall(r'^([A-Za-z0-9_.-]+)==(\S+)', lock.read_text(), re.M):
            found.setdefault(name, set()).add(version)
    return dict(sorted(found.items()))


def licence(name: str) -> str:
    """The licence of a package, as an expression; empty where it is not known."""
    if name in KNOWN:
        return KNOWN[name]
    if name.startswith('ros-'):
        return _of_ros(name.removeprefix('ros-').removeprefix('jazzy-').replace('-', '_'))
    try:
        about = metadata.metadata(name)
    except metadata.PackageNotFoundError:
        return ''
    if about.get('License-Expression'):  # KeyError or None where there is none: two libraries
        return str(about['License-Expression'])
    words = [each.rsplit(' :: ', 1)[-1] for each in about.get_all('Classifier') or []
             if each.startswith('License :: ')]
    if not any(WORDS.get(word, word) for word in words):
        words = [(about.get('License') or '').strip()]
    return ' OR '.join(dict.fromkeys(WORDS.get(word, word) for word in words
                                     if WORDS.get(word, word)))


def compatible(expression: str) -> bool:
    """Whether one of the alternatives of a licence is compatible in all of its parts."""
    return any(all(part.strip(' ()') in COMPATIBLE for part in alternative.split(' AND '))
               for alternative in expression.split(' OR '))


def page() -> str:
    """The content of docs/dependencies.md."""
    return HEADER + ''.join(
        f'| {name} | {", ".join(sorted(versions))} | {licence(name)} |\n'
        for name, versions in locked().items())


def _of_ros(package: str) -> str:
    file = Path(sys.prefix) / 'share' / package / 'package.xml'
    if not file.exists():
        return ''
    found = [str(each.text).strip() for each in ElementTree.parse(file).getroot().iter('license')]
    return ' AND '.join(dict.fromkeys(WORDS.get(each, each) for each in found))


if __name__ == '__main__':
    FILE.write_text(page(), encoding='utf-8')
