"""Tables of sweeps: as `bpc testprint` writes them, and as spreadsheets do."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from bpc_perception.files.sweep_table import COLUMNS, read_sweep, SweepTableError

HEAD = ','.join(COLUMNS)
ROW = '3,2.5,10,80,25,0.81,0.01,0.35,0.02,0.23,0.01,150,0.12,0.2'


def table(folder: Path, *lines: str, encoding: str = 'utf-8', ending: str = '\n') -> Path:
    file = folder / 'sweep.csv'
    file.write_bytes((ending.join(lines) + ending).encode(encoding))
    return file


def test_a_row_in_si_units(tmp_path: Path) -> None:
    (line,) = read_sweep(table(tmp_path, HEAD, ROW))
    assert line.name == 'line 3'
    assert (line.flow, line.speed, line.pressure) == pytest.approx((2.5e-9, 0.01, 80e3))
    assert line.temperature == pytest.approx(298.15)
    assert (line.width, line.width_sigma) == pytest.approx((0.81e-3, 1e-5))
    assert (line.height, line.height_sigma) == pytest.approx((0.35e-3, 2e-5))
    assert (line.area, line.area_sigma) == pytest.approx((0.23e-6, 1e-8))
    assert (line.start_lag, line.stop_lag) == (0.12, 0.2)


def test_a_folder_stands_for_its_table(tmp_path: Path) -> None:
    table(tmp_path, HEAD, ROW)
    assert read_sweep(tmp_path, 'mon ')[0].name == 'mon line 3'


def test_columns_that_are_missing_and_cells_that_are_empty_are_not_known(tmp_path: Path) -> None:
    lines = read_sweep(table(tmp_path, 'Width_mm, speed_mm_s ,pressure_kpa', '0.8,10,60',
                             ',20,60', ',,'))
    assert [line.name for line in lines] == ['line in row 2', 'line in row 3']
    assert math.isnan(lines[1].width)
    assert all(math.isnan(line.flow) for line in lines)


@pytest.mark.parametrize('encoding', ['utf-8', 'utf-8-sig'])
@pytest.mark.parametrize('ending', ['\n', '\r\n'])
def test_spreadsheets_with_decimal_commas(tmp_path: Path, encoding: str, ending: str) -> None:
    for separator in ';\t':
        rows = ('speed_mm_s;width_mm;flow_mm3_s', '"12,5";0,81;2', '10.5;;1,5')
        lines = read_sweep(table(tmp_path, *(row.replace(';', separator) for row in rows),
                                 encoding=encoding, ending=ending))
        assert [line.speed for line in lines] == pytest.approx([12.5e-3, 10.5e-3])
        assert lines[0].width == pytest.approx(0.81e-3)
        assert math.isnan(lines[1].width)


@pytest.mark.parametrize(('lines', 'expected'), [
    (('speed_mm_s,width,flow_mm3_s', '1,1,1'), 'line 1: expected columns of .*, found width; '),
    (('speed_mm_s,width_mm,width_mm,flow_mm3_s',), 'expected each column once, found width_mm'),
    (('speed_mm_s,flow_mm3_s', '1,1'), 'expected the column width_mm, found none; add it'),
    (('speed_mm_s,width_mm', '1,1'), 'the column flow_mm3_s or pressure_kpa, found none'),
    ((HEAD,), 'line 2: expected a row for each line, found none'),
    ((), 'line 1: expected the names of the columns, found nothing'),
    ((HEAD, ROW, '1,2'), 'line 3: expected 14 cells, found 2'),
    ((HEAD, ROW.replace('0.81', 'wide')), "line 2: expected a number as width_mm, found 'wide'"),
    ((HEAD, ROW.replace('0.81', 'nan')), "expected a number as width_mm, found 'nan'"),
    ((HEAD, ROW.replace('0.81', '0')), 'expected a number above 0 as width_mm, found 0; leave it'),
    ((HEAD, ROW.replace('0.01,0.35', '0,0.35')), 'a number above 0 as width_sigma_mm'),
    ((HEAD, ROW.replace('80', '1e9')), "a number as pressure_kpa, found '1e9'"),
    ((HEAD, ROW.replace(',25,', ',298,')), None),
    ((HEAD, ROW.replace(',25,', ',500,')), 'expected -50 to 400 °C as temperature_c, found 500'),
    ((HEAD, ROW.replace(',10,', ',,')), 'line 2: expected a speed, found none'),
    (('speed_mm_s;width_mm;flow_mm3_s', '1.000,5;1;1'), "a number as speed_mm_s, found '1.000,5'"),
])
def test_refusals_name_the_line(tmp_path: Path, lines: tuple[str, ...],
                                expected: str | None) -> None:
    file = table(tmp_path, *lines)
    if expected is None:
        assert read_sweep(file)
        return
    with pytest.raises(SweepTableError, match=expected) as refusal:
        read_sweep(file)
    assert str(refusal.value).startswith(f'{file}, line ')


def test_what_is_no_table_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SweepTableError, match='No such file or directory; name a CSV file'):
        read_sweep(tmp_path)
    file = table(tmp_path, HEAD, ROW, encoding='utf-16')
    with pytest.raises(SweepTableError, match='line 1: expected text in UTF-8, found other bytes'):
        read_sweep(file)
    file.write_bytes(b'1' * 2_000_000)
    with pytest.raises(SweepTableError, match='found more than 1000000 bytes'):
        read_sweep(file)
