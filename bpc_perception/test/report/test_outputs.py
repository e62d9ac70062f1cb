"""The files of a print of four samples that can be checked by hand."""

from dataclasses import replace
import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
from report_prints import START_NS

from bpc_perception.claims.holder import HeldError
from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.profile import Status
from bpc_perception.report import outputs
from bpc_perception.report.pages import report_page
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.result_folder import check_out, replacing, SUMMARY
from bpc_perception.report.summary import summarize

NAMES = ['profile.csv', 'summary.json', 'report.html']


def load(path):
    """Read strict JSON: refuse NaN and Infinity."""
    def refuse(name):
        raise AssertionError(f'{name} is no JSON')
    return json.loads(path.read_text('utf-8'), parse_constant=refuse)


def test_summary(tmp_path, log, provenance):
    paths = outputs.write_outputs(tmp_path / 'new' / 'folder', log, provenance)
    assert [path.name for path in paths] == NAMES
    summary = load(paths[1])
    expected = {
        'print_id': 'vase', 'method': 'paper', 'capture': 1, 'samples': 4,
        'path_length_mm': 3.0, 'thickness_mean_mm': 3.0, 'thickness_std_mm': 1.0,
        'thickness_q1_mm': 2.5, 'thickness_median_mm': 3.0, 'thickness_q3_mm': 3.5,
        'thickness_variation': 0.333333333333, 'within_10_percent': 0.0, 'fingerprint': 'abc',
        'coverage': 0.75, 'gap_count': 1, 'gap_length_mm': 1.0, 'offset_mean_mm': 0.5,
        'stamp_ns': START_NS + 10 * 10**9, 'time_s': 1_700_000_010.1234567,
        'bag': 'prints/vase.mcap', 'hand_eye': 'cell.calib', 'versions': {'bpc': '0.1.0'},
        'settings': {'method': 'paper', 'advice.dead_band': 0.03, 'offset': [0.0, None]}}
    assert {key: summary[key] for key in expected} == expected
    assert summary['verdict'] == {
        'verdict': 'FAIL', 'ended': False, 'judged': ['GAP', 'OOZE'],
        'strokes': [{'stroke': 1, 'layer': 0, 'verdict': 'FAIL', 'seen': 0.75}],
        'layers': [{'layer': 0, 'verdict': 'FAIL', 'seen': 0.75}],
        'defects': [{'kind': 'GAP', 'stroke': 1, 'layer': 0, 'start_mm': 0.5, 'end_mm': 1.5,
                     'worst_mm': 1.0, 'limit_mm': 0.8, 'samples': 1}]}
    assert summary['gaps'] == [{'start_mm': 0.5, 'end_mm': 1.5}]
    assert summary['ooze'] == []
    unknown = dict.fromkeys(('height_mean_mm', 'area_mean_mm2', 'volume_mm3', 'volume_sigma_mm3',
                             'commanded_mm3', 'delivered', 'delivered_sigma'))
    ink = {'length_mm': 4.0, 'known': 0.0, 'thickness_mean_mm': 3.0, **unknown}
    assert summary['strokes'] == [{
        'stroke': 1, 'start_mm': 0.0, 'end_mm': 3.0, 'ink_start_mm': 0.0, 'ink_end_mm': 3.0,
        'start_lag_mm': 0.0, 'end_lag_mm': 0.0, 'layer': 0, **ink}]
    assert summary['layers'] == [{'layer': 0, 'gap_count': 1, 'gap_length_mm': 1.0, **ink}]
    assert summary['ink'] == ink
    assert summary['advice'] == {
        'valid': True, 'reason': 'OVER_EXTRUSION', 'flow_rate_scale': 0.7, 'speed_scale': 1.4,
        'target_thickness_mm': 2.5, 'measured_thickness_mm': 3.0,
        'by_volume': False, 'measured_area_mm2': None, 'spreading_per_s': None,
        'expected_thickness_mm': 2.75, 'delivery': 1.2, 'delivery_sigma': 0.1, 'lag_s': 0.5,
        'flow_rate_in_force_ul_per_s': pytest.approx(5.0),
        'speed_in_force_mm_per_s': pytest.approx(3.0), 'window_start_mm': 0.0,
        'window_end_mm': 3.0, 'sample_count': 2, 'confidence': 0.5, 'measurement_age_s': 8.5,
        'valid_until_s': 1_700_000_015.1234567, 'valid_until_ns': START_NS + 15 * 10**9}


def test_every_capture_is_listed(log, provenance):
    early, measured, late = summarize(log, provenance)['captures']
    assert (early['refusal'], late['refusal']) == ('path: none started', 'no deposit')
    assert early['stamp_ns'] == START_NS - 1
    assert measured['capture'] == 1
    assert measured['processing_time_s'] == 0.25
    assert measured['samples'] == 4
    assert measured['counts'] == {'MEASURED': 2, 'GAP': 1, 'NO_DATA': 1, 'OCCLUDED': 0,
                                  'JUNCTION': 0, 'LOW_CONFIDENCE': 0, 'BARE': 0, 'OOZE': 0}
    assert (measured['ooze_count'], measured['ooze_length_mm'], measured['bare_length_mm']) == (
        0, 0.0, 0.0)


