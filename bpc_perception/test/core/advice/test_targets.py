"""Widths wanted: the same everywhere, or from a table."""

from __future__ import annotations

from pathlib import Path
import re

import numpy as np
import pytest

from bpc_perception.core.targets import WidthTargets


def test_a_constant_is_the_same_everywhere() -> None:
    np.testing.assert_array_equal(
        WidthTargets.constant(2e-3).at(np.array((-1.0, 0.0, 5.0))), (2e-3, 2e-3, 2e-3))


def test_a_table_is_linear_between_rows_constant_beyond_and_may_step(tmp_path: Path) -> None:
    file = tmp_path / 'targets.csv'
    file.write_text('arc_length_mm,thickness_mm\n10,2\n20,3\n20,1\n')
    targets = WidthTargets.read(file)
    assert targets.at(np.array((0, 0.01, 0.015, 0.0199999, 0.0200001, 1))) == pytest.approx(
        (2e-3, 2e-3, 2.5e-3, 3e-3, 1e-3, 1e-3), abs=1e-7)


@pytest.mark.parametrize(('text', 'message'), [
    ('', 'expected the columns arc_length_mm,thickness_mm in its first line, found nothing'),
    ('s,w\n0,2\n', 'expected the columns .* found s,w'),
    ('arc_length_mm,thickness_mm\n', 'expected rows of two numbers, found none'),
    ('arc_length_mm,thickness_mm\n\n0,wide\n', "expected two numbers .*'0,wide' in line 3; "),
    ('arc_length_mm,thickness_mm\n0,2\n1\n', "expected two numbers .* found '1' in line 3; "),
    ('arc_length_mm,thickness_mm\n0,2,3\n', "expected two numbers .* '0,2,3' in line 2; "),
    ('arc_length_mm;thickness_mm\n0;2,1\n', 'expected the columns arc_length_mm,thickness_mm .*'
     'found arc_length_mm;thickness_mm'),
    ('arc_length_mm,thickness_mm\n1,2\n0,2\n', 'expected arc lengths in order'),
    ('arc_length_mm,thickness_mm\n0,nan\n', 'expected arc lengths in order')])
def test_what_is_no_table_is_refused(text: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / 'targets.csv'
    file.write_text(text)
    with pytest.raises(ValueError, match=message):
        WidthTargets.read(file)


@pytest.mark.parametrize('value', ['0', '-2', '0.002', '2000', '1e+300'])
def test_a_thickness_in_another_unit_is_refused(value: str, tmp_path: Path) -> None:
    file = tmp_path / 'targets.csv'
    file.write_text(f'arc_length_mm,thickness_mm\n0,2\n5,{value}\n')
    with pytest.raises(ValueError, match=re.escape(
            f'expected thicknesses from 0.02 to 100 mm, found {value}; are they in millimetres?')):
        WidthTargets.read(file)
