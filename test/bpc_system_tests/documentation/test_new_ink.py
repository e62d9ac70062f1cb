"""The tutorial of a new ink: each of its commands is run, and what it promises comes true."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
import re

import pytest

from bpc_system_tests.documentation.pages import read
from bpc_system_tests.documentation.walk import NEW_INK, quoted, walk

pytestmark = [pytest.mark.system]

NUMBER = re.compile(r'-?\d+\.?\d*')


@pytest.fixture(scope='module')
def there(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that the reader worked in."""
    folder = tmp_path_factory.mktemp('new_ink')
    (folder / 'said.txt').write_text(walk(NEW_INK, folder))
    return folder


def told(option: str) -> float:
    """Return the number that follows an option in the page."""
    (value,) = set(re.findall(rf'{option} ([\d.]+)', read(NEW_INK)))
    return float(value)


def is_said(line: str, said: str) -> bool:
    """Whether a line is among what was said, with nearly the same numbers."""
    words = [re.escape(word).replace(r'\ ', r'\s+')
             for word in NUMBER.split(' '.join(line.split()))]
    numbers = pytest.approx([float(each) for each in NUMBER.findall(line)], rel=0.05, abs=0.05)
    return any([float(each) for each in found.groups()] == numbers
               for found in re.finditer(f'({NUMBER.pattern})'.join(words), said))


def test_the_settings_give_the_target_by_the_law_of_the_ink(there: Path) -> None:
    found = json.loads((there / 'ink_7' / 'window' / 'window.json').read_text())['settings']
    round_mm = math.sqrt(4 / math.pi * found['flow_mm3_s'] / found['speed_mm_s'])
    assert told('--spreading') * round_mm == pytest.approx(told('--target-mm'), rel=0.03)
    assert found['start_lag_s'] == pytest.approx(told('--dead-time'), abs=0.06)
    assert found['chance'] > 0.95


def test_the_print_with_the_settings_is_good(there: Path) -> None:
    summary = json.loads((there / 'ink_7' / 'results' / 'summary.json').read_text())
    assert summary['verdict']['verdict'] == 'PASS'
    assert summary['settings']['advice.target_thickness'] == pytest.approx(
        told('--target-mm') * 1e-3)


def test_its_pores_are_those_of_strands_of_the_target(there: Path) -> None:
    with (there / 'ink_7' / 'results' / 'printability.csv').open(newline='') as stream:
        areas = [float(row['area_mm2']) for row in csv.DictReader(stream) if row['row'] == 'pore']
    assert len(areas) == (told('--strands') - 1)**2
    side = told('--pitch-mm') - told('--target-mm')
    assert areas == pytest.approx([side**2] * len(areas), rel=0.05)


def test_what_the_page_quotes_is_said(there: Path) -> None:
    said, lines = (there / 'said.txt').read_text(), quoted(read(NEW_INK))
    assert len(lines) > 5
    for line in lines:
        assert is_said(line.strip(' │'), said), line


def test_other_numbers_are_not_what_is_said() -> None:
    assert is_said('width 1.29 ± 0.02', 'a\nwidth   1.30 ± 0.02')
    assert not is_said('width 1.29 ± 0.02', 'width 1.40 ± 0.02')
    assert not is_said('width 1.29 ± 0.02', 'height 1.29 ± 0.02')