def test_nothing_measured_is_null(tmp_path, results, provenance, profile, advice):
    blind = replace(profile, status=np.full(4, Status.NO_DATA, np.uint8),
                    thickness=np.full(4, np.nan))
    results[1] = replace(results[1], profile=blind, advice=replace(
        advice, target_thickness=math.nan, measured_thickness=math.nan, measurement_age=math.nan,
        window=(math.nan, math.nan), valid=False, reason=Reason.NO_TARGET))
    summary = load(outputs.write_outputs(tmp_path, PrintLog.of(results), provenance)[1])
    assert summary['thickness_mean_mm'] is None
    assert summary['within_10_percent'] is None
    assert summary['offset_mean_mm'] is None
    assert summary['advice']['target_thickness_mm'] is None
    assert summary['coverage'] == 0.0
    assert summary['verdict'] == {
        'verdict': 'FAIL', 'ended': False, 'judged': ['GAP', 'OOZE'],
        'strokes': [{'stroke': 1, 'layer': 0, 'verdict': 'FAIL', 'seen': 0.75}],
        'layers': [{'layer': 0, 'verdict': 'FAIL', 'seen': 0.75}],
        'defects': [{'kind': 'GAP', 'stroke': 1, 'layer': 0, 'start_mm': 0.5, 'end_mm': 1.5,
                     'worst_mm': 1.0, 'limit_mm': 0.8, 'samples': 1}]}
    assert summary['gaps'] == []
    (stroke,) = summary['strokes']
    assert stroke['ink_start_mm'] is stroke['end_lag_mm'] is None


def test_only_refusals_are_told(tmp_path, results, provenance):
    with pytest.raises(ValueError, match='path: none started; no deposit'):
        outputs.write_outputs(tmp_path / 'out', PrintLog.of([results[0], results[2]]), provenance)
    assert not (tmp_path / 'out').exists()


def test_folder_is_a_file(tmp_path, log, provenance):
    (tmp_path / 'out').write_text('mine')
    with pytest.raises(OSError, match='out'):
        outputs.write_outputs(tmp_path / 'out', log, provenance)
    assert (tmp_path / 'out').read_text() == 'mine'


def test_failing_report_leaves_what_was_there(tmp_path, log, provenance, monkeypatch):
    (tmp_path / 'summary.json').write_text('yesterday')

    def fail(*_):
        raise RuntimeError('no report')
    monkeypatch.setattr(report_page, 'render', fail)
    with pytest.raises(RuntimeError, match='no report'):
        outputs.write_outputs(tmp_path, log, provenance)
    assert [path.name for path in tmp_path.iterdir()] == ['summary.json']
    assert (tmp_path / 'summary.json').read_text() == 'yesterday'


def test_files_are_whole_before_any_is_in_place(tmp_path, log, provenance, monkeypatch):
    def fail(source, _):
        assert sorted(os.listdir(os.path.dirname(source))) == sorted(NAMES)
        raise OSError('disk full')
    monkeypatch.setattr(os, 'replace', fail)
    with pytest.raises(OSError, match='disk full'):
        outputs.write_outputs(tmp_path, log, provenance)
    assert list(tmp_path.iterdir()) == []


def test_names_that_are_no_unicode(tmp_path, log, provenance):
    odd = os.fsdecode(b'vase-\xff.mcap')
    paths = outputs.write_outputs(tmp_path, log, replace(provenance, bag=odd))
    assert load(paths[1])['bag'] == odd
    assert 'vase-?.mcap' in paths[2].read_text('utf-8')


def test_summary_takes_its_place_last(tmp_path, log, provenance, monkeypatch):
    # A reader who finds the right fingerprint in it may rely on all the rest.
    moved = []
    monkeypatch.setattr(os, 'replace', lambda _, target: moved.append(target.name))
    outputs.write_outputs(tmp_path, log, provenance, figures=True)
    assert moved[-1] == 'summary.json'
    assert {'profile.csv', 'report.html', 'thickness.pdf', 'map.svg'} < set(moved)


@pytest.mark.parametrize('place', ['recording/recording_0.mcap', 'bag_0.mcap', 'old/bag_0.db3'])
def test_the_folder_of_a_recording_is_no_place_for_other_results(tmp_path: Path,
                                                                 place: str) -> None:
    """As that of a live print, whose results cannot be made again."""
    (tmp_path / place).parent.mkdir(exist_ok=True)
    (tmp_path / place).touch()
    (tmp_path / SUMMARY).write_text('{"fingerprint": ""}')
    with pytest.raises(ValueError, match='expected a folder for results of their own'):
        check_out(tmp_path)


def test_two_who_write_results_into_one_folder_never_mix_them(tmp_path: Path) -> None:
    with replacing(tmp_path / 'out') as folder:
        (folder / SUMMARY).write_text('of the first')
        with (pytest.raises(HeldError, match='out: expected to be the only one to write results'),
              replacing(tmp_path / 'out')):
            pytest.fail('expected a refusal')
    assert [file.name for file in (tmp_path / 'out').iterdir()] == [SUMMARY]
    assert (tmp_path / 'out' / SUMMARY).read_text() == 'of the first'


def test_what_a_killed_measurement_left_unfinished_is_removed(tmp_path: Path) -> None:
    (tmp_path / '.bpc-left').mkdir()
    (tmp_path / '.bpc-left' / 'profile.csv').touch()
    with replacing(tmp_path) as folder:
        (folder / SUMMARY).touch()
    assert [file.name for file in tmp_path.iterdir()] == [SUMMARY]
