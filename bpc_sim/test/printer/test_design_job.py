"""A print of a design: robot, extruder and ink do what the strokes say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.design.design import Design, DesignError, DesignStroke
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.testprints.flat import turns
from bpc_perception.core.testprints.setup import round_width, Setup
from bpc_perception.core.testprints.stacked import lattice, wall
from bpc_perception.core.testprints.sweep import lines
from bpc_sim.ink.bead_sizes import sizes_above
from bpc_sim.ink.extrusion import ExtruderBehaviour
from bpc_sim.printer.design_job import design_job, plans_of
from bpc_sim.printer.print_job import PrintJob

MM = 1e-3
SETUP = Setup(1 * MM, (100 * MM, 100 * MM))
SWEEP = lines(SETUP, [4e-9, 8e-9], [5 * MM, 10 * MM])
DEAD_TIME = 0.15
EXACT = ExtruderBehaviour(lag=1e-4, dead_time=DEAD_TIME, noise=0.0, spreading=1.6)


@pytest.fixture(scope='module')
def job() -> PrintJob:
    return design_job(SWEEP.design, SWEEP.plans, EXACT)


def times(job: PrintJob) -> np.ndarray:
    return np.arange(0.0, job.duration, 1e-3)


def test_ink_is_commanded_on_strokes_at_their_flow_and_speed(job: PrintJob) -> None:
    t = times(job)
    flow = job.flow_rate(t)
    begins = np.flatnonzero((flow[1:] > 0) & (flow[:-1] == 0)) + 1
    ends = np.flatnonzero((flow[1:] == 0) & (flow[:-1] > 0)) + 1
    assert len(begins) == len(SWEEP.plans)
    for one, two, plan, stroke in zip(begins, ends, SWEEP.plans, SWEEP.design.strokes,
                                      strict=True):
        assert flow[one:two] == pytest.approx(plan.flow)
        assert t[two] - t[one] == pytest.approx(stroke.length / plan.speed, abs=2e-3)
        speed = np.linalg.norm(np.diff(job.tip(t[one:two]), axis=0), axis=1) / 1e-3
        assert speed == pytest.approx(plan.speed, rel=1e-6)


def test_the_nozzle_passes_the_strokes_of_the_design(job: PrintJob) -> None:
    t = times(job)
    inked = job.flow_rate(t) > 0
    on_bed = transform(invert(job.T_base_surface), job.tip(t))
    shift = on_bed[inked][0] - SWEEP.design.strokes[0].points[0]
    low = np.min([stroke.points.min(axis=0) for stroke in SWEEP.design.strokes], axis=0)
    high = np.max([stroke.points.max(axis=0) for stroke in SWEEP.design.strokes], axis=0)
    assert on_bed[inked].min(axis=0) == pytest.approx(low + shift, abs=2e-5)
    assert on_bed[inked].max(axis=0) == pytest.approx(high + shift, abs=2e-5)
    assert shift[2] == pytest.approx(0, abs=1e-9)
    # Between the strokes it is lifted, but for the ways without ink before and behind them.
    empty = sum((plan.lead_in + plan.run_out) / plan.speed for plan in SWEEP.plans)
    low_time = np.count_nonzero(~inked & (on_bed[:, 2] < 1 * MM)) * 1e-3
    assert low_time == pytest.approx(empty, abs=0.05 * empty + 0.3)


def test_ink_comes_and_goes_late_by_the_dead_time(job: PrintJob) -> None:
    ink = job.deposit
    for (begin, end), plan in zip(job.commanded.runs, SWEEP.plans, strict=True):
        late = plan.speed * DEAD_TIME
        middle = (begin + end) / 2
        s = np.array((begin + late - 1e-4, begin + late + 1e-4, end - 1e-4,
                      middle))
        assert ink.inked(s).tolist() == [False, True, True, True]
        if plan.run_out:
            assert ink.inked(np.array((end + late - 1e-4, end + late + 1e-4))).tolist() == [
                True, False]
        assert ink.width(np.array((middle,)))[0] == pytest.approx(
            1.6 * round_width(plan.flow, plan.speed), rel=1e-3)
        _, area = sizes_above(ink, (), np.array((middle,)))
        assert area[0] == pytest.approx(plan.flow / plan.speed, rel=1e-2)  # all of the ink


def test_the_camera_sees_all_of_it() -> None:
    for test in (SWEEP, turns(SETUP), lattice(SETUP)):
        job = design_job(test.design, test.plans, EXACT)
        s = job.commanded.curve.uniform(500)
        points = np.column_stack((job.commanded.curve.points(s), np.zeros(len(s))))
        uv = job.view.camera.pixels(transform(
            invert(job.view.T_base_camera) @ job.T_base_surface, points))
        size = np.array((job.view.camera.width, job.view.camera.height))
        assert ((uv > 8) & (uv < size - 9)).all()


def test_strokes_lie_on_those_below() -> None:
    test = lattice(SETUP)
    job = design_job(test.design, test.plans, EXACT, sag=0.1 * MM)
    begins = job.layers[1, 0]
    below, above = (np.concatenate([
        np.linspace(*run, 400)[1:-1] for run in job.commanded.runs if (run[0] >= begins) == over])
        for over in (False, True))
    assert job.commanded.base(below) == pytest.approx(0, abs=1e-9)
    feet = job.commanded.base(above)
    assert feet.max() == pytest.approx(SETUP.height, abs=1e-6)
    assert feet.min() == pytest.approx(SETUP.height - 0.1 * MM, abs=1e-6)


@pytest.mark.parametrize('share', [0.4, 0.65, 1.2])
def test_all_of_the_ink_lies_above_what_was_there_before(share: float) -> None:
    """However low the layers are, beside a bead on the bed: volume is neither made nor lost."""
    high = EXACT.height_ratio * 1.6 * MM
    test = wall(replace(SETUP, layer_height=share * high), layers=4)
    job = design_job(test.design, test.plans, EXACT)
    ink = job.laid_layers(job.duration)
    for number, (begin, end) in enumerate(job.layers[1:], 1):
        s = np.linspace(begin, end, 42)[5:-5]
        _, area = sizes_above(ink[number], ink[:number], s)
        assert area == pytest.approx(test.plans[-1].flow / test.plans[-1].speed, rel=0.02)


def stroke_of(*points: tuple[float, float, float], layer: int = 0,
              width: float = 1.0) -> DesignStroke:
    return DesignStroke(MM * np.array(points), np.full(len(points) - 1, width * MM), layer)


def test_a_design_without_plans_is_laid_by_its_widths() -> None:
    design = Design((stroke_of((0, 0, 1), (20, 0, 1)), stroke_of((0, 5, 1), (20, 5, 1), width=2)))
    plans = plans_of(design, 5 * MM)
    assert [plan.flow for plan in plans] == pytest.approx(
        [np.pi / 4 * width**2 * 5e-9 for width in (1, 2)])
    job = design_job(design, plans, replace(EXACT, spreading=1.0))
    for (begin, end), width in zip(job.commanded.runs, (1, 2), strict=True):
        assert job.truth(np.array(((begin + end) / 2,)))[0] == pytest.approx(width * MM, rel=1e-3)


def test_what_cannot_be_printed() -> None:
    with pytest.raises(DesignError, match='stroke 1: expected a width, found none; fill in'):
        plans_of(Design((stroke_of((0, 0, 1), (9, 0, 1), width=np.nan),)), 1 * MM)
    bent = Design((stroke_of((0, 0, 1), (9, 0, 1)), stroke_of((0, 0, 2), (9, 0, 2), (9, 9, 2),
                                                             layer=1)))
    with pytest.raises(DesignError, match='layers: expected straight strokes'):
        design_job(bent, plans_of(bent, 1 * MM), EXACT)
    later = Design((stroke_of((0, 0, 2), (9, 0, 2), layer=1), stroke_of((0, 0, 1), (9, 0, 1))))
    with pytest.raises(DesignError, match='one after the other'):
        design_job(later, plans_of(later, 1 * MM), EXACT)
    plans = [replace(plan, flow=np.nan) for plan in SWEEP.plans]
    with pytest.raises(DesignError, match='fill in flow_mm3_s'):
        design_job(SWEEP.design, plans, EXACT)
