"""Tables for other programs, as these read them."""

import math
import re
import zipfile

import numpy as np
from openpyxl import load_workbook
import pytest
from scipy.io import loadmat, savemat

from bpc_perception.core.design.comparison import compare_with_design, WantedDesign
from bpc_perception.core.design.design import Design, DesignStroke
from bpc_perception.core.design.registration import place_at
from bpc_perception.report.profile_table import COLUMNS, DESIGN_COLUMNS, profile_csv
from bpc_perception.report.tables import workbook
from bpc_perception.report.tables.files import expect_no_others, table_files
from bpc_perception.report.tables.matlab import mat_file, matlab_name
from bpc_perception.report.tables.of_print import PROFILE, result_tables
from bpc_perception.report.tables.table import Column, Table

PRINTS = Table('prints', (
    Column('bag', str, 'the recording'), Column('gap_count', int, 'its gaps'),
    Column('width_mm', float, 'mean width')), [
        {'bag': '=HYPERLINK("http://x")', 'gap_count': 3, 'width_mm': -0.25},
        {'bag': '@SUM(1+1)', 'gap_count': None, 'width_mm': math.nan},
        {'bag': 'a\x1b[2J\udcff', 'gap_count': 0, 'width_mm': None},
        {'bag': None, 'gap_count': 1, 'width_mm': 1e-300},
        {'bag': '', 'gap_count': 1, 'width_mm': 0.1 + 0.2},
        {'bag': '#N/A', 'gap_count': 1, 'width_mm': 1.0},
        {'bag': 'ü😀\uffff', 'gap_count': 1, 'width_mm': 1.0}])


@pytest.fixture
def folder(tmp_path):
    """A folder with these tables for both programs."""
    for name, data in table_files('out', [PRINTS], ('xlsx', 'mat')).items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


def test_no_cell_of_a_workbook_is_a_formula_and_numbers_stay_numbers(folder):
    book = load_workbook(folder / 'out.xlsx')
    heading, *rows = book['prints'].iter_rows()
    assert [cell.value for cell in heading] == ['bag', 'gap_count', 'width_mm']
    assert [row[0].value for row in rows] == [
        '\'=HYPERLINK("http://x")', "'@SUM(1+1)", r'a\x1b[2J\udcff', None, None, '#N/A', 'ü😀?']
    assert {row[0].data_type for row in (*rows[:3], *rows[5:])} == {'s'}
    assert [row[1].value for row in rows] == [3, None, 0, 1, 1, 1, 1]
    assert [row[2].value for row in rows] == [-0.25, None, None, 1e-300, 0.3, 1, 1]  # 16 digits
    with zipfile.ZipFile(folder / 'out.xlsx') as archive:
        assert b'<f>' not in archive.read('xl/worksheets/sheet1.xml')


def test_a_sheet_tells_what_the_columns_mean(folder):
    rows = load_workbook(folder / 'out.xlsx')['legend'].iter_rows(values_only=True)
    assert list(rows) == [
        ('table', 'column', 'unit', 'meaning'), ('prints', 'bag', None, 'the recording'),
        ('prints', 'gap_count', None, 'its gaps'), ('prints', 'width_mm', 'mm', 'mean width')]


def test_matlab_gets_columns_and_keeps_what_is_not_known(folder):
    found = loadmat(folder / 'out.mat', simplify_cells=True)
    prints = found['prints']
    assert list(prints['bag'][:3]) == ['=HYPERLINK("http://x")', '@SUM(1+1)', 'a\x1b[2J?']
    assert [len(text) for text in prints['bag'][3:5]] == [0, 0]
    assert list(prints['bag'][5:]) == ['#N/A', 'ü😀\uffff']
    assert prints['gap_count'].tolist()[::2] == [3.0, 0.0, 1.0, 1.0]
    assert math.isnan(prints['gap_count'][1])
    assert prints['width_mm'].tolist()[3:] == [1e-300, 0.1 + 0.2, 1.0, 1.0]
    assert [math.isnan(value) for value in prints['width_mm'][:3]] == [False, True, True]
    assert list(found['legend']['unit'][2:]) == ['mm']
    assert loadmat(folder / 'out.mat')['prints']['width_mm'][0, 0].shape == (7, 1)


