"""Prints beside each other, from files written by hand."""

import json

import numpy as np
import pytest

from bpc_perception.report import comparison
from bpc_perception.report.entries import design_numbers
from bpc_perception.report.pages import comparison_page

HEAD = 'arc_length_mm,time_s,x_mm,y_mm,z_mm,thickness_mm,sigma_mm,left_mm,right_mm,status\n'
SUMMARY = {
    'print_id': 'p', 'capture': 1, 'thickness_mean_mm': 2.0, 'thickness_variation': 0.05,
    'coverage': 0.5, 'gap_count': 1, 'gap_length_mm': 1.0, 'bag': 'a.mcap', 'hand_eye': 'c.calib',
    'settings': {'method': 'paper'}, 'versions': {'bpc': '0.1.0'}}


def left_behind(folder, **changes):
    folder.mkdir(parents=True)
    (folder / 'summary.json').write_text(json.dumps({**SUMMARY, **changes}))
    (folder / 'profile.csv').write_text(
        HEAD + '0.0,1.0,0,0,0,2.0,0.1,1.0,1.0,MEASURED\n1.0,1.1,1,0,0,0.0,,,,GAP\n'
        '2.0,1.2,2,0,0,,,,,NO_DATA\n3.0,1.3,3,0,0,4.0,0.1,2.0,2.0,MEASURED\n')
    return folder


def test_files_are_read_as_they_are(tmp_path):
    one, other = comparison.load([left_behind(tmp_path / 'a'), left_behind(tmp_path / 'b')])
    assert (one.name, other.name) == ('a', 'b')
    np.testing.assert_array_equal(one.arc_length, (0, 1, 2, 3))
    np.testing.assert_array_equal(one.thickness, (2, 0, np.nan, 4))
    np.testing.assert_array_equal(one.measured, (True, False, False, True))
    np.testing.assert_array_equal(one.gap, (False, True, False, False))


def test_folders_of_one_name_are_told_apart(tmp_path):
    folders = [left_behind(tmp_path / name / 'out') for name in 'ab']
    assert [each.name for each in comparison.load(folders)] == [str(each) for each in folders]


def test_the_folder_of_several_prints_stands_for_all_of_them(tmp_path):
    several = tmp_path / 'out'
    folders = [left_behind(several / f'print_{number}') for number in (1, 2)]
    (several / 'summary.json').write_text(json.dumps(
        {'prints': [{'print': number, 'folder': f'print_{number}'} for number in (1, 2)]}))
    assert [each.name for each in comparison.load([several])] == ['print_1', 'print_2']
    assert len(comparison.load([several, folders[0], left_behind(tmp_path / 'b')])) == 4


def test_one_print_is_not_compared(tmp_path):
    with pytest.raises(ValueError, match='expected two prints or more, found one'):
        comparison.load([left_behind(tmp_path / 'a')])


@pytest.mark.parametrize('summary', ['[]', '{"prints": [1]}', '{"prints": 3}', 'no'])
def test_a_summary_of_another_kind_is_refused(tmp_path, summary):
    folders = [left_behind(tmp_path / name) for name in 'ab']
    (folders[1] / 'summary.json').write_text(summary)
    with pytest.raises(ValueError, match=r'b/summary\.json: expected '):
        comparison.load(folders)


def test_table_has_numbers_or_dashes(tmp_path):
    row, _ = comparison.rows(comparison.load([left_behind(tmp_path / 'a'),
                                              left_behind(tmp_path / 'b')]))
    words = dict(zip(['print', 'verdict', *(column.heading for column in comparison.COLUMNS)],
                     comparison.cells(row), strict=True))
    assert (words['mean [mm]'], words['variation [%]'], words['gaps']) == ('2.000', '5.0', '1')
    assert words['Q1 [mm]'] == '-'


@pytest.mark.parametrize('odd', [
    {'verdict': {'verdict': 'REWORK'}}, {'verdict': 'PASS'}, {'settings': 'none'},
    {'settings': {'advice.target_thickness': '2'}}])
