"""Summary numbers and gaps of a profile, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.profile import run_extents, Status, ThicknessProfile

M, GAP, NO_DATA, OCCLUDED, JUNCTION, LOW, BARE, OOZE = Status
NAN = np.nan


def test_statistics_are_over_the_measured_samples() -> None:
    summary = profile_of([1e-3, 0, 2e-3, 3e-3, NAN, 4e-3], [M, GAP, M, M, OCCLUDED, M]).summary
    assert summary.thickness_mean == pytest.approx(2.5e-3)
    assert summary.thickness_std == pytest.approx(np.sqrt(1.25) * 1e-3)
    assert summary.thickness_q1 == pytest.approx(1.75e-3)
    assert summary.thickness_median == pytest.approx(2.5e-3)
    assert summary.thickness_q3 == pytest.approx(3.25e-3)


@pytest.mark.parametrize(('status', 'share'), [
    ([M] * 4, 1), ([M, M, GAP, GAP], 1), ([M, GAP, NO_DATA, LOW], 0.5), ([OCCLUDED] * 4, 0),
    ([JUNCTION, M, M, M], 0.75)])
def test_coverage_is_the_share_that_is_known(status: list[int], share: float) -> None:
    assert profile_of([1e-3] * 4, status).summary.coverage == share


def test_runs_of_gap_reach_half_way_to_their_neighbours() -> None:
    profile = profile_of([NAN] * 8, [M, GAP, GAP, M, M, GAP, M, M])
    np.testing.assert_allclose(profile.gaps, ((0.5e-3, 2.5e-3), (4.5e-3, 5.5e-3)))
    assert profile.summary.gap_count == 2
    assert profile.summary.gap_length == pytest.approx(3e-3)


def test_runs_at_the_ends_stop_at_the_last_sample() -> None:
    profile = profile_of([0, 0, 1e-3, 0, 0], [GAP, GAP, M, GAP, GAP], spacing=3e-3, speed=1e-3)
    np.testing.assert_allclose(profile.gaps, ((0, 4.5e-3), (7.5e-3, 12e-3)))
    # A single sample lasts no time: what the lag of start and stop explains is bare, but no gap.
    profile = profile_of([0, 1e-3, 0], [GAP, M, GAP], spacing=2e-3)
    np.testing.assert_allclose(profile.extents(GAP), ((0, 1e-3), (3e-3, 4e-3)))
    assert len(profile.gaps) == 0


def test_a_gap_all_along_is_as_long_as_the_path() -> None:
    profile = profile_of([0] * 5, [GAP] * 5, speed=1e-3)
    np.testing.assert_allclose(profile.gaps, ((0, 4e-3),))
    assert np.isnan(profile.summary.thickness_mean)


def test_what_is_not_known_splits_a_gap() -> None:
    assert profile_of([NAN] * 5, [M, GAP, NO_DATA, GAP, M]).summary.gap_count == 2


@pytest.mark.parametrize(('lag', 'count'), [(0.49, 0), (0.51, 1)])
def test_ink_may_come_half_a_second_late(lag: float, count: int) -> None:
    # Three samples, the way between which takes so long.
    profile = profile_of([NAN] * 6, [GAP, GAP, GAP, M, M, M], speed=2e-3 / lag)
    assert (len(profile.gaps), profile.summary.gap_count) == (count, count)
    assert profile.summary.coverage == 1


@pytest.mark.parametrize(('bare', 'speed', 'count'), [
    (2, 0.01, 0), (3, 0.01, 0), (4, 0.01, 1), (3, 0.001, 1)])
def test_ink_may_stop_a_little_early(bare: int, speed: float, count: int) -> None:
    profile = profile_of([NAN] * 8, [M] * (8 - bare) + [GAP] * bare, speed=speed)
    assert len(profile.gaps) == count
    # Where ink really ended is said all the same: half-way to the first bare sample.
    assert profile.strokes.lag[0, 1] == pytest.approx(-(bare - 0.5) * 1e-3)


@pytest.mark.parametrize(('delay', 'count'), [(0.05, 0), (0.15, 1)])
def test_what_was_passed_shortly_before_the_capture_is_no_gap_yet(delay: float,
                                                                  count: int) -> None:
    """The camera may have looked before, or the ink come later: 5 mm in 0.4 s."""
    profile = profile_of([NAN] * 9, [M] * 4 + [GAP] * 5, speed=0.01, delay=delay)
    assert len(profile.gaps) == count
    assert profile.summary.coverage == 1


def test_a_stroke_without_any_ink_is_a_gap() -> None:
    both = profile_of([NAN] * 6, [GAP, GAP, GAP, M, M, M])
    profile = replace(both, stroke=np.array([1, 1, 1, 2, 2, 2]))
    assert len(profile.gaps) == 1
    assert np.isnan(profile.strokes.ink[0]).all()


def shifted(left: float, right: float) -> ThicknessProfile:
    both = profile_of([left + right] * 4, [M, M, GAP, M])
    return replace(both, left=np.array([left, left, NAN, right]),
                   right=np.array([right, right, NAN, left]))


def test_offset_is_to_the_left_and_its_root_mean_square_does_not_cancel() -> None:
    summary = shifted(1.5e-3, 0.5e-3).summary
    assert summary.offset_mean == pytest.approx(0.5e-3 / 3)
    assert summary.offset_rms == pytest.approx(0.5e-3)


@pytest.mark.parametrize(('share', 'warned'), [(0.24, True), (0.26, False)])
def test_a_deposit_off_its_path_is_warned_of(share: float, warned: bool) -> None:
    warning = shifted(1.5e-3, 0.5e-3).off_path(share)
    assert bool(warning) == warned
    assert not warned or '0.50 mm off' in warning


def test_where_nothing_is_measured_no_offset_is_warned_of() -> None:
    assert profile_of([0] * 3, [GAP] * 3).off_path(0.01) == ''


def test_without_samples_everything_is_unknown() -> None:
    profile = profile_of([])
    summary = profile.summary
    assert len(profile) == 0
    assert np.isnan([summary.thickness_mean, summary.thickness_std, summary.thickness_q1,
                     summary.thickness_median, summary.thickness_q3, summary.coverage]).all()
    assert (summary.gap_count, summary.gap_length) == (0, 0)


@pytest.mark.parametrize('status', [NO_DATA, OCCLUDED, JUNCTION, LOW])
def test_without_measured_samples_there_are_no_statistics(status: int) -> None:
    summary = profile_of([NAN] * 4, [status] * 4).summary
    assert np.isnan([summary.thickness_mean, summary.thickness_std,
                     summary.thickness_median]).all()
    assert (summary.coverage, summary.gap_count) == (0, 0)


def test_runs_follow_uneven_spacing() -> None:
    arc = np.array((0.0, 1, 3, 7))
    np.testing.assert_allclose(run_extents(np.array((False, True, True, False)), arc), ((0.5, 5),))


@pytest.mark.parametrize('mask', [[], [False, False]])
def test_no_runs(mask: list[bool]) -> None:
    found = run_extents(np.array(mask, bool), np.arange(len(mask), dtype=float))
    assert found.shape == (0, 2)


def test_the_path_lies_on_the_bed_between_the_side_points() -> None:
    """The tip passes 1 mm above; a bead 0.5 mm beside the path does not move it."""
    flat = profile_of([2e-3, NAN, 2e-3], [M, NO_DATA, M])
    up, left, right = 1e-3 * np.array(((0, 0, 1), (0, 1.5, 0), (0, -0.5, 0)))
    known = np.where(flat.status == M, 1.0, NAN)
    profile = replace(flat, points=flat.points + up, left=1.5e-3 * known, right=0.5e-3 * known,
                      left_points=(flat.points + left) * known[:, None],
                      right_points=(flat.points + right) * known[:, None])
    np.testing.assert_allclose(profile.feet, flat.points, atol=1e-12)
    nothing = profile_of([NAN], [NO_DATA])
    np.testing.assert_array_equal(nothing.feet, nothing.points)