def test_names_are_those_that_matlab_takes(tmp_path):
    assert matlab_name('advice.target_thickness') == 'advice_target_thickness'
    assert matlab_name('3d') == 'x3d'
    assert matlab_name('_mm') == 'x_mm'
    long = Table('t', (Column('n' * 70, int, ''),), [{'n' * 70: 1}])
    (tmp_path / 'long.mat').write_bytes(mat_file([long]))
    assert list(loadmat(tmp_path / 'long.mat', simplify_cells=True)['t']) == ['n' * 63]


def test_a_table_without_rows_is_a_table(tmp_path):
    for name, data in table_files('none', [Table('prints', PRINTS.columns, [])],
                                  ('xlsx', 'mat')).items():
        (tmp_path / name).write_bytes(data)
    assert load_workbook(tmp_path / 'none.xlsx')['prints'].max_row == 1
    assert loadmat(tmp_path / 'none.mat')['prints']['bag'][0, 0].shape == (0, 1)


def test_what_excel_cannot_hold_is_refused_or_cut(monkeypatch, tmp_path):
    many = Table('t', (Column('n', int, ''),), [{'n': 1}] * 5)
    monkeypatch.setattr(workbook, 'MOST_ROWS', 5)
    with pytest.raises(ValueError, match='fewer than 5 rows for a sheet of Excel, found 5; leave'):
        workbook.workbook([many])
    long = Table('t', (Column('text', str, ''),), [{'text': 'a' * 40_000}])
    (tmp_path / 'long.xlsx').write_bytes(workbook.workbook([long]))
    cell = load_workbook(tmp_path / 'long.xlsx')['t']['A2'].value
    assert (len(cell), cell[-8:]) == (32_767, 'aa (cut)')


def test_a_file_of_bpc_is_replaced_and_one_of_others_is_not(folder):
    expect_no_others(folder / 'out', ('xlsx', 'mat'))
    expect_no_others(folder / 'other', ('xlsx', 'mat'))
    book = load_workbook(folder / 'out.xlsx')
    book.properties.lastModifiedBy = 'a person'
    book.save(folder / 'out.xlsx')
    savemat(folder / 'out.mat', {'mine': 1})
    for suffix in ('xlsx', 'mat'):
        with pytest.raises(ValueError, match=rf'out\.{suffix}: expected no file but one that bpc'):
            expect_no_others(folder / 'out', (suffix,))


@pytest.mark.parametrize('content', [
    b'', b'PK\3\4', b'no table' * 40, bytes(200), b'\x89HDF' * 99])
def test_any_other_content_is_of_others(tmp_path, content):
    for suffix in ('xlsx', 'mat'):
        (tmp_path / f'out.{suffix}').write_bytes(content)
        with pytest.raises(ValueError, match='expected no file but one that bpc wrote'):
            expect_no_others(tmp_path / 'out', (suffix,))


def test_a_profile_has_the_numbers_of_its_csv(profile):
    table, strokes, layers = result_tables(profile)
    assert [column.name for column in PROFILE] == list(COLUMNS)
    lines = profile_csv(profile).splitlines()[1:]
    for row, line in zip(table.rows, lines, strict=True):
        for value, cell in zip(row.values(), line.split(','), strict=True):
            assert value is None if cell == '' else value == type(value)(cell)
    assert [row['stroke'] for row in strokes.rows] == [1]
    for each in (table, strokes, layers):
        for row in each.rows:
            assert {column.name for column in each.columns} <= row.keys()


def test_every_column_has_a_name_that_matlab_and_people_take(profile):
    for table in result_tables(profile):
        for column in table.columns:
            assert re.fullmatch(r'[a-z]\w{0,62}', column.name)
            assert column.meaning


def test_beside_its_design_a_profile_has_the_columns_of_profile_csv(profile):
    points = profile.points
    design = Design((DesignStroke(points, np.full(len(points) - 1, 2e-3)),))
    wanted = WantedDesign('line.csv', design, place_at(0, 0, 0, 0))
    table, _, _ = result_tables(profile, compare_with_design(profile, wanted))
    assert tuple(column.name for column in table.columns) == (*COLUMNS, *DESIGN_COLUMNS)
    assert {row['design_stroke'] for row in table.rows} == {1}
    assert {row['wanted_mm'] for row in table.rows} == {2.0}
    assert table.rows[0]['nozzle_off_mm'] == pytest.approx(0)
