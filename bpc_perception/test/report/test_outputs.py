"""profile.csv and summary.json against a print of four samples that can be checked by hand."""

import csv
from dataclasses import replace
import json
import math
import os
import weakref

import numpy as np
import pytest

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.session import Result
from bpc_perception.report import html, outputs
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance, versions

MM = 1e-3
START = 1_700_000_000_123_456_789  # a float of seconds keeps no nanoseconds of this
NAMES = ['profile.csv', 'summary.json', 'report.html']


@pytest.fixture
def profile():
    """Samples 1 mm apart along x: 2 mm, a gap, glare, 4 mm."""
    nan = math.nan
    sides = np.full((4, 3), nan)
    return ThicknessProfile(
        stamp_ns=START + 10 * 10**9, print_id='vase', print_start_ns=START, capture=1,
        method='paper', time=np.array((0.0, 0.5, 1.000000001, 1.5)),
        arc_length=np.arange(4) * MM, points=np.outer(np.arange(4), (MM, 0, 0)),
        extruding=np.ones(4, bool),
        status=np.array((Status.MEASURED, Status.GAP, Status.NO_DATA, Status.MEASURED), np.uint8),
        thickness=np.array((2 * MM, 0.0, nan, 4 * MM)), sigma=np.array((0.1 * MM, nan, nan, MM)),
        left=np.array((1.5 * MM, nan, nan, 2.5 * MM)),
        right=np.array((0.5 * MM, nan, nan, 1.5 * MM)),
        left_points=sides, right_points=sides, processing_time=0.25)


@pytest.fixture
def advice(profile):
    return RateAdvice(
        stamp_ns=profile.stamp_ns, print_id='vase', valid=True, reason=Reason.OVER_EXTRUSION,
        target_thickness=2.5 * MM, measured_thickness=3 * MM, window=(0.0, 3 * MM),
        sample_count=2, flow_rate_scale=0.7, speed_scale=1.4, confidence=0.5,
        measurement_age=8.5, valid_until_ns=profile.stamp_ns + 5 * 10**9,
        expected_thickness=2.75 * MM, delivery=1.2, delivery_sigma=0.1, lag=0.5)


@pytest.fixture
def capture(profile):
    """4 x 3 pixels of grey."""
    camera = PinholeCamera(np.array(((4.0, 0, 1.5), (0, 4.0, 1), (0, 0, 1))), np.zeros(5), 4, 3)
    return Capture(profile.stamp_ns, 'camera', np.full((3, 4, 3), 128, np.uint8),
                   np.full((3, 4, 3), np.nan, np.float32), camera)


@pytest.fixture
def results(capture, profile, advice):
    """A capture too early, one measured, one refused."""
    return [Result(replace(capture, stamp_ns=START - 1), refusal='path: none started'),
            Result(capture, np.eye(4), profile, advice),
            Result(replace(capture, stamp_ns=START + 11 * 10**9), refusal='no deposit')]


@pytest.fixture
def log(results):
    return PrintLog.of(results)


@pytest.fixture
def provenance():
    return Provenance('prints/vase.mcap', 'cell.calib', {
        'method': 'paper', 'advice.dead_band': 0.03, 'offset': (0.0, math.nan)},
        {'bpc': '0.1.0'}, WidthTargets.constant(2.5 * MM), 'abc')


def load(path):
    """Strict JSON: NaN and Infinity are refused."""
    def refuse(name):
        raise AssertionError(f'{name} is no JSON')
    return json.loads(path.read_text('utf-8'), parse_constant=refuse)


def test_csv_by_hand(profile):
    assert outputs.profile_csv(profile).split('\n') == [
        'arc_length_mm,time_s,x_mm,y_mm,z_mm,thickness_mm,sigma_mm,left_mm,right_mm,status',
        '0.0,1700000000.123456789,0.0,0.0,0.0,2.0,0.1,1.5,0.5,MEASURED',
        '1.0,1700000000.623456789,1.0,0.0,0.0,0.0,,,,GAP',
        '2.0,1700000001.123456790,2.0,0.0,0.0,,,,,NO_DATA',
        '3.0,1700000001.623456789,3.0,0.0,0.0,4.0,1.0,2.5,1.5,MEASURED',
        '']


@pytest.mark.parametrize('status', [
    Status.NO_DATA, Status.OCCLUDED, Status.JUNCTION, Status.LOW_CONFIDENCE])
def test_no_thickness_without_a_measurement(profile, status):
    doubtful = replace(profile, status=np.full(4, status, np.uint8), thickness=np.full(4, MM))
    rows = list(csv.DictReader(outputs.profile_csv(doubtful).splitlines()))
    assert [(row['thickness_mm'], row['status']) for row in rows] == [('', status.name)] * 4


