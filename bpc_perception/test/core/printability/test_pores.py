"""Pores of lattices whose areas and shapes are known from geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from printed_shapes import lattice, Line, MM, printed
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.printability.flat_print import lay_flat
from bpc_perception.core.printability.pores import find_pores, Pore, shape_factor
from bpc_perception.core.profile import Status, ThicknessProfile

TURNED = Rotation.from_euler('zyx', (20, 3, -2), degrees=True).as_matrix()


def pores_of(profile: ThicknessProfile, wanted: float | None = 1.0) -> list[Pore]:
    """Pores; strands were meant to be this wide [mm]."""
    flat = lay_flat(profile)
    return find_pores(flat, None if wanted is None else np.full(len(flat.stroke), wanted * MM))


def test_shapes_by_formula() -> None:
    assert shape_factor(4.0, 8.0) == pytest.approx(1)
    assert shape_factor(np.pi, 2 * np.pi) == pytest.approx(np.pi / 4)


@pytest.mark.parametrize('turned', [None, TURNED])
def test_a_lattice_has_square_pores(turned: np.ndarray | None) -> None:
    pores = pores_of(printed(lattice(), turned=turned))
    assert [pore.number for pore in pores] == [1, 2, 3, 4]
    for pore in pores:
        assert pore.area == pytest.approx(9 * MM**2, rel=1e-3)
        assert pore.perimeter == pytest.approx(12 * MM, rel=1e-3)
        assert pore.printability == pytest.approx(1, abs=1e-4)
        assert pore.ideal == pytest.approx(1, abs=1e-4)
        assert pore.mesh_printability == pytest.approx(100, abs=0.1)
        assert pore.size_accuracy == pytest.approx(100, abs=0.1)
        assert (pore.layers, pore.interpolated, pore.note) == ((0, 1), 0, '')
    centres = [(2, 2, 0), (6, 2, 0), (2, 6, 0), (6, 6, 0)]
    expected = np.array(centres) * MM
    if turned is not None:
        expected = expected @ turned.T + (0.5, 0.1, 0.02)
    np.testing.assert_allclose([pore.centre for pore in pores], expected, atol=1e-6)


def test_a_rectangle_has_its_own_ideal() -> None:
    pores = pores_of(printed(lattice(pitch_x=5, pitch_y=3)))
    ideal = (2 * (4 + 2)) ** 2 / (16 * 4 * 2)
    for pore in pores:
        assert pore.printability == pytest.approx(ideal, abs=1e-3)
        assert pore.ideal == pytest.approx(ideal, abs=1e-3)
        assert pore.area == pytest.approx(8 * MM**2, rel=1e-3)


def test_strands_too_wide_make_smaller_pores() -> None:
    pore, *_ = pores_of(printed(lattice(width=1.2)))
    assert pore.area == pytest.approx(2.8**2 * MM**2, rel=1e-3)
    assert pore.mesh_printability == pytest.approx(100 * 2.8**2 / 9, abs=0.2)
    assert pore.size_accuracy == pytest.approx(100 * 2.8 / 3, abs=0.1)


def test_without_a_width_that_was_wanted_there_is_no_intended_area() -> None:
    pore, *_ = pores_of(printed(lattice(pitch_x=5, pitch_y=3)), None)
    assert np.isnan(pore.mesh_printability)
    assert np.isnan(pore.size_accuracy)
    assert pore.ideal == pytest.approx((2 * (4 + 2)) ** 2 / (16 * 4 * 2), abs=1e-3)


def rounded(radius: float, half: float, reach: float) -> Line:
    """A strand along x whose left edge rounds the corners of a pore between x = 0 and 2 reach.

    The pore is a square of 2 reach with rounded corners above the edge y = half.
    """
    def left(s: np.ndarray) -> np.ndarray:
        from_corner = np.minimum(s - 1, 2 * reach + 1 - s)  # the strand begins 1 mm before
        # Under the strands across it goes on as wide.
        inner = np.clip(radius - from_corner, 0, radius)
        return half + radius - np.sqrt(radius**2 - inner**2)
    return Line([(-1, -half), (2 * reach + 1, -half)], left, half)


@pytest.mark.parametrize('radius', [0.5, 1.0, 1.5])
def test_rounded_corners_by_formula(radius: float) -> None:
    # A pore of 4 mm: the lower and upper strands round its corners, the others are straight.
    reach, half = 2.0, 0.5
    lower = rounded(radius, half, reach)
    upper = replace(lower, corners=[(2 * reach + 1, 2 * reach + half), (-1, 2 * reach + half)])
    sides = [Line([(x, -1), (x, 2 * reach + 1)], half, half, 1) for x in (-half, 2 * reach + half)]
    pore, = pores_of(printed([lower, upper, *sides]))
    area = 16 - (4 - np.pi) * radius**2
    perimeter = 16 - (8 - 2 * np.pi) * radius
    assert pore.area == pytest.approx(area * MM**2, rel=0.01)
    assert pore.printability == pytest.approx(perimeter**2 / (16 * area), abs=0.01)
    assert pore.ideal == pytest.approx(1, abs=1e-3)


def test_a_ring_encloses_a_circle() -> None:
    angle = np.linspace(0, 2 * np.pi + 0.2, 200)
    ring = Line(list(zip(5 * np.cos(angle), 5 * np.sin(angle), strict=True)))
    pore, = pores_of(printed([ring]))
    assert pore.area == pytest.approx(np.pi * 4.5**2 * MM**2, rel=3e-3)
    assert pore.printability == pytest.approx(np.pi / 4, abs=2e-3)
    assert pore.ideal == pytest.approx(np.pi / 4, abs=2e-3)
    assert pore.layers == (0,)


def crossing(position: float, status: Status, length: float = 0.6) -> dict:
    return {(position - length, position + length): status}


def test_crossings_in_one_layer_are_interpolated_and_counted() -> None:
    # The crossings are at 1, 5 and 9 mm of each strand.
    junctions = {span: value for place in (1, 5, 9)
                 for span, value in crossing(place, Status.JUNCTION).items()}
    lines = [replace(line, layer=0, statuses=junctions) for line in lattice()]
    pores = pores_of(printed(lines))
    assert len(pores) == 4
    for pore in pores:
        assert pore.area == pytest.approx(9 * MM**2, rel=1e-3)
        # Of each side of 3 mm, a tenth of a millimetre or two at both ends.
        assert 0 < pore.interpolated < 0.15
        assert 'of its outline are interpolated' in pore.note


def frame_with_a_strand(statuses: dict[tuple[float, float], Status],
                        end: float = 10.5) -> list[Line]:
    """A frame of 10 by 8 mm inside, and a strand of 1 mm across it up to an end [mm]."""
    sides = [[(-0.5, -1), (-0.5, 9)], [(10.5, -1), (10.5, 9)],
             [(-1, -0.5), (11, -0.5)], [(-1, 8.5), (11, 8.5)]]
    return [*map(Line, sides), Line([(-0.5, 4), (end, 4)], statuses=statuses)]


@pytest.mark.parametrize('end', [10.5, 9.95])  # on the frame's middle, and a sample before it
def test_a_strand_that_ends_on_another_is_known_up_to_there(end: float) -> None:
    ends = {(0.0, 0.6): Status.JUNCTION, (10.4, 11.0): Status.JUNCTION}
    pores = pores_of(printed(frame_with_a_strand(ends, end)))
    assert len(pores) == 2
    for pore in pores:
        assert pore.area == pytest.approx(35 * MM**2, rel=1e-3)
        assert pore.printability == pytest.approx(27**2 / (16 * 35), abs=1e-3)
        assert 0 < pore.interpolated < 0.02


def test_single_samples_beside_a_crossing_are_interpolated_with_it() -> None:
    ends = {(0.0, 0.6): Status.JUNCTION, (0.7, 0.7): Status.LOW_CONFIDENCE,
            (10.4, 11.0): Status.JUNCTION, (10.3, 10.3): Status.LOW_CONFIDENCE}
    pores = pores_of(printed(frame_with_a_strand(ends)))
    assert [pore.area / MM**2 for pore in pores] == pytest.approx([35, 35], rel=1e-3)
    two = ends | {(10.2, 10.3): Status.LOW_CONFIDENCE}
    assert np.isnan([pore.area for pore in pores_of(printed(frame_with_a_strand(two)))]).all()


@pytest.mark.parametrize('ends', [
    {(8.0, 11.0): Status.JUNCTION}, {(10.4, 11.0): Status.OCCLUDED}])
def test_an_end_that_is_not_seen_for_long_or_hidden_is_not_told(
        ends: dict[tuple[float, float], Status]) -> None:
    pores = pores_of(printed(frame_with_a_strand(ends)))
    assert [np.isfinite(pore.area) for pore in pores] == [False, False]


@pytest.mark.parametrize('status', [Status.OCCLUDED, Status.NO_DATA, Status.LOW_CONFIDENCE])
def test_what_is_not_seen_is_not_told(status: Status) -> None:
    lines = lattice()
    lines[0] = replace(lines[0], statuses={(2.0, 4.0): status})
    pores = pores_of(printed(lines))
    assert [np.isfinite(pore.area) for pore in pores] == [False, True, True, True]
    first = pores[0]
    assert np.isnan(first.printability)
    assert np.isnan(first.mesh_printability)
    assert 'not seen all around' in first.note
    np.testing.assert_allclose(first.centre, (2 * MM, 2 * MM, 0), atol=1e-5)


def test_a_single_sample_is_interpolated() -> None:
    lines = lattice()
    lines[0] = replace(lines[0], statuses={(3.0, 3.0): Status.LOW_CONFIDENCE})
    first = pores_of(printed(lines))[0]
    assert first.area == pytest.approx(9 * MM**2, rel=1e-3)
    assert first.interpolated == pytest.approx(0.2 / 12, rel=0.1)


def test_a_gap_joins_pores() -> None:
    lines = lattice()
    lines[1] = replace(lines[1], statuses={(1.2, 4.8): Status.GAP})
    pores = pores_of(printed(lines))
    joined = max(pores, key=lambda pore: np.nan_to_num(pore.area))
    assert joined.area > 18 * MM**2
    assert 'in the place of 2 intended ones' in joined.note
    assert np.isnan(joined.mesh_printability)
    assert len(pores) == 3


def test_ink_for_itself_in_a_pore_is_not_of_it() -> None:
    blob = Line([(1.5, 2), (2.5, 2)], 0.25, 0.25)
    pores = pores_of(printed([*lattice(), blob]))
    assert [pore.area / MM**2 for pore in pores] == pytest.approx([8.5, 9, 9, 9], rel=1e-3)


def test_a_gap_at_the_border_opens_a_pore() -> None:
    lines = lattice()
    lines[0] = replace(lines[0], statuses={(2.0, 4.0): Status.GAP})
    pores = pores_of(printed(lines))
    assert pores[0].note == 'ink does not enclose it'
    assert np.isnan(pores[0].area)
    assert pores[0].intended_area == pytest.approx(9 * MM**2, rel=1e-3)


def test_a_pore_that_ink_closed_has_no_area() -> None:
    lines = lattice(pitch_x=2, pitch_y=2, width=2.1)
    pores = pores_of(printed(lines))
    assert [pore.note for pore in pores] == ['closed by ink'] * 4
    assert [pore.area for pore in pores] == [0.0] * 4
    assert all(np.isnan(pore.printability) for pore in pores)


def test_the_uncertainty_is_that_of_the_widths() -> None:
    one, two = (pores_of(printed(lattice(), sigma=sigma))[0] for sigma in (0.02, 0.04))
    assert two.area_sigma == pytest.approx(2 * one.area_sigma, rel=0.05)
    # If both sides of all strands were wrong alike, by half of sigma, it would be 0.12 mm^2.
    assert 0.08 * MM**2 < one.area_sigma < 0.12 * MM**2
    assert 0 < one.printability_sigma < 0.02


def test_widths_within_their_uncertainty_give_pores_within_theirs() -> None:
    chance = np.random.default_rng(3)
    off = []
    for _ in range(20):
        wrong = chance.normal(0, 0.03)
        pore = pores_of(printed(lattice(width=1 + wrong), sigma=0.03))[0]
        off.append((pore.area - 9 * MM**2) / pore.area_sigma)
    assert np.std(off) < 2


def test_a_curved_bed_is_refused() -> None:
    profile = printed(lattice(count=4))
    x = profile.points[:, 0]
    curved = replace(profile, points=profile.points + np.outer(8 * (x - x.mean()) ** 2 / 2 / 0.02,
                                                               (0, 0, 1)))
    assert lay_flat(curved).curved
    assert pores_of(curved) == []


def test_each_pair_of_layers_has_pores() -> None:
    two = lattice()
    lines = [*two, *(replace(line, layer=line.layer + 2) for line in two)]
    pores = pores_of(printed(lines))
    assert [pore.layers for pore in pores] == [(0, 1)] * 4 + [(1, 2)] * 4 + [(2, 3)] * 4
    assert [pore.number for pore in pores] == list(range(1, 13))
