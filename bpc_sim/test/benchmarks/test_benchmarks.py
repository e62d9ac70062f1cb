"""Benchmarks refuse to time wrong results. No test looks at how fast anything is."""

import json
import subprocess

import numpy as np
import pytest

from bpc_sim.benchmarks import core, packing, profiles, setup, start
from bpc_sim.benchmarks.core_prints import spiral
from bpc_sim.benchmarks.timing import time_interleaved
from bpc_sim.cli.bench import bench


def test_the_smallest_verifies_and_is_written(tmp_path, capsys):
    bench('core', tmp_path / 'rows.json', quick=True)
    rows = json.loads((tmp_path / 'rows.json').read_text())
    assert {row['what'] for row in rows} == {
        'floor', 'default', 'paper', 'path-normal', 'transcription', 'capture after 0.2 m'}
    assert all(0 < row['median_ms'] <= row['p95_ms'] for row in rows)
    measured = {row['what']: row['MAE_mm'] for row in rows}
    assert measured['floor'] is None
    # The transcription is the same method: on whole pixels of 0.1 mm.
    assert measured['transcription'] == pytest.approx(measured['paper'], abs=0.01)
    assert 'transcription' in capsys.readouterr().out


def test_what_is_wrong_is_not_timed(monkeypatch):
    monkeypatch.setattr(core, 'measure_thickness', lambda *given: np.full(len(given[2]), 2.2e-3))
    with pytest.raises(ValueError, match=r'expected default to err by 0.02 mm .* found 0.2000'):
        core.time_methods(spiral(512, 512, 512), 100, 1)


def test_what_is_refused_is_not_right():
    drawn = spiral(512, 512, 512)
    s = drawn.deposit.curve.uniform(100)
    thickness = drawn.deposit.width(s)
    assert drawn.error_mm(s, thickness) == pytest.approx(0)
    thickness[::10] = np.nan
    assert drawn.error_mm(s, thickness) == np.inf


def test_runs_take_turns_and_slow_ones_run_once():
    order = []
    times = time_interleaved({'a': lambda: order.append('a'), 'b': lambda: order.append('b')}, 2)
    assert order == ['a', 'b'] * 3
    assert all(0 <= timing.median <= timing.p95 for timing in times.values())
    order.clear()
    time_interleaved({'a': lambda: order.append('a')}, 5, slow=0.0)
    assert order == ['a']


@pytest.mark.parametrize(('arguments', 'message'), [
    ({'name': 'nothing'}, 'bench: expected one of core, .*, found nothing'),
    ({'name': 'core', 'json_file': 'nowhere/rows.json'}, 'nowhere/rows.json: expected')])
def test_what_cannot_be_done_is_refused(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if 'json_file' in arguments:
        arguments['json_file'] = tmp_path / arguments['json_file']
    with pytest.raises(ValueError, match=message):
        bench(**arguments)


def test_a_packed_capture_is_verified_before_it_is_timed(monkeypatch):
    rows = packing.run(quick=True)
    assert [row['what'] for row in rows] == ['Image', 'PointCloud2']
    assert all(row['share'] < 0.5 for row in rows)
    monkeypatch.setattr(packing, 'unpacked', lambda data: data[1:])
    with pytest.raises(ValueError, match='expected the same Image'):
        packing.run(quick=True)


def test_parts_of_a_profile_are_verified_before_they_are_told(monkeypatch):
    row, = profiles.run(quick=True)
    assert row['share'] < 0.5
    monkeypatch.setattr(profiles, 'OF_EACH_SAMPLE', ('time',))
    monkeypatch.setattr('bpc_perception.core.growing_profile.with_change',
                        lambda before, _: before)
    with pytest.raises(ValueError, match='expected the parts to make the whole'):
        profiles.run(quick=True)


def test_only_commands_that_end_well_are_timed(tmp_path):
    with pytest.raises(ValueError, match=r'expected .* measure .* to end well, found bpc: '):
        start.run(tmp_path / 'nothing', quick=True)


FAKE = """#!/bin/sh
cd "$(dirname "$0")"
for step in '[1/3] a' '[2/3] b' '[3/3] c' ready; do echo "bpc: $step" >&2; done
mkdir -p .environments/made && echo 123456789 > .environments/made/file
exit $STATUS
"""


def test_each_step_of_a_set_up_is_timed(tmp_path, monkeypatch):
    (tmp_path / 'bpc').write_text(FAKE)
    (tmp_path / 'bpc').chmod(0o755)
    monkeypatch.setenv('STATUS', '0')
    with pytest.raises(ValueError, match='expected a git checkout'):
        setup.run(tmp_path)
    subprocess.run(['git', 'init', '--quiet', tmp_path], check=True)
    rows = setup.run(tmp_path)
    assert [row['what'] for row in rows] == [
        'virtual environment', 'packages', 'workspace', 'all']
    assert rows[-1]['seconds'] == pytest.approx(sum(row['seconds'] for row in rows[:-1]))
    assert rows[-1]['mb'] == pytest.approx(10e-6)
    monkeypatch.setenv('STATUS', '2')
    with pytest.raises(ValueError, match='expected a set-up, found bpc: ready'):
        setup.run(tmp_path)