def test_floats_read_back_to_the_last_bit(profile):
    points = np.random.default_rng(0).normal(size=(4, 3))
    rows = csv.DictReader(outputs.profile_csv(replace(profile, points=points)).splitlines())
    read = [[float(row[name]) for name in ('x_mm', 'y_mm', 'z_mm')] for row in rows]
    np.testing.assert_array_equal(read, points * 1e3)


def test_time_at_the_very_start_of_the_clock(profile):
    early = replace(profile, print_start_ns=7)
    assert outputs.profile_csv(early).splitlines()[1].split(',')[1] == '0.000000007'


def test_summary(tmp_path, log, provenance):
    paths = outputs.write_outputs(tmp_path / 'new' / 'folder', log, provenance)
    assert [path.name for path in paths] == NAMES
    summary = load(paths[1])
    expected = {
        'print_id': 'vase', 'method': 'paper', 'capture': 1, 'samples': 4,
        'path_length_mm': 3.0, 'thickness_mean_mm': 3.0, 'thickness_std_mm': 1.0,
        'thickness_q1_mm': 2.5, 'thickness_median_mm': 3.0, 'thickness_q3_mm': 3.5,
        'thickness_variation': 1 / 3, 'within_10_percent': 0.0, 'fingerprint': 'abc',
        'coverage': 0.75, 'gap_count': 1, 'gap_length_mm': 1.0, 'offset_mean_mm': 0.5,
        'stamp_ns': START + 10 * 10**9, 'time_s': 1_700_000_010.1234567,
        'bag': 'prints/vase.mcap', 'hand_eye': 'cell.calib', 'versions': {'bpc': '0.1.0'},
        'settings': {'method': 'paper', 'advice.dead_band': 0.03, 'offset': [0.0, None]}}
    assert {key: summary[key] for key in expected} == expected
    assert summary['gaps'] == [{'start_mm': 0.5, 'end_mm': 1.5}]
    assert summary['advice'] == {
        'valid': True, 'reason': 'OVER_EXTRUSION', 'flow_rate_scale': 0.7, 'speed_scale': 1.4,
        'target_thickness_mm': 2.5, 'measured_thickness_mm': 3.0,
        'expected_thickness_mm': 2.75, 'delivery': 1.2, 'delivery_sigma': 0.1, 'lag_s': 0.5,
        'window_start_mm': 0.0,
        'window_end_mm': 3.0, 'sample_count': 2, 'confidence': 0.5, 'measurement_age_s': 8.5,
        'valid_until_s': 1_700_000_015.1234567, 'valid_until_ns': START + 15 * 10**9}


def test_every_capture_is_listed(log, provenance):
    early, measured, late = outputs.summarize(log, provenance)['captures']
    assert (early['refusal'], late['refusal']) == ('path: none started', 'no deposit')
    assert early['stamp_ns'] == START - 1
    assert measured['capture'] == 1
    assert measured['processing_time_s'] == 0.25
    assert measured['samples'] == 4
    assert measured['counts'] == {'MEASURED': 2, 'GAP': 1, 'NO_DATA': 1, 'OCCLUDED': 0,
                                  'JUNCTION': 0, 'LOW_CONFIDENCE': 0}


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
    assert summary['gaps'] == []


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
    monkeypatch.setattr(html, 'render', fail)
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
    # Who finds the fingerprint of a result in it may rely on all the rest.
    moved = []
    monkeypatch.setattr(os, 'replace', lambda _, target: moved.append(target.name))
    outputs.write_outputs(tmp_path, log, provenance, figures=True)
    assert moved[-1] == 'summary.json'
    assert {'profile.csv', 'report.html', 'thickness.pdf', 'map.svg'} < set(moved)


def test_a_log_keeps_one_capture(results, capture):
    log = PrintLog(expected=3)
    for result in results:
        log.add(result)
    assert log.reported is results[1]
    captures = [weakref.ref(result.capture) for result in results]
    del results[:], result, capture
    # pytest holds what fixtures returned, but not what they made on the way.
    assert [kept() is not None for kept in captures] == [False, True, False]


def test_a_log_reports_the_capture_wanted(results, profile, advice, capture):
    later = Result(capture, np.eye(4), replace(profile, capture=2), advice)
    log = PrintLog(wanted=1)
    for result in (*results, later):
        log.add(result)
    assert log.reported is results[1]
    assert log.place == 1
    assert log.numbers == [1, 2]
    assert log.refusals == ['path: none started', 'no deposit']


def test_versions_name_what_can_change_a_number():
    assert set(versions()) == {'bpc', 'python', 'numpy', 'opencv', 'ros'}
    assert versions()['numpy'] == np.__version__
