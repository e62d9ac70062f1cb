"""The sample bag: another library reads it, and its print has a known truth."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.recording.inputs import load
from bpc_perception.recording.offline import measure_bag
from bpc_sim.printer.scenarios import spiral_gaps
from bpc_system_tests.parts.command_line import SAMPLE
from bpc_system_tests.parts.print_comparison import (
    compare,
    Comparison,
    expect_the_truth,
    MILLIMETRE_M,
    pixel_size,
)

pytestmark = [pytest.mark.system, pytest.mark.ros]

CAPTURES = 5
JOB = spiral_gaps()


@pytest.fixture(scope='module')
def profiles() -> list[ThicknessProfile]:
    """The profile of each capture."""
    given = load(SAMPLE, None, None)
    results = list(measure_bag(given.bag, given.hand_eye, given.thickness, given.recorder))
    assert all(result.profile is not None for result in results)
    return [result.profile for result in results if result.profile is not None]


@pytest.fixture(scope='module')
def final(profiles: list[ThicknessProfile]) -> Comparison:
    """The profile of the complete print, compared with the truth."""
    return compare(profiles[-1], JOB)


def test_another_library_reads_it() -> None:
    with Reader(SAMPLE) as reader:
        found = {each.topic: (each.msgtype, each.msgcount) for each in reader.connections}
        counted = dict.fromkeys(found, 0)
        for connection, _, data in reader.messages():
            counted[connection.topic] += 1
            assert len(data) > 40
        assert reader.duration == pytest.approx((JOB.duration + 0.5) * 1e9, rel=1e-3)
    poses, states = round((JOB.duration + 0.5) * 100), round((JOB.duration + 0.5) * 50)
    assert found == {
        '/color/image_color': ('sensor_msgs/msg/Image', CAPTURES),
        '/color/camera_info': ('sensor_msgs/msg/CameraInfo', CAPTURES),
        '/points/xyzrgba': ('sensor_msgs/msg/PointCloud2', CAPTURES),
        '/end_effector_pose': ('geometry_msgs/msg/PoseStamped', pytest.approx(poses, abs=1)),
        '/extrusion_state': ('bpc_interfaces/msg/ExtrusionState', pytest.approx(states, abs=1)),
    }
    assert counted == {topic: count for topic, (_, count) in found.items()}


def test_it_is_small_enough_for_a_repository() -> None:
    files = {file.name: file.stat().st_size for file in SAMPLE.iterdir()}
    assert set(files) == {'spiral_gaps_0.mcap', 'metadata.yaml', 'hand_eye.calib', 'params.yaml'}
    assert sum(files.values()) < 6_000_000


@pytest.mark.accuracy
def test_thickness_is_that_of_the_print(final: Comparison) -> None:
    expect_the_truth(final, pixel_size(JOB))


@pytest.mark.accuracy
def test_gaps_lie_where_no_ink_came(profiles: list[ThicknessProfile]) -> None:
    # Where none was commanded, none is missing.
    wanted = JOB.faults
    assert len(wanted) == 1
    # Within half the spacing of the path at each side, a pixel, and the effect of smoothing.
    assert profiles[-1].gaps == pytest.approx(wanted, abs=0.5 * MILLIMETRE_M)


@pytest.mark.accuracy
def test_fault_is_told_from_the_gaps_that_were_planned(final: Comparison) -> None:
    for start, end in JOB.commanded.gaps:
        inside = (final.s > start + MILLIMETRE_M) & (final.s < end - MILLIMETRE_M)
        assert inside.sum() > 10
        assert (final.profile.status[inside] == Status.BARE).all()
        assert not final.profile.extruding[inside].any()
    for start, end in JOB.faults:
        inside = (final.s > start + MILLIMETRE_M) & (final.s < end - MILLIMETRE_M)
        assert inside.sum() > 5
        assert final.gap[inside].all()
        assert final.profile.extruding[inside].all()
    assert final.profile.extruding[final.measured].mean() > 0.99


@pytest.mark.accuracy
def test_what_is_measured_early_is_right_too(profiles: list[ThicknessProfile]) -> None:
    # The nozzle is in view, so less is known; but that has to be right.
    pixel = pixel_size(JOB)
    for profile in profiles[:-1]:
        early = compare(profile, JOB)
        # Only the end of the deposit, at the nozzle, differs from the complete print.
        clear = (early.from_end > 2 * pixel) & (early.s < early.s.max() - 2 * MILLIMETRE_M)
        measured = clear & early.measured
        assert measured.sum() > 0.5 * clear.sum()
        assert not (measured & (early.width == 0)).any()
        assert not (clear & early.gap & (early.width > 0)).any()
        assert np.abs(early.error[measured]).mean() < 0.15 * pixel
        assert np.abs(early.error[measured]).max() < pixel


def test_files_say_what_was_measured(profiles: list[ThicknessProfile],
                                     measured_sample: Path) -> None:
    with (measured_sample / 'profile.csv').open(newline='') as file:
        rows = list(csv.DictReader(file))
    last = profiles[-1]
    thickness = np.array([float(row['thickness_mm'] or 'nan') for row in rows]) * MILLIMETRE_M
    assert thickness == pytest.approx(last.thickness, rel=1e-12, nan_ok=True)
    summary = json.loads((measured_sample / 'summary.json').read_text())
    counted = [sum(capture['counts'].values()) for capture in summary['captures']]
    assert counted == [len(profile) for profile in profiles]
    assert counted == sorted(counted)
    starts = [gap['start_mm'] * MILLIMETRE_M for gap in summary['gaps']]
    assert starts == pytest.approx(last.gaps[:, 0])