def test_a_summary_of_another_version_is_compared_all_the_same(tmp_path, odd):
    print_ = comparison.load([left_behind(tmp_path / 'a', **odd), left_behind(tmp_path / 'b')])[0]
    assert (print_.verdict, print_.target_mm) == ('-', None)


def test_only_what_differs_is_told(tmp_path):
    prints = comparison.load([left_behind(tmp_path / 'a'), left_behind(
        tmp_path / 'b', settings={'method': 'cross_section'})])
    assert comparison.differences(prints) == [('method', ['paper', 'cross_section'])]
    assert comparison.differences([prints[0], prints[0]]) == []


def test_page_loads_nothing_and_names_stay_text(tmp_path):
    prints = comparison.load([left_behind(tmp_path / 'a<b>'), left_behind(tmp_path / 'b')])
    page = comparison_page.render(prints)
    head, body = page.split('</head>')
    assert "default-src 'none'" in head
    assert 'a<b>' not in body.replace('a\\u003cb\\u003e', '')
    assert 'a&lt;b&gt;' in body
    assert ' src=' not in body
    assert ' href=' not in body


@pytest.mark.parametrize(('file', 'text', 'words'), [
    ('summary.json', '{', 'expected a summary as JSON'),
    ('summary.json', '{}', 'expected print_id, found none'),
    ('profile.csv', 'a,b\n1,2\n', 'expected a profile'),
    ('profile.csv', HEAD + '0,0,0,0,0,wide,,,,MEASURED\n', 'expected a profile'),
    ('profile.csv', HEAD + '0,0,0,0,0,1,,,,UNHEARD_OF\n', 'expected a profile')])
def test_other_files_are_refused(tmp_path, file, text, words):
    folder = left_behind(tmp_path / 'a')
    (folder / file).write_text(text)
    with pytest.raises(ValueError, match=words):
        comparison.load([folder, folder])


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r'expected a folder .*, found no profile\.csv'):
        comparison.load([tmp_path, tmp_path])


def test_layers_are_compared_one_beside_the_other(tmp_path):
    layers = [{'layer': number, 'length_mm': 100.0, 'known': 1.0, 'thickness_mean_mm': 1.3,
               'height_mean_mm': 0.4, 'area_mean_mm2': 0.34, 'volume_mm3': 34.0 + number,
               'volume_sigma_mm3': 1.0, 'delivered': 0.95, 'gap_count': 0} for number in (0, 1)]
    prints = comparison.load([left_behind(tmp_path / 'a', layers=layers),
                              left_behind(tmp_path / 'b', layers=layers[:1])])
    rows = comparison.layer_rows(prints)
    assert [(layer, number) for layer, number, _ in rows] == [(0, 0), (0, 1), (1, 0)]
    assert rows[2][2] == ['100.0', '100.0', '1.300', '0.400', '0.340', '35.0', '1.0', '95.0', '0']
    assert 'Layer by layer' in comparison_page.render(prints)


def test_without_layers_and_volumes_there_is_no_such_table(tmp_path):
    flat = [{'layer': 0, 'length_mm': 100.0, 'known': 0.0, 'volume_mm3': None}]
    prints = comparison.load([left_behind(tmp_path / 'a', layers=flat),
                              left_behind(tmp_path / 'b')])
    assert comparison.layer_rows(prints) == []
    assert 'Layer by layer' not in comparison_page.render(prints)


@pytest.mark.parametrize(('design', 'off', 'fidelity'), [
    (None, None, None), ({'refusal': 'two places'}, None, None),
    ({'refusal': '', 'bead_off': {'most_of_95_mm': 0.05}, 'layers': []}, 0.05, None),
    ({'refusal': '', 'bead_off': {'most_of_95_mm': None}, 'layers': [
        {'fidelity': 1.0, 'known': 30}, {'fidelity': 0.5, 'known': 10},
        {'fidelity': None, 'known': 0}]}, None, 0.875)])
def test_how_far_a_print_is_from_its_design_is_told_where_it_is_known(design, off, fidelity):
    found = design_numbers({'design': design} if design else {})
    assert found == {'design_off_mm': off, 'layer_fidelity': fidelity}
