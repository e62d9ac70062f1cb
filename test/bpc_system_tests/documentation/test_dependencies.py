"""What is fetched is what was locked, and may be used."""

from __future__ import annotations

import json
from pathlib import Path
import re

import pytest

from bpc_system_tests.documentation import dependencies
from bpc_system_tests.parts.command_line import ROOT

PACKAGES = dependencies.locked()


def listed() -> dict[str, tuple[str, str]]:
    """Versions and licence of each package in docs/dependencies.md."""
    rows = re.findall(r'^\| (\S+) \| (.*?) \| (.*?) \|$', dependencies.FILE.read_text(), re.M)
    return {name: (versions, licence) for name, versions, licence in rows if name != 'package'}


@pytest.mark.parametrize('lock', dependencies.LOCKS, ids=lambda lock: str(lock.name))
def test_every_package_is_locked_by_its_hash(lock: Path) -> None:
    text = lock.read_text(encoding='utf-8')
    entries = [entry for entry in re.split(r'\n(?=\S)', text) if not entry.startswith('#')]
    assert len(entries) > 50
    for entry in entries:
        assert re.match(r'[A-Za-z0-9_.-]+==\S+', entry), entry
        assert re.search(r'--hash=sha256:[0-9a-f]{64}\b', entry), entry
    assert '://' not in re.sub(r'^ *#.*$', '', text, flags=re.M)


def test_the_javascript_reader_is_locked_by_its_hashes() -> None:
    lock = json.loads((ROOT / 'test' / 'mcap_reader' / 'package-lock.json').read_text())
    fetched = {name: entry for name, entry in lock['packages'].items() if name}
    assert len(fetched) == 4
    for entry in fetched.values():
        assert entry['integrity'].startswith('sha512-')
        assert dependencies.compatible(entry['license'])
        assert 'resolved' not in entry


def test_every_package_is_listed_with_its_versions() -> None:
    assert {name: versions for name, (versions, _) in listed().items()} == {
        name: ', '.join(sorted(versions)) for name, versions in PACKAGES.items()}


def test_every_licence_is_compatible() -> None:
    for name, (_, licence) in listed().items():
        assert dependencies.compatible(licence), (name, licence)
        # Of packages that are not for this Python nothing can be seen here.
        assert dependencies.licence(name) in ('', licence), name


def test_a_licence_that_is_not_compatible_is_told() -> None:
    assert dependencies.compatible('MIT')
    assert dependencies.compatible('GPL OR BSD')
    assert not dependencies.compatible('GPL-3.0-only')
    assert not dependencies.compatible('MIT AND GPL-3.0-only')
    assert not dependencies.compatible('')
