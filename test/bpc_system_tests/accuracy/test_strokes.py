"""Strokes with travel between them: each is measured like a line of its own.

The path comes from poses and extruder states, as live. The truth is where ink was drawn.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.spatial import cKDTree

from bpc_perception.core.advice.advisor import Advisor
from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.config import AdviceConfig, ThicknessConfig
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.ink.curves import polyline
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.printer.motion import Travel
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.recorded_path import recorded_path
from bpc_sim.printer.scenarios import (
    dense,
    line,
    parallel_lines,
    purge,
    stroke_job,
    strokes,
    wall,
)

pytestmark = [pytest.mark.accuracy]

START_NS = 10**18
SPEED_M_PER_S = 0.01
MM = 1e-3
PIXEL_M = 0.19e-3
WRONG_M, WRONG_SHARE = 0.2e-3, 0.1
MOST_ERROR_M = 0.05e-3  # mean, on strokes


def path_of(job: PrintJob, known: bool = True, auto: bool = False) -> DepositionPath:
    """Return the path of a job from 100 poses and, if known, 50 extruder states a second."""
    return recorded_path(job, START_NS, known, auto)


def measured(job: PrintJob, known: bool = True) -> ThicknessProfile:
    """Return the profile of the complete print."""
    capture = job.capture(job.duration, 0, START_NS + round(job.duration * 1e9))
    return measure(capture, path_of(job, known), job.view.T_base_camera, ThicknessConfig())


class Judged:
    """The samples of a profile that are on strokes, and in the image.

    Attributes:
        status: (N,) of each.
        stroke: (N,) number of the stroke of each.
        error: (N,) measured less true width [m]; NaN unless measured.
        wrong: (N,) which are measured wrong, or a gap where there is ink.
    """

    def __init__(self, job: PrintJob, profile: ThicknessProfile) -> None:
        curve = job.commanded.curve
        s = curve.uniform(round(curve.length / 5e-5))
        s = s[job.commanded.inked(s)]
        uv = job.view.camera.pixels(
            transform(invert(job.view.T_base_camera), profile.points))
        seen = job.view.camera.contains(uv)
        places = transform(invert(job.T_base_surface), profile.points)[:, :2]
        distance, nearest = cKDTree(curve.points(s)).query(places)
        # A stroke is where it was commanded, and nowhere else.
        assert (distance[profile.stroke > 0] < 0.3 * MM).all()
        chosen = seen & (profile.stroke > 0)
        s = s[nearest[chosen]]
        width, status = job.truth(s), profile.status[chosen]
        from_end = np.abs(s[:, None] - job.deposit.runs.ravel()).min(axis=1)
        self.status: NDArray[np.uint8] = status
        self.stroke = profile.stroke[chosen]
        self.error = np.where(status == Status.MEASURED, profile.thickness[chosen] - width,
                              np.nan)
        off = np.abs(self.error) > np.maximum(WRONG_M, WRONG_SHARE * width)
        self.wrong = (off | ((status == Status.GAP) & (width > 0))) & (from_end > PIXEL_M)

    @property
    def answered(self) -> float:
        return float(np.isin(self.status, (Status.MEASURED, Status.GAP)).mean())

    @property
    def mae(self) -> float:
        return float(np.nanmean(np.abs(self.error)))

    @property
    def uneven(self) -> float:
        """Mean standard deviation of the errors along a stroke [m]."""
        return float(np.mean([np.nanstd(self.error[self.stroke == one])
                              for one in np.unique(self.stroke)]))


@pytest.fixture(scope='module')
def alone() -> float:
    """How uneven the errors of the lines are, each printed alone [m]."""
    jobs = [stroke_job(each[None], SPEED_M_PER_S, Travel(0, 0))
            for each in parallel_lines(5, 5 * MM, 0.036)]
    return float(np.mean([Judged(job, measured(job)).uneven for job in jobs]))


@pytest.mark.parametrize(('hop', 'known'), [
    (2e-3, True), (0.3e-3, True), (0.0, True), (2e-3, False), (0.3e-3, False)])
@pytest.mark.parametrize('speed', [0.01, 0.1], ids=['slow', 'fast'])
@pytest.mark.parametrize('to_and_fro', [False, True], ids=['one way', 'to and fro'])
def test_strokes_are_measured_like_single_lines(
        alone: float, hop: float, known: bool, speed: float, to_and_fro: bool) -> None:
    lines = parallel_lines(5, 5 * MM, 0.036)
    if to_and_fro:
        lines[1::2] = lines[1::2, ::-1]
    job = stroke_job(lines, SPEED_M_PER_S, Travel(0, 0, hop, speed))
    profile = measured(job, known)
    assert sorted(set(profile.stroke.tolist())) == list(range(6))
    judged = Judged(job, profile)
    assert len(judged.status) > 0.97 * 5 * 36 / 0.2
    assert judged.answered >= 0.98
    assert judged.uneven <= 1.2 * alone + PIXEL_M / 100
    # Where beads end is found for the whole print, and with it an error that strokes share.
    assert judged.mae <= min(2 * float(np.nanmedian(profile.sigma)), MOST_ERROR_M)
    assert not judged.wrong.any()
    assert profile.summary.gap_count == 0
    assert profile.summary.ooze_count == 0


def test_ink_begins_and_ends_where_it_was_commanded() -> None:
    found = measured(strokes(SPEED_M_PER_S)).strokes
    assert found.number.tolist() == [1, 2, 3, 4, 5]
    np.testing.assert_allclose(np.diff(found.commanded, axis=1), 36 * MM, atol=0.7 * MM)
    assert np.nanmax(np.abs(found.lag)) < 0.4 * MM


def test_ink_that_comes_late_is_a_lag_and_what_is_missing_later_a_gap() -> None:
    job = strokes(SPEED_M_PER_S)
    start = job.travels[0].end  # of the second stroke
    job = replace(job, faults=np.array(((start, start + 2 * MM), (start + 15 * MM,
                                                                  start + 20 * MM))))
    profile = measured(job)
    assert profile.summary.gap_count == 1
    assert profile.summary.gap_length == pytest.approx(5 * MM, abs=0.6 * MM)
    begun = profile.strokes.lag[:, 0]
    assert begun[1] == pytest.approx(2 * MM, abs=0.4 * MM)
    assert np.abs(np.delete(begun, 1)).max() < 0.4 * MM


def test_a_string_on_travel_is_ooze() -> None:
    lines = parallel_lines(3, 10 * MM, 0.03)
    lines[1::2] = lines[1::2, ::-1]
    job = stroke_job(lines, SPEED_M_PER_S, Travel(0, 0, 0.5 * MM))
    start, end = job.travels[0].start, job.travels[0].end
    stringing = replace(job, commanded=Deposit(
        job.commanded.curve,
        lambda s: np.where((s > start) & (s < end), 0.6 * MM, 2 * MM),
        np.array([(each.start, each.end) for each in job.travels[1:]])))
    capture = stringing.capture(job.duration, 0, START_NS + round(job.duration * 1e9))
    profile = measure(capture, path_of(job), job.view.T_base_camera, ThicknessConfig())
    assert profile.summary.ooze_count == 1
    # Next to the strokes it cannot be told from their own ink.
    assert profile.summary.ooze_length == pytest.approx(8 * MM, abs=2 * MM)
    (from_, to), = profile.ooze
    assert profile.strokes.commanded[0, 1] < from_ < to < profile.strokes.commanded[1, 0]
    assert profile.summary.gap_count == 0


@pytest.mark.parametrize('width', [0.3e-3, 0.5e-3, 0.8e-3])
def test_a_string_beside_a_stroke_is_no_part_of_its_width(width: float) -> None:
    """One way each: travel leaves and reaches the strokes at a small angle."""
    job = stroke_job(parallel_lines(4, 5 * MM, 0.036), SPEED_M_PER_S, Travel(0, 0, 0.3 * MM))
    way = np.array([(each.start, each.end) for each in job.travels])
    stringing = replace(job, commanded=Deposit(
        job.commanded.curve,
        lambda s: np.where(((s[..., None] > way[:, 0]) & (s[..., None] < way[:, 1])).any(axis=-1),
                           width, 2 * MM),
        np.empty((0, 2))))
    capture = stringing.capture(job.duration, 0, START_NS + round(job.duration * 1e9))
    judged = Judged(job, measure(capture, path_of(job), job.view.T_base_camera,
                                 ThicknessConfig()))
    assert not judged.wrong.any()
    assert judged.mae < 0.05 * MM


@pytest.mark.parametrize('hop', [0.3e-3, 2e-3])
def test_dense_strokes_are_told_apart(hop: float) -> None:
    job = dense(SPEED_M_PER_S, hop)
    judged = Judged(job, measured(job))
    assert judged.answered >= 0.95
    assert not judged.wrong.any()


def test_a_line_out_of_view_changes_nothing() -> None:
    found = {}
    for away in (0.15, 0.3, 0.6):
        job = purge(SPEED_M_PER_S, away)
        found[away] = Judged(job, measured(job))
    lines = parallel_lines(9, 2.6 * MM, 0.036)
    alone = stroke_job(lines, SPEED_M_PER_S, Travel(0, 0, speed=0.1))
    judged = Judged(alone, measured(alone))
    assert judged.answered >= 0.95
    for each in found.values():
        assert each.answered == pytest.approx(judged.answered, abs=0.01)
        assert not each.wrong.any()


def test_strokes_that_cross_are_a_junction_and_travel_across_takes_nothing() -> None:
    cross = np.array((((-15.0, 0.0), (15.0, 0.0)), ((0.0, -12.0), (0.0, 12.0)))) * MM
    job = stroke_job(cross, SPEED_M_PER_S, Travel(0, 0))
    profile = measured(job)
    for number in (1, 2):
        own = profile.stroke == number
        junction = profile.arc_length[own & (profile.status == Status.JUNCTION)]
        assert np.ptp(junction) == pytest.approx(2 * MM, abs=1.2 * MM)
    # Two lines, and between them travel across a third.
    lines = np.array((((-15.0, 0.0), (15.0, 0.0)), ((5.0, -10.0), (15.0, -10.0)),
                      ((-15.0, 10.0), (-5.0, 10.0)))) * MM
    judged = Judged(job := stroke_job(lines, SPEED_M_PER_S, Travel(0, 0, 0.3 * MM)),
                    measured(job))
    assert judged.answered >= 0.98
    assert not judged.wrong.any()


def test_a_wall_with_pauses_is_one_print_with_one_stroke_each() -> None:
    job = wall(SPEED_M_PER_S, pause=20.0)
    path = path_of(job, auto=True)
    assert path.start_ns == pytest.approx(START_NS + job.dwell_before * 1e9, abs=3e7)
    assert path.extruding.any()
    heights = transform(invert(job.T_base_surface), path.points[path.extruding])[:, 2]
    assert np.ptp(heights) == pytest.approx(9 * 0.4 * MM, abs=0.1 * MM)


@pytest.mark.parametrize('bed', [0.6e-3, 1.0e-3, 2.5e-3])
def test_at_square_turns_three_legs_are_not_one_width(bed: float) -> None:
    """As of an infill: where the ink of the legs runs together no width is given."""
    x, y = 0.015, (np.arange(6) - 2.5) * (2 * MM + bed)
    ends = np.where(np.arange(6)[:, None] % 2 == 0, (-x, x), (x, -x))
    corners = np.stack((ends, np.repeat(y[:, None], 2, axis=1)), axis=-1).reshape(-1, 2)
    job = replace(line(SPEED_M_PER_S), commanded=Deposit(
        polyline(corners), constant_width(2 * MM), np.empty((0, 2))))
    profile = measured(job)
    thickness = profile.thickness[profile.status == Status.MEASURED]
    assert len(thickness) > 0.8 * 6 * 2 * x / 0.2e-3
    assert thickness.max() < 2.5 * MM
    assert np.median(thickness) == pytest.approx(2 * MM, abs=PIXEL_M / 4)


@pytest.mark.parametrize(('speed', 'retraction'), [(0.03, 0.0), (0.03, 0.02e-3),
                                                   (0.01, 0.1e-3)])
def test_a_good_print_of_strokes_is_advised_to_go_on(speed: float, retraction: float) -> None:
    """Ink is at its width from the start of each stroke, whatever the plunger does before."""
    job = stroke_job(parallel_lines(9, 2.6 * MM, 0.036), speed,
                     Travel(0, 0, 0.3 * MM, retraction=retraction))
    path, target = path_of(job), AdviceConfig(target_thickness=2 * MM)
    advisor = Advisor()
    for number, t in enumerate(np.arange(1.3, job.duration, 0.05 / speed)):
        capture = job.capture(t, number, START_NS + round(t * 1e9))
        profile = measure(capture, path, job.view.T_base_camera, ThicknessConfig(), number)
        advice = advisor.advise(profile, path, target)
        # The dead band is 2 %; widths of one stroke are off by as much, a fifth of a pixel.
        assert advice.flow_rate_scale == pytest.approx(1.0, abs=0.05)
        assert advice.reason in (Reason.NOT_ENOUGH_DATA, Reason.ON_TARGET,
                                 Reason.UNDER_EXTRUSION, Reason.OVER_EXTRUSION)
    assert advice.delivery == pytest.approx(1.0, abs=0.03)
    assert advice.lag < 0.1


def test_bed_where_none_was_commanded_is_no_gap() -> None:
    job = line(SPEED_M_PER_S)  # extrusion stops half-way, the nozzle goes on along the bed
    profile = measured(job)
    assert profile.summary.gap_count == 0
    assert profile.summary.coverage > 0.98
    assert profile.summary.bare_length == pytest.approx(25 * MM, abs=2 * MM)
