"""profile.csv of a print of four samples."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.report.profile_table import COLUMNS, profile_csv, read_profile

MM = 1e-3


def test_csv_by_hand(profile):
    nan = np.nan
    profile = replace(
        profile, layer=np.array((0, 0, 1, 1)), seen_in=np.array((0, 0, -1, 1)),
        height=np.array((0.5 * MM, 0.0, nan, nan)),
        height_sigma=np.array((0.125 * MM, nan, nan, nan)),
        area=np.array((MM**2, 0.0, nan, nan)), area_sigma=np.array((MM**2 / 4, nan, nan, nan)),
        cause=np.array((Cause.NONE, Cause.NONE, Cause.GLARE, Cause.NONE), np.uint8))
    assert profile_csv(profile).split('\n') == [
        'arc_length_mm,time_s,x_mm,y_mm,z_mm,thickness_mm,sigma_mm,left_mm,right_mm,status,'
        'extruding,stroke,layer,height_mm,height_sigma_mm,area_mm2,area_sigma_mm2,capture,cause',
        '0.0,1700000000.123456789,0.0,0.0,0.0,2.0,0.1,1.5,0.5,MEASURED,1,1,0,0.5,0.125,1.0,0.25,0,',
        '1.0,1700000000.623456789,1.0,0.0,0.0,0.0,,,,GAP,1,1,0,0.0,,0.0,,0,',
        '2.0,1700000001.123456790,2.0,0.0,0.0,,,,,NO_DATA,1,1,1,,,,,,GLARE',
        '3.0,1700000001.623456789,3.0,0.0,0.0,4.0,1.0,2.5,1.5,MEASURED,1,1,1,,,,,1,',
        '']


@pytest.mark.parametrize('status', [
    Status.NO_DATA, Status.OCCLUDED, Status.JUNCTION, Status.LOW_CONFIDENCE,
    Status.BARE, Status.OOZE])
def test_no_thickness_without_a_measurement(profile, status):
    doubtful = replace(profile, status=np.full(4, status, np.uint8), thickness=np.full(4, MM))
    rows = list(csv.DictReader(profile_csv(doubtful).splitlines()))
    assert [(row['thickness_mm'], row['status']) for row in rows] == [('', status.name)] * 4


def test_an_unknown_extruder_is_neither_on_nor_off(profile):
    travel = replace(profile, extruding=np.array((True, False, False, True)),
                     extruder_known=np.array((True, True, False, True)),
                     stroke=np.array((1, 0, 0, 2)))
    rows = list(csv.DictReader(profile_csv(travel).splitlines()))
    assert [(row['extruding'], row['stroke']) for row in rows] == [
        ('1', '1'), ('0', '0'), ('', '0'), ('1', '2')]


def test_floats_read_back_to_the_last_bit(profile):
    points = np.random.default_rng(0).normal(size=(4, 3))
    rows = csv.DictReader(profile_csv(replace(profile, points=points)).splitlines())
    read = [[float(row[name]) for name in ('x_mm', 'y_mm', 'z_mm')] for row in rows]
    np.testing.assert_array_equal(read, points * 1e3)


def test_time_at_the_very_start_of_the_clock(profile):
    early = replace(profile, print_start_ns=7)
    assert profile_csv(early).splitlines()[1].split(',')[1] == '0.000000007'


def test_a_table_reads_back(profile, tmp_path):
    nan = np.nan
    profile = replace(
        profile, layer=np.array((0, 0, -1, 1)), stroke=np.array((1, 1, 0, 2)),
        seen_in=np.array((0, 0, -1, 1)), height=np.array((0.5 * MM, 0.0, nan, nan)),
        area=np.array((MM**2, 0.0, nan, nan)), extruder_known=np.array((True, True, False, True)),
        cause=np.array((Cause.NONE, Cause.NONE, Cause.GLARE, Cause.NONE), np.uint8))
    file = tmp_path / 'profile.csv'
    file.write_text(profile_csv(profile), 'utf-8')
    read = read_profile(file, 'vase')
    assert (read.print_id, read.print_start_ns) == ('vase', profile.print_start_ns)
    for name in ('status', 'stroke', 'layer', 'seen_in', 'cause', 'extruder_known'):
        np.testing.assert_array_equal(getattr(read, name), getattr(profile, name), name)
    for name in ('time', 'arc_length', 'points', 'thickness', 'sigma', 'left', 'right', 'height',
                 'height_sigma', 'area', 'area_sigma'):
        np.testing.assert_allclose(getattr(read, name), getattr(profile, name), 1e-12, 1e-15,
                                   err_msg=name)
    # What it does not tell is not known.
    assert np.isnan(read.left_points).all()
    assert np.isnan(read.commanded_area).all()
    assert profile_csv(read) == profile_csv(profile)


def test_an_empty_table_has_no_samples(tmp_path):
    file = tmp_path / 'profile.csv'
    file.write_text(profile_csv(ThicknessProfile.none(0)), 'utf-8')
    assert len(read_profile(file)) == 0


@pytest.mark.parametrize('text', [
    'arc_length_mm\n1\n', 'nothing', '\x00\n', ','.join(COLUMNS) + '\n' + 'x,' * 18 + '\n',
    ','.join(COLUMNS) + '\n1,2\n'])
def test_what_is_no_profile_is_refused(tmp_path, text):
    file = tmp_path / 'profile.csv'
    file.write_text(text, 'utf-8')
    with pytest.raises(ValueError, match=r'expected a profile as bpc writes it, found: .*again'):
        read_profile(file)
