"""printability.csv and the figure of the pores of lattices that can be checked by hand."""

from __future__ import annotations

import csv
from pathlib import Path
import re

import numpy as np
from printed_shapes import lattice, Line, MM, printed
import pytest

from bpc_perception.core.printability.assess import assess, Conditions, Printability
from bpc_perception.core.profile import Status
from bpc_perception.report.printability.figure import draw_pores
from bpc_perception.report.printability.files import check_out, write
from bpc_perception.report.printability.rows import COLUMNS, printability_csv


def found_in(lines: list[Line], nozzle: float = np.nan) -> Printability:
    profile = printed(lines)
    return assess(profile, Conditions(nozzle * MM, np.full(len(profile), 1 * MM)))


@pytest.fixture(scope='module')
def found() -> Printability:
    """Four pores of 3 mm, one of them hidden in part."""
    lines = lattice()
    lines[0] = Line(lines[0].corners, statuses={(2.0, 4.0): Status.OCCLUDED})
    return found_in(lines, nozzle=0.8)


@pytest.fixture(scope='module')
def rows(found: Printability) -> list[dict[str, str]]:
    return list(csv.DictReader(printability_csv(found, 'grid').splitlines()))


def test_a_row_each(rows: list[dict[str, str]], found: Printability) -> None:
    assert tuple(rows[0]) == COLUMNS
    assert {row['print'] for row in rows} == {'grid'}
    kinds = [row['row'] for row in rows]
    assert kinds == ['metric'] * len(found.metrics) + ['pore'] * 4


def test_numbers_in_millimetres(rows: list[dict[str, str]]) -> None:
    of_print = {row['metric']: row for row in rows if row['of'] == 'print'}
    assert float(of_print['pore_area']['value']) == pytest.approx(9, rel=1e-3)
    assert of_print['pore_area']['unit'] == 'mm2'
    assert of_print['pore_area']['samples'] == '3'
    assert of_print['pore_area']['note'] == '1 more are not told'
    assert float(of_print['width']['value']) == pytest.approx(1)
    assert float(of_print['width_accuracy']['value']) == pytest.approx(100)
    assert float(of_print['filament_to_nozzle_ratio']['value']) == pytest.approx(1.25)
    pore = next(row for row in rows if row['pore'] == '4')
    assert [float(pore[name]) for name in ('x_mm', 'y_mm', 'z_mm')] == pytest.approx(
        (6, 6, 0), abs=1e-3)
    assert float(pore['perimeter_mm']) == pytest.approx(12, rel=1e-3)
    assert float(pore['pr']) == pytest.approx(1, abs=1e-3)
    assert float(pore['mesh_printability_percent']) == pytest.approx(100, abs=0.1)
    assert pore['layers'] == '0 and 1'


def test_each_number_has_definition_and_source(rows: list[dict[str, str]]) -> None:
    for row in rows:
        assert row['definition']
        assert row['source']


def test_what_is_not_known_is_empty_and_has_a_reason(rows: list[dict[str, str]]) -> None:
    for row in rows:
        if row['row'] == 'metric' and not row['value']:
            assert row['note']
    pore = next(row for row in rows if row['pore'] == '1')
    assert (pore['area_mm2'], pore['pr'], pore['mesh_printability_percent']) == ('', '', '')
    assert 'not seen all around' in pore['note']


def test_the_figure_is_of_lines_and_the_same_each_time(found: Printability) -> None:
    files = draw_pores(found)
    assert set(files) == {'pores.pdf', 'pores.svg'}
    assert files == draw_pores(found)
    points = float(re.search(rb'/MediaBox \[ 0 0 ([\d.]+) ', files['pores.pdf'])[1])
    assert points / 72 * 25.4 == pytest.approx(85)
    assert b'/Subtype /Image' not in files['pores.pdf']
    assert b'<text' not in files['pores.svg']


def test_each_pair_of_layers_has_a_figure() -> None:
    lines = lattice()
    lines += [Line(line.corners, layer=line.layer + 2) for line in lines]
    assert {name for name in draw_pores(found_in(lines)) if name.endswith('.pdf')} == {
        'pores_layers_0_1.pdf', 'pores_layers_1_2.pdf', 'pores_layers_2_3.pdf'}


def test_a_print_without_pores_has_a_figure_too() -> None:
    found = found_in([Line([(0, 0), (20, 0)])])
    assert found.pores == []
    assert set(draw_pores(found)) == {'pores.pdf', 'pores.svg'}


def test_files_are_replaced_by_those_of_the_same_print_alone(
        found: Printability, tmp_path: Path) -> None:
    (tmp_path / 'mine.txt').write_text('mine')
    check_out(tmp_path, 'grid')
    files = write(tmp_path, found, 'grid', figures=True)
    assert [file.name for file in files] == ['printability.csv', 'pores.pdf', 'pores.svg']
    check_out(tmp_path, 'grid')
    write(tmp_path, found, 'grid', figures=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['mine.txt', 'printability.csv']
    with pytest.raises(ValueError, match=r"that of 'other', found that of 'grid'; name another"):
        check_out(tmp_path, 'other')


@pytest.mark.parametrize('name', ['printability.csv', 'pores.pdf'])
def test_files_of_others_stay(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text('something,else\n1,2\n')
    with pytest.raises(ValueError, match=f'found {name}; name another folder with --out'):
        check_out(tmp_path, 'grid')


def test_the_nozzle_has_a_size() -> None:
    with pytest.raises(ValueError, match='expected lengths above 0'):
        Conditions(nozzle=-1.0)
