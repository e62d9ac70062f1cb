"""Turns of zig-zags whose apexes are as wide as they are made."""

from __future__ import annotations

import numpy as np
from printed_shapes import Line, printed
import pytest

from bpc_perception.core.printability.flat_print import FlatPrint, lay_flat
from bpc_perception.core.printability.turns import find_turns, legs, turn_fidelity
from bpc_perception.core.profile import Status

LEG = 10.0


def zigzag(apexes: list[float], statuses: dict[tuple[float, float], Status] | None = None,
           ) -> FlatPrint:
    """A zig-zag of right angles, 1 mm wide, with these widths at its turns [mm]."""
    count = len(apexes) + 1
    corners = [(LEG * np.sqrt(0.5) * number, LEG * np.sqrt(0.5) * (number % 2))
               for number in range(count + 1)]
    places = np.array([0, *np.linspace(LEG, LEG * (count - 1), count - 1), LEG * count])

    def half(s: np.ndarray) -> np.ndarray:
        near = np.abs(s[:, None] - places).argmin(axis=1)
        away = np.abs(s - places[near])
        wide = np.array([1.0, *apexes, 1.0])[near]
        return np.where(away < 0.3, wide, 1.0) / 2

    return lay_flat(printed([Line(corners, half, half, statuses=statuses or {})]))


def test_turns_are_found_where_they_are() -> None:
    flat = zigzag([1.0, 1.0, 1.0])
    np.testing.assert_allclose(flat.arc_length[find_turns(flat)] * 1e3, (10, 20, 30), atol=0.11)
    assert sorted(set(legs(flat).tolist())) == [1, 2, 3, 4]


def test_a_straight_line_has_none() -> None:
    found = turn_fidelity(lay_flat(printed([Line([(0, 0), (30, 0)])])))
    assert np.isnan(found.value)
    assert found.note == 'the path has no turns'


@pytest.mark.parametrize(('apexes', 'share'), [
    ([1.0, 1.0, 1.0, 1.0], 1.0), ([1.0, 1.6, 1.0, 1.0], 0.75), ([0.6, 1.6, 1.45, 0.75], 0.5)])
def test_the_share_of_good_turns(apexes: list[float], share: float) -> None:
    found = turn_fidelity(zigzag(apexes))
    assert found.value == share
    assert found.samples == 4
    assert 0.1 < found.sigma < 0.25


def test_turns_that_are_not_measured_are_counted() -> None:
    found = turn_fidelity(zigzag([1.0, 1.6, 1.0, 1.0], {(9.0, 11.0): Status.JUNCTION}))
    assert found.value == pytest.approx(2 / 3)
    assert (found.samples, found.note) == (3, '1 more turns are not measured')


def test_none_is_measured() -> None:
    found = turn_fidelity(zigzag([1.0], {(9.0, 11.0): Status.JUNCTION}))
    assert np.isnan(found.value)
    assert found.note == 'at none of the 1 turns is the width measured'


@pytest.mark.parametrize('radius', [0.7, 1.0, 1.5])
def test_a_half_circle_is_one_turn(radius: float) -> None:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 100)
    bend = [(0.0, -radius), *zip(20 + radius * np.cos(angle), radius * np.sin(angle), strict=True),
            (0.0, radius)]
    flat = lay_flat(printed([Line(bend)]))
    apex, = find_turns(flat)
    np.testing.assert_allclose(flat.arc_length[apex], (20 + radius * np.pi / 2) * 1e-3, atol=2e-4)


def test_a_spiral_is_a_curve() -> None:
    angle = np.linspace(3 * np.pi, 9 * np.pi, 800)
    spiral = [(0.3 * a * np.cos(a), 0.3 * a * np.sin(a)) for a in angle]
    assert len(find_turns(lay_flat(printed([Line(spiral)])))) == 0
