"""The paths of test prints, against geometry."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from bpc_perception.core.testprints.flat import fusion, turns
from bpc_perception.core.testprints.plan import Part, TestPrint
from bpc_perception.core.testprints.setup import MARGIN_M, Setup, way_through
from bpc_perception.core.testprints.stacked import lattice, line_over_lines, wall
from bpc_perception.core.testprints.sweep import lines

MM = 1e-3
BED = 60 * MM, 60 * MM
SETUP = Setup(0.41 * MM, BED)
ALL: tuple[Callable[[Setup], TestPrint], ...] = (
    lines, fusion, turns, lattice, line_over_lines, wall)


@pytest.mark.parametrize('make', ALL)
@pytest.mark.parametrize('nozzle', [0.1, 0.41])
def test_it_lies_in_the_middle_of_the_bed(make: Callable[[Setup], TestPrint],
                                          nozzle: float) -> None:
    test = make(Setup(nozzle * MM, BED))
    way = np.concatenate([way_through(*pair) for pair in zip(
        test.design.strokes, test.plans, strict=True)])[:, :2]
    low, high = way.min(axis=0), way.max(axis=0)
    assert (low >= MARGIN_M - 1e-6).all()
    assert low + high == pytest.approx(BED, abs=2e-6)


@pytest.mark.parametrize('make', ALL)
def test_it_begins_with_a_line_that_primes(make: Callable[[Setup], TestPrint]) -> None:
    test = make(SETUP)
    assert test.numbers(Part.PRIME) == [0]
    prime = test.design.strokes[0]
    assert prime.length >= 10 * MM - 1e-9
    others = np.concatenate([stroke.points for stroke in test.design.strokes[1:]])
    assert others[:, 0].min() - prime.points[:, 0].max() > 3 * MM


@pytest.mark.parametrize('make', ALL)
def test_widths_are_those_of_round_filaments(make: Callable[[Setup], TestPrint]) -> None:
    test = make(SETUP)
    for stroke, plan in zip(test.design.strokes, test.plans, strict=True):
        assert np.pi / 4 * stroke.widths**2 * plan.speed == pytest.approx(plan.flow)


@pytest.mark.parametrize('make', ALL[1:])
def test_a_setting_that_is_told_is_that_of_all_strokes(
        make: Callable[[Setup], TestPrint]) -> None:
    test = make(Setup(0.41 * MM, BED, speed=5 * MM, flow=2e-9, width=0.9 * MM, pressure=6e4,
                      temperature=21.0))
    for stroke, plan in zip(test.design.strokes, test.plans, strict=True):
        assert set(stroke.widths) == {0.9 * MM}
        assert (plan.speed, plan.flow, plan.pressure, plan.temperature) == (
            5 * MM, 2e-9, 6e4, 21.0)


@pytest.mark.parametrize('make', ALL)
def test_what_is_judged_lies_within_and_leaves_out_the_ends(
        make: Callable[[Setup], TestPrint]) -> None:
    test = make(SETUP)
    for stroke, plan in zip(test.design.strokes, test.plans, strict=True):
        begin, end = plan.judged
        assert 2 * MM <= begin < end <= stroke.length - 2 * MM + 2e-6


def test_each_flow_meets_each_speed_once() -> None:
    test = lines(SETUP, [1e-9, 2e-9, 3e-9], [2 * MM, 4 * MM])
    pairs = [(test.plans[index].flow, test.plans[index].speed)
             for index in test.numbers(Part.LINE)]
    assert sorted(pairs) == [(flow, speed) for flow in (1e-9, 2e-9, 3e-9)
                             for speed in (2 * MM, 4 * MM)]


def test_neighbours_differ_by_one_step() -> None:
    flows, speeds = [1e-9, 2e-9, 3e-9], [2 * MM, 4 * MM, 8 * MM]
    test = lines(SETUP, flows, speeds)
    steps = [(flows.index(plan.flow), speeds.index(plan.speed))
             for plan in (test.plans[index] for index in test.numbers(Part.LINE))]
    assert {abs(a - c) + abs(b - d) for (a, b), (c, d) in pairwise(steps)} == {1}


def test_the_middle_comes_before_and_after_all() -> None:
    test = lines(SETUP, [1e-9, 2e-9, 3e-9], [2 * MM, 4 * MM, 8 * MM])
    repeats = test.numbers(Part.REPEAT)
    assert repeats == [1, len(test.plans) - 1]
    assert {(test.plans[index].flow, test.plans[index].speed) for index in repeats} == {
        (2e-9, 4 * MM)}


def test_a_line_is_steady_for_a_centimetre_at_any_speed() -> None:
    test = lines(SETUP)
    for index in test.numbers(Part.LINE):
        plan = test.plans[index]
        begin, end = plan.judged
        assert begin == pytest.approx(2 * MM + 1.0 * plan.speed)  # a second to settle
        assert end - begin >= 10 * MM - 2e-6
        assert plan.run_out >= 0.5 * plan.speed - 1e-12
        assert plan.lead_in == plan.run_out


def test_lines_do_not_touch_where_ink_spreads() -> None:
    test = lines(SETUP)
    y = np.sort([test.design.strokes[index].points[0, 1] for index in range(1, len(test.plans))])
    widest = max(float(stroke.widths[0]) for stroke in test.design.strokes)
    assert np.diff(y).min() > 1.6 * widest + SETUP.nozzle


def test_pairs_come_nearer() -> None:
    test = fusion(SETUP, [0.5 * MM, 1 * MM, 0.8 * MM])
    for pair, distance in ((1, 1.0), (2, 0.8), (3, 0.5)):
        one, two = (test.design.strokes[index] for index in test.numbers(Part.STRAND)
                    if test.plans[index].pair == pair)
        assert two.points - one.points == pytest.approx(
            np.array([(0, distance * MM, 0)] * 2), abs=2e-6)


def test_turns_turn_by_their_angle() -> None:
    test = turns(SETUP, np.radians((45, 135)).tolist(), [1 * MM])
    for index in test.numbers(Part.TURN):
        stroke, plan = test.design.strokes[index], test.plans[index]
        legs = np.diff(stroke.points, axis=0)[[0, -1], :2]
        turned = np.arctan2(legs[0, 0] * legs[1, 1] - legs[0, 1] * legs[1, 0], legs[0] @ legs[1])
        assert turned == pytest.approx(plan.angle, abs=1e-3)
        if plan.radius > 0:  # the arc's points lie on a circle
            arc = stroke.points[1:-1, :2]
            centre = arc[0] + (0, plan.radius)
            assert np.linalg.norm(arc - centre, axis=1) == pytest.approx(plan.radius, abs=2e-6)


def test_a_lattice_has_strands_across_in_the_second_layer() -> None:
    test = lattice(SETUP, 4, 2 * MM)
    strands = [test.design.strokes[index] for index in test.numbers(Part.STRAND)]
    assert [stroke.layer for stroke in strands] == [0] * 4 + [1] * 4
    for layer, axis in ((0, 1), (1, 0)):
        places = [stroke.points[0, axis] for stroke in strands if stroke.layer == layer]
        assert np.diff(places) == pytest.approx(2 * MM, abs=2e-6)
        assert {round(1e6 * float(stroke.points[0, 2])) for stroke in strands
                if stroke.layer == layer} == {328 * (layer + 1)}  # 0.8 of the nozzle


def test_a_line_crosses_three() -> None:
    test = line_over_lines(SETUP)
    supports = [test.design.strokes[index] for index in test.numbers(Part.SUPPORT)]
    (span,) = (test.design.strokes[index] for index in test.numbers(Part.SPAN))
    assert len(supports) == 3
    assert span.layer == 1
    x = [stroke.points[0, 0] for stroke in supports]
    assert np.diff(x) == pytest.approx((5 * SETUP.nozzle, 10 * SETUP.nozzle), abs=2e-6)
    assert span.points[0, 0] < x[0] < x[-1] < span.points[1, 0]
    for stroke in supports:
        assert stroke.points[0, 1] < span.points[0, 1] < stroke.points[1, 1]


def test_a_wall_goes_to_and_fro() -> None:
    test = wall(SETUP, 3)
    strokes = [test.design.strokes[index] for index in test.numbers(Part.WALL)]
    assert [stroke.layer for stroke in strokes] == [0, 1, 2]
    for one, two in pairwise(strokes):
        assert two.points[0, :2] == pytest.approx(one.points[1, :2])
        assert two.points[0, 2] - one.points[1, 2] == pytest.approx(SETUP.height, abs=1e-6)


def test_what_does_not_fit_says_which_bed_does() -> None:
    with pytest.raises(ValueError, match=r'--bed-mm: expected (\S+),(\S+) or more') as refused:
        lines(Setup(1 * MM, BED))
    sides = str(refused.value).split('expected ')[1].split(' or')[0].split(',')
    lines(Setup(1 * MM, tuple(MM * float(side) for side in sides)))  # type: ignore[arg-type]
    smaller = [MM * (float(side) - 0.2) for side in sides]
    for bed in ((smaller[0], MM * float(sides[1])), (MM * float(sides[0]), smaller[1])):
        with pytest.raises(ValueError, match='take a larger bed'):
            lines(Setup(1 * MM, bed))


@pytest.mark.parametrize(('make', 'message'), [
    (lambda: Setup(0.04 * MM, BED), '--nozzle-mm: expected 0.05 to 5 mm, found 0.04'),
    (lambda: Setup(6 * MM, BED), 'found 6'),
    (lambda: Setup(np.nan, BED), 'found nan'),
    (lambda: Setup(0.41 * MM, (0.0, 1.0)), '--bed-mm'),
    (lambda: Setup(0.41 * MM, BED, layer_height=1 * MM), '--layer-height-mm'),
    (lambda: Setup(0.41 * MM, BED, speed=1.0), '--speed-mm-s: expected 0.1 to 500 mm/s'),
    (lambda: lines(SETUP, length=5 * MM), '--length-mm: expected .* or more'),
    (lambda: lines(SETUP, [1.0]), 'cubic millimetres'),
    (lambda: lines(SETUP, [1e-9], [9.0]), '--speeds-mm-s'),
    (lambda: lines(SETUP, [1e-9] * 21, [1e-3] * 20), 'expected up to 400'),
    (lambda: fusion(SETUP, [9 * MM]), '--distances-mm'),
    (lambda: turns(SETUP, [3.1]), '--angles-deg: expected 20 to 170 degrees'),
    (lambda: turns(SETUP, radii=[-1.0]), '--radii-mm'),
    (lambda: lattice(SETUP, 1), '--strands: expected 2 to 50, found 1'),
    (lambda: lattice(SETUP, pitch=0.3 * MM), '--pitch-mm'),
    (lambda: line_over_lines(SETUP, [0.1 * MM]), '--spans-mm'),
    (lambda: wall(SETUP, 1), '--layers'),
    (lambda: wall(SETUP, length=1 * MM), '--length-mm')])
def test_refusals(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=message) as refused:
        make()
    assert ';' in str(refused.value)
