"""Where a design lies, found from paths of which that is known."""

from __future__ import annotations

from design_builders import lattice, MM, printed, snake, stroke_of
from hypothesis import example, given, settings, strategies as st
import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.design import Design, DesignError
from bpc_perception.core.design.registration import place_at, register, Registration
from bpc_perception.core.geometry import transform

NOISE, ALLOWED = 0.05 * MM, 0.02 * MM
PLACE = (0.5, -0.1, 0.02)


def found(design: Design, T_base_design: Array, seed: int = 1, **keywords: object) -> Registration:
    points, stroke = printed(design, T_base_design, **keywords)  # type: ignore[arg-type]
    noise = np.random.default_rng(seed).normal(0, NOISE, points.shape)
    return register(design, points + noise, stroke)


def error(design: Design, T_base_design: Array, registration: Registration) -> float:
    """How far a point of the design is from where it is, at most [m]."""
    assert registration.refusal == ''
    points = np.concatenate([stroke.points for stroke in design.strokes])
    away = transform(registration.T_base_design, points) - transform(T_base_design, points)
    return float(np.linalg.norm(away, axis=1).max())


@settings(max_examples=10)
@given(yaw=st.floats(-180, 180), x=st.floats(-1, 1), y=st.floats(-1, 1), z=st.floats(-1, 1),
       tilt=st.tuples(st.floats(-4, 4), st.floats(-4, 4)), which=st.sampled_from(('lattice',
                                                                                  'snake')))
@example(yaw=0.0, x=0.0, y=0.0, z=0.0, tilt=(0.0, 0.25), which='lattice')
def test_any_place_is_found(yaw: float, x: float, y: float, z: float, tilt: tuple[float, float],
                            which: str) -> None:
    design = lattice() if which == 'lattice' else snake()
    T_base_design = pose((x, y, z), (yaw, *tilt))
    registration = found(design, T_base_design)
    assert error(design, T_base_design, registration) < ALLOWED
    # Noise of two directions lies across a line.
    assert registration.residual == pytest.approx(NOISE * 2**0.5, rel=0.1)
    assert registration.explained > 0.95
    assert registration.scale == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize('left_out', [(0,), (3,), (19,), (4, 9, 13)])
def test_strokes_may_be_missing(left_out: tuple[int, ...]) -> None:
    T_base_design = pose(PLACE, (120, 0, 0))
    registration = found(lattice(), T_base_design, left_out=left_out)
    assert error(lattice(), T_base_design, registration) < ALLOWED


@pytest.mark.parametrize('share', [0.3, 0.5, 0.7])
@pytest.mark.parametrize('layers', [1, 3])
def test_a_print_may_be_half_done(share: float, layers: int) -> None:
    """With the first lines of a lattice alone the turned one would fit as well, but for order."""
    design = lattice(layers=layers)
    T_base_design = pose(PLACE, (-77, 0, 0))
    registration = found(design, T_base_design, until=share * design.length)
    assert error(design, T_base_design, registration) < 2 * ALLOWED


def test_surplus_strokes_do_not_matter() -> None:
    """As a line before the print, to fill the needle."""
    T_base_design = pose(PLACE, (10, 0, 0))
    line = Design((stroke_of(((-10, -8, 0.2), (-10, 30, 0.2))), *lattice().strokes))
    points, stroke = printed(line, T_base_design)
    registration = register(lattice(), points, stroke)
    assert error(lattice(), T_base_design, registration) < ALLOWED
    assert registration.explained == pytest.approx(400 / 438, abs=0.03)


def test_a_stroke_that_was_heard_in_two_parts_does_not_matter() -> None:
    T_base_design = pose(PLACE, (10, 0, 0))
    points, stroke = printed(snake(), T_base_design)
    stroke[200:] += stroke[200:] > 0
    stroke[195:200] = 0
    assert error(snake(), T_base_design, register(snake(), points, stroke)) < ALLOWED


@pytest.mark.parametrize('left_out', [(8, 4), (9, 4), (0,)])
def test_wells_that_look_alike_are_told_by_their_order(left_out: tuple[int, ...]) -> None:
    square = np.array(((0, 0, 0.3), (4, 0, 0.3), (4, 4, 0.3), (0, 4, 0.3), (0, 0, 0.3)))
    plate = Design(tuple(stroke_of(np.add(square, (12 * column, 12 * row, 0)).tolist())
                         for row in range(3) for column in range(4)))
    points, stroke = printed(plate, pose(PLACE, (50, 0, 0)), left_out=left_out)
    registration = register(plate, points, stroke, finished=True)
    assert error(plate, pose(PLACE, (50, 0, 0)), registration) < ALLOWED


