"""Designs as tables of points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.design.design import DesignError
from bpc_perception.files.design.read import read_design

MM = 1e-3
HEAD = 'x_mm,y_mm,z_mm,stroke,width_mm\n'


def table(folder: Path, text: str) -> Path:
    file = folder / 'design.csv'
    file.write_text(text, 'utf-8')
    return file


def test_points_alone_are_one_stroke(tmp_path: Path) -> None:
    design = read_design(table(tmp_path, '\ufeffx_mm, y_mm ,Z_MM\n0,0,0\n1,2,0\n1,2,0\n\n3,2,0\n'))
    stroke, = design.strokes
    np.testing.assert_allclose(stroke.points / MM, ((0, 0, 0), (1, 2, 0), (3, 2, 0)))
    assert np.isnan(stroke.widths).all()
    assert (stroke.layer, stroke.tool, stroke.line) == (0, 0, 2)


def test_all_columns_in_any_order(tmp_path: Path) -> None:
    design = read_design(table(tmp_path, (
        'stroke,x_mm,y_mm,z_mm,layer,tool,width_mm\n'
        '1,0,0,0,0,0,\n1,1,0,0,0,0,0.5\n1,2,0,0,0,0,\n'
        '0,2,0,5,0,0,\n'
        '2,0,1,1,1,2,9\n2,0,2,1,1,2,0.7\n')))
    one, two = design.strokes
    np.testing.assert_array_equal(one.widths / MM, (0.5, np.nan))
    assert two.widths == pytest.approx((0.7 * MM,))
    assert (two.layer, two.tool, two.line) == (1, 2, 6)


@pytest.mark.parametrize(('text', 'message'), [
    ('', 'line 1: expected the columns x_mm,y_mm,z_mm, and maybe .* found nothing; correct'),
    ('x_mm,y_mm\n0,0\n', 'line 1: expected the columns .* found x_mm,y_mm; correct'),
    ('x_mm,y_mm,z_mm,colour\n', 'line 1: expected the columns .*colour; correct'),
    ('x_mm,y_mm,z_mm,x_mm\n', 'line 1: expected the columns'),
    (HEAD, 'expected rows of points, found none; write two'),
    (HEAD + '0,0,0,1\n', 'line 2: expected 5 values, found 4; correct it'),
    (HEAD + '\n0,0,up,1,\n', "line 3: expected a coordinate within 10000 mm as z_mm, found 'up'"),
    (HEAD + '0,0,nan,1,\n', "line 2: expected a coordinate .*found 'nan'; correct"),
    (HEAD + '0,0,,1,\n', "line 2: expected a coordinate .*found ''; correct"),
    (HEAD + '0,0,1e9,1,\n', "line 2: expected a coordinate .*found '1e9'; correct"),
    (HEAD + '0,0,0,1.5,\n', "line 2: expected a whole number from 0 as stroke, found '1.5'"),
    (HEAD + '0,0,0,-1,\n', "line 2: expected a whole number from 0 as stroke, found '-1'"),
    (HEAD + '0,0,0,inf,\n', "line 2: expected a whole number from 0 as stroke, found 'inf'"),
    (HEAD + '0,0,0,1,0.0005\n', "line 2: expected a width from 0.02 to 100 mm, found '0.0005'; "
     'is it in millimetres'),
    (HEAD + '0,0,0,1,0\n', "line 2: expected a width from 0.02 to 100 mm, found '0'"),
    (HEAD + '0,0,0,0,\n1,0,0,0,\n', 'expected rows of a stroke, found travel alone; number'),
    (HEAD + '0,0,0,1,\n0,0,0,1,\n', 'line 2: expected a stroke through two points or more, found'),
    (HEAD + '"0,0\n,0,1,\n', 'line 3: expected 5 values, found 1; correct it')])
def test_a_bad_row_is_named(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=message):
        read_design(table(tmp_path, text))
