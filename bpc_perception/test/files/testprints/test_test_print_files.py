"""Files of test prints: there and back, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
import re

import numpy as np
import pytest

from bpc_perception.core.testprints.flat import fusion, turns
from bpc_perception.core.testprints.plan import TestPrint
from bpc_perception.core.testprints.setup import Setup
from bpc_perception.core.testprints.stacked import lattice, line_over_lines, wall
from bpc_perception.core.testprints.sweep import lines
from bpc_perception.files.design.read import read_design
from bpc_perception.files.new_files import write_new
from bpc_perception.files.testprints.folder import write_test_print
from bpc_perception.files.testprints.path_files import g_code, path_csv
from bpc_perception.files.testprints.stroke_table import read_test_print, stroke_table

MM = 1e-3
SETUP = Setup(0.41 * MM, (60 * MM, 60 * MM))
ALL: tuple[Callable[[Setup], TestPrint], ...] = (
    lines, fusion, turns, lattice, line_over_lines, wall)


@pytest.mark.parametrize('make', ALL)
@pytest.mark.parametrize('ending', ['csv', 'gcode'])
@pytest.mark.parametrize('plunger', [np.nan, 26.7 * MM])
def test_the_design_is_read_back(make: Callable[[Setup], TestPrint], ending: str,
                                 plunger: float, tmp_path: Path) -> None:
    test = make(SETUP)
    write_test_print(tmp_path, test, plunger)
    design = read_design(tmp_path / f'{test.name}.{ending}')
    assert len(design.strokes) == len(test.design.strokes)
    for found, planned in zip(design.strokes, test.design.strokes, strict=True):
        # To the micrometre; a point of an arc that is no nearer may join its neighbour.
        assert found.points == pytest.approx(planned.points, abs=1e-6)
        assert found.widths == pytest.approx(planned.widths, abs=1e-6)
        assert found.layer == planned.layer


@pytest.mark.parametrize('make', ALL)
def test_the_plans_are_read_back(make: Callable[[Setup], TestPrint], tmp_path: Path) -> None:
    test = make(SETUP)
    write_test_print(tmp_path, test)
    found = read_test_print(tmp_path / f'{test.name}_strokes.csv')
    assert (found.name, found.nozzle, found.layer_height) == (
        test.name, pytest.approx(test.nozzle), pytest.approx(test.layer_height))
    for one, two in zip(found.plans, test.plans, strict=True):
        assert (one.part, one.pair) == (two.part, two.pair)
        for name in ('flow', 'speed', 'judged', 'lead_in', 'run_out', 'distance', 'angle',
                     'radius', 'pressure', 'temperature'):
            assert getattr(one, name) == pytest.approx(getattr(two, name), rel=1e-5, nan_ok=True)


def moves(text: str) -> list[tuple[np.ndarray, float, float]]:
    """Where each move of G-code goes [mm], its E and its F, read by hand."""
    place, found = np.zeros(3), []
    for line in text.splitlines():
        words = dict(re.findall(r'([XYZEF])(-?[\d.]+)', line)) if line[:1] == 'G' else {}
        if not words:
            continue
        goes = np.array([float(words.get(axis, place[number]))
                         for number, axis in enumerate('XYZ')])
        found.append((goes - place, float(words.get('E', 0)), float(words['F'])))
        place = goes
    return found


@pytest.mark.parametrize(('plunger', 'per_e'), [(np.nan, 1.0), (20 * MM, 100 * np.pi)])
def test_e_and_f_make_the_flow(plunger: float, per_e: float) -> None:
    """E times what it stands for, in the time that F takes, is the flow."""
    test = lines(SETUP, [0.2e-9, 0.4e-9], [2 * MM, 4 * MM])
    flows = [per_e * e / (np.linalg.norm(step) / (f / 60))
             for step, e, f in moves(g_code(test, plunger)) if e > 0]
    assert flows == pytest.approx([1e9 * plan.flow for plan in test.plans], rel=1e-3)


def test_ink_lies_where_the_nozzle_is_down_and_travel_is_lifted() -> None:
    test = lattice(SETUP)
    for step, e, _ in moves(g_code(test))[1:]:
        assert not (e > 0 and abs(step[2]) > 1e-9)
        assert not (step[2] != 0 and np.abs(step[:2]).max() > 1e-9)
    heights = {line.split(',')[2] for line in path_csv(test).splitlines()[1:]
               if line.split(',')[3] == '0'}
    assert heights == {'6.656'}  # 6 mm above the second layer


def test_a_line_is_begun_and_ended_without_ink_at_its_speed() -> None:
    test = lines(SETUP, [0.2e-9], [2 * MM, 8 * MM])
    steps = moves(g_code(test))
    laid = [index for index, (_, e, _) in enumerate(steps) if e > 0][1:]
    for index, plan in zip(laid, test.plans[1:], strict=True):
        for beside in (index - 1, index + 1):
            step, e, feed = steps[beside]
            assert e == 0
            assert feed == pytest.approx(steps[index][2])
            assert step[0] == pytest.approx(max(2.0, 1e3 * plan.speed / 2), abs=1e-3)


def test_nothing_is_written_over(tmp_path: Path) -> None:
    test = lines(SETUP)
    (tmp_path / 'lines.gcode').write_text('mine')
    with pytest.raises(ValueError, match=r'expected no lines.gcode there, found one; name'):
        write_test_print(tmp_path, test)
    assert [path.name for path in tmp_path.iterdir()] == ['lines.gcode']
    (tmp_path / 'file').write_text('')
    with pytest.raises(ValueError, match='is a file'):
        write_test_print(tmp_path / 'file' / 'folder', test)


def test_a_file_that_comes_meanwhile_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                           ) -> None:
    monkeypatch.setattr('bpc_perception.files.new_files.expect_new', lambda *_: None)
    (tmp_path / 'b').write_text('mine')
    with pytest.raises(FileExistsError):
        write_new(tmp_path, {'a': 'one', 'b': 'two'})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {'b': 'mine'}


def test_who_prints_may_fill_in(tmp_path: Path) -> None:
    test = lines(SETUP, [0.2e-9], [2 * MM])
    write_test_print(tmp_path, test)
    file = tmp_path / 'lines_strokes.csv'
    rows = file.read_text().splitlines()
    header = rows[0].split(',')
    cells = dict(zip(header, rows[2].split(','), strict=True))
    cells |= {'pressure_kpa': '85', 'temperature_c': '37.5', 'flow_mm3_s': ''}
    rows[2] = ','.join(cells[name] for name in header)
    file.write_text('\n'.join(rows) + '\n')
    plan = read_test_print(file).plans[1]
    assert (plan.pressure, plan.temperature) == (85e3, 37.5)
    assert np.isnan(plan.flow)


@pytest.mark.parametrize('separator', [';', '\t'])
def test_a_spreadsheet_may_save_it_with_decimal_commas(separator: str, tmp_path: Path) -> None:
    test = lines(SETUP, [0.2e-9], [2 * MM])
    write_test_print(tmp_path, test)
    file = tmp_path / 'lines_strokes.csv'
    planned = read_test_print(file).plans
    text = file.read_text().replace(',', separator).replace('.', ',')
    file.write_text('\ufeff' + text)
    assert repr(read_test_print(file).plans) == repr(planned)  # as NaN differs from itself


@pytest.mark.parametrize(('old', 'new', 'message'), [
    ('test,stroke', 'what,stroke', 'the columns of a stroke table, found test wrong'),
    ('lines,2,', 'lines,3,', 'strokes with other numbers'),
    ('lines,2,', 'wall,2,', 'found 2 test prints'),
    ('lines,', 'nothing,', "found the test print 'nothing'"),
    (',line,', ',wire,', "'wire' is not a valid Part"),
    (',0.41,', ',broad,', "found could not convert string to float: 'broad'"),
    (',0.41,', ',nan,', 'nozzle_mm nan'),
    (',2,2,', ',2,-2,', 'no possible flow, speed or place in stroke 2'),
    ('\nlines,4', '', 'other rows wrong')])
def test_a_table_that_is_none(old: str, new: str, message: str, tmp_path: Path) -> None:
    write_test_print(tmp_path, lines(SETUP, [0.2e-9], [2 * MM]))
    file = tmp_path / 'lines_strokes.csv'
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    with pytest.raises(ValueError, match=re.escape(message)) as refused:
        read_test_print(file)
    assert str(refused.value).startswith(f'{file}: expected')


def test_path_and_table_belong_together(tmp_path: Path) -> None:
    write_test_print(tmp_path, lines(SETUP, [0.2e-9], [2 * MM]))
    table = tmp_path / 'lines_strokes.csv'
    with pytest.raises(ValueError, match='found another name'):
        read_test_print(tmp_path / 'lines.csv')
    table.write_text(stroke_table(lines(SETUP)))
    with pytest.raises(ValueError, match='expected a plan for each of 4 strokes, found 19'):
        read_test_print(table)
    (tmp_path / 'lines.csv').unlink()
    with pytest.raises(ValueError, match='keep the path beside its stroke table'):
        read_test_print(table)
    table.unlink()
    with pytest.raises(ValueError, match='expected a readable stroke table'):
        read_test_print(table)