def test_rings_tell_their_turn_by_where_they_begin() -> None:
    angle = np.linspace(0, 2 * np.pi, 120)
    rings = Design(tuple(
        stroke_of(np.stack((r * np.cos(angle + begin), r * np.sin(angle + begin),
                            0 * angle + z), axis=1).tolist(), layer)
        for layer, z in enumerate((0.2, 0.4, 0.6)) for r, begin in ((8, 0.1), (15, 2.0))))
    registration = found(rings, pose(PLACE, (70, 1, -2)))
    assert error(rings, pose(PLACE, (70, 1, -2)), registration) < 0.1 * MM


def test_places_that_look_alike_are_refused() -> None:
    """Of parallel lines the first or the last is missing: nobody knows which."""
    lines = Design(tuple(stroke_of(((0, y, 0), (20, y, 0))) for y in range(0, 20, 2)))
    for left_out in (0, 9):
        points, stroke = printed(lines, pose(PLACE), left_out=(left_out,))
        refusal = register(lines, points, stroke, finished=True).refusal
        assert 'expected one place where the design fits, found another as good, ' in refusal
        assert '; tell where the design lies' in refusal
    # One that goes on began with its first line, as far as is known.
    registration = register(lines, points, stroke)
    assert error(lines, pose(PLACE), registration) < ALLOWED


def test_all_lines_of_a_finished_print_have_one_place() -> None:
    lines = Design(tuple(stroke_of(((0, y, 0), (20, y, 0))) for y in range(0, 20, 2)))
    for design in (lines, lattice()):
        points, stroke = printed(design, pose(PLACE, (5, 0, 0)))
        registration = register(design, points, stroke, finished=True)
        assert error(design, pose(PLACE, (5, 0, 0)), registration) < ALLOWED


@pytest.mark.parametrize(('scale', 'told'), [(25.4, '25'), (1 / 25.4, '3.9%'), (1.05, '105.0%'),
                                             (0.9, '90.0%')])
def test_another_size_is_refused(scale: float, told: str) -> None:
    points, stroke = printed(snake())
    registration = register(snake(), scale * points, stroke)
    assert registration.refusal.startswith(
        'registration: expected the print as large as the design, found it ')
    assert told in registration.refusal
    assert 'millimetres or inches?' in registration.refusal
    assert np.isnan(registration.T_base_design).all()


def test_another_design_is_refused() -> None:
    points, stroke = printed(snake())
    registration = register(lattice(), points, stroke)
    assert 'expected the recorded strokes on those of the design, found' in registration.refusal
    assert 'is it the design of this print?' in registration.refusal
    assert np.isnan(registration.residual)


def test_a_mirrored_print_is_refused() -> None:
    points, stroke = printed(snake())
    assert register(snake(), points * (-1, 1, 1), stroke).refusal


def test_a_bed_on_its_side_is_refused() -> None:
    points, stroke = printed(snake(), pose((0, 0, 0), (0, 14, 0)))
    assert 'expected a bed tilted by up to 10 degrees, found 14.0' in register(
        snake(), points, stroke).refusal


@pytest.mark.parametrize('count', [0, 1, 2])
def test_a_path_without_ink_is_refused(count: int) -> None:
    registration = register(snake(), np.zeros((count, 3)), np.ones(count, int))
    assert 'expected a recorded stroke of 0.5 mm or more, found none' in registration.refusal


def test_a_single_line_tells_its_place_but_not_the_roll_about_it() -> None:
    line = Design((stroke_of(((0, 0, 0), (20, 0, 0))),))
    T_base_design = pose(PLACE, (40, 0, 0))
    registration = found(line, T_base_design)
    assert error(line, T_base_design, registration) < 0.1 * MM
    assert registration.T_base_design[2, 2] == pytest.approx(1)


def test_a_place_may_be_told() -> None:
    registration = place_at(1.0, 2.0, 3.0, np.pi / 2)
    np.testing.assert_allclose(transform(registration.T_base_design, np.array((1.0, 0, 0))),
                               (1, 3, 3))
    assert registration.refusal == ''
    with pytest.raises(DesignError, match='expected finite numbers, found nan'):
        place_at(np.nan, 0, 0, 0)
