"""What a stroke lies on follows from where the nozzle passed, on flat, tilted and curved beds."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from perception_builders import path_through
import pytest

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.geometry import Plane
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.layers import LayerFinder, Layering, ON_TRAVEL

MM = 1e-3
SPACING = 0.2 * MM
BED = Plane(np.array((0.0, 0.0, 1.0)), 0.0)
HOP = 2 * MM
# How high a bed is at places (N, 2) [m].
Shape = Callable[[Array], Array]
BEDS: dict[str, Shape] = {
    'flat': lambda xy: 0 * xy[:, 0],
    'tilted': lambda xy: 0.02 * xy[:, 0] - 0.015 * xy[:, 1],  # more than the plane knows of
    'cylinder': lambda xy: np.sqrt(0.06**2 - xy[:, 1]**2) - 0.06,
    'sphere': lambda xy: np.sqrt(0.06**2 - (xy**2).sum(axis=1)) - 0.06,
}


def straight(start: Array, end: Array, height: float, shape: Shape) -> Array:
    """Points (N, 3) along a line of the bed, this high above it [m]."""
    count = max(2, round(float(np.linalg.norm(np.subtract(end, start))) / SPACING) + 1)
    xy = np.linspace(start, end, count)
    return np.column_stack((xy, shape(xy) + height))


def printed(strokes: list[Array], noise: float = 0.0) -> tuple[DepositionPath, Index]:
    """A path of strokes with lifted travel between, and the number of the stroke of each point."""
    parts, numbers = [], []
    for number, stroke in enumerate(strokes, 1):
        if parts:
            way = np.linspace(parts[-1][-1], stroke[0], 12)[1:-1]
            way[:, 2] += HOP
            parts.append(way)
            numbers.append(np.zeros(len(way), np.intp))
        parts.append(stroke)
        numbers.append(np.full(len(stroke), number))
    points = np.concatenate(parts)
    points[:, 2] += np.random.default_rng(0).normal(0, noise, len(points))
    number = np.concatenate(numbers)
    return path_through(points, extruding=number > 0), number


def lattice(layers: int, rise: float, shape: Shape, tip: float = 0.8 * MM) -> list[Array]:
    strokes = []
    for layer in range(layers):
        for place in np.arange(-8, 9, 4) * MM:
            ends = np.array(((-10 * MM, place), (10 * MM, place)))
            ends = ends if layer % 2 == 0 else ends[:, ::-1]
            strokes.append(straight(*ends, tip + layer * rise, shape))
    return strokes


def found(path: DepositionPath, stroke: Index) -> Layering:
    return LayerFinder().layers(path, stroke, BED)


def of_strokes(layering: Layering, stroke: Index) -> list[set[int]]:
    return [set(layering.layer[stroke == number].tolist())
            for number in range(1, int(stroke.max()) + 1)]


@pytest.mark.parametrize('bed', BEDS)
@pytest.mark.parametrize(('rise', 'noise'), [(0.2 * MM, 0.01 * MM), (0.35 * MM, 0.02 * MM),
                                             (1.0 * MM, 0.02 * MM)])
def test_strands_that_cross_are_a_layer_each(bed: str, rise: float, noise: float) -> None:
    path, stroke = printed(lattice(4, rise, BEDS[bed]), noise)
    layering = found(path, stroke)
    assert of_strokes(layering, stroke) == [{layer} for layer in range(4) for _ in range(5)]
    assert set(layering.layer[stroke == 0]) == {ON_TRAVEL}


@pytest.mark.parametrize('bed', BEDS)
def test_strands_on_top_of_each_other_are_a_layer_each(bed: str) -> None:
    line = np.array(((-10, 3), (10, 3))) * MM
    strokes = [straight(*(line if layer % 2 else line[::-1]), 0.8 * MM + layer * 0.3 * MM,
                        BEDS[bed]) for layer in range(10)]
    path, stroke = printed(strokes, 0.02 * MM)
    layering = found(path, stroke)
    assert of_strokes(layering, stroke) == [{layer} for layer in range(10)]
    assert np.isnan(layering.rise[stroke <= 1]).all()
    np.testing.assert_allclose(layering.rise[stroke > 1], 0.3 * MM, atol=0.12 * MM)


@pytest.mark.parametrize('bed', BEDS)
@pytest.mark.parametrize('aside', [0.2, 0.4, 0.7])
def test_a_wall_that_leans_has_a_layer_with_each_stroke(bed: str, aside: float) -> None:
    strokes = [straight(np.array((-10 * MM, aside * MM * layer)),
                        np.array((10 * MM, aside * MM * layer)), (0.8 + 0.4 * layer) * MM,
                        BEDS[bed]) for layer in range(4)]
    path, stroke = printed(strokes)
    assert of_strokes(found(path, stroke), stroke) == [{0}, {1}, {2}, {3}]


@pytest.mark.parametrize('bed', BEDS)
def test_strands_of_one_layer_that_cross_or_touch_are_of_one_layer(bed: str) -> None:
    lines = np.array((((-10, 0), (10, 0)), ((0, -10), (0, 10)), ((-10, 1.5), (10, 1.5)),
                      ((-10, -9), (10, 9)))) * MM
    path, stroke = printed([straight(*line, 0.8 * MM, BEDS[bed]) for line in lines], 0.02 * MM)
    assert of_strokes(found(path, stroke), stroke) == [{0}] * 4


def test_a_path_that_goes_on_to_the_next_layer_without_a_break_is_of_two() -> None:
    shape = BEDS['flat']
    turns = np.array(((-10, 0), (10, 0), (10, 4), (-10, 4))) * MM
    layers = []
    for layer in range(3):
        corners = turns if layer % 2 == 0 else turns[::-1]
        legs = [straight(*ends, 0.8 * MM + layer * 0.3 * MM, shape)
                for ends in pairwise(corners)]
        layers.append(np.concatenate((legs[0], legs[1][1:], legs[2][1:])))
    points = np.concatenate(layers)
    path, stroke = path_through(points), np.ones(len(points), np.intp)
    layer = found(path, stroke).layer
    expected = np.repeat(np.arange(3), [len(part) for part in layers])
    assert np.mean(layer == expected) > 0.98


def test_a_helix_is_a_layer_higher_with_each_turn() -> None:
    angle = np.arange(0, 5 * 2 * np.pi, SPACING / (8 * MM))
    points = np.column_stack((8 * MM * np.cos(angle), 8 * MM * np.sin(angle),
                              0.8 * MM + 0.4 * MM * angle / (2 * np.pi)))
    path, stroke = path_through(points), np.ones(len(points), np.intp)
    layer = found(path, stroke).layer
    np.testing.assert_allclose(layer, np.floor(angle / (2 * np.pi) + 0.01), atol=1)
    assert np.mean(layer == np.floor(angle / (2 * np.pi) + 1e-6)) > 0.95


def test_another_object_beside_begins_on_the_bed() -> None:
    tower = [straight(np.array((0, 0)), np.array((10, 0)) * MM, 0.8 * MM + layer * 0.3 * MM,
                      BEDS['flat']) for layer in range(5)]
    beside = straight(np.array((0, 20)) * MM, np.array((10, 20)) * MM, 0.8 * MM, BEDS['flat'])
    path, stroke = printed([*tower, beside])
    assert of_strokes(found(path, stroke), stroke)[-1] == {0}


def test_a_path_that_grows_gets_the_layers_of_the_whole() -> None:
    path, stroke = printed(lattice(4, 0.35 * MM, BEDS['cylinder']), 0.02 * MM)
    finder = LayerFinder()
    for count in range(50, len(path), 97):
        finder.layers(path.where(np.arange(len(path)) < count), stroke[:count], BED)
    grown, whole = finder.layers(path, stroke, BED), found(path, stroke)
    np.testing.assert_array_equal(grown.layer, whole.layer)
    np.testing.assert_array_equal(grown.rise, whole.rise)


def test_strokes_that_are_told_otherwise_later_are_looked_at_again() -> None:
    path, stroke = printed(lattice(2, 0.35 * MM, BEDS['flat']))
    finder = LayerFinder()
    unsure = stroke.copy()
    unsure[600:] = 0
    finder.layers(path, unsure, BED)
    np.testing.assert_array_equal(finder.layers(path, stroke, BED).layer,
                                  found(path, stroke).layer)


def test_what_was_no_bed_does_not_tell_which_way_is_up_for_long() -> None:
    """So it is where the nozzle hid most of a small print at first."""
    path, stroke = printed(lattice(3, 0.35 * MM, BEDS['flat']))
    finder = LayerFinder()
    finder.layers(path.where(np.arange(len(path)) < len(path) // 2), stroke[:len(path) // 2],
                  Plane(np.array((1.0, 0.0, 0.0)), 0.0))
    layering = finder.layers(path, stroke, BED)
    np.testing.assert_array_equal(layering.layer, found(path, stroke).layer)
    assert layering.layer.max() == 2


def test_another_print_begins_anew() -> None:
    path, stroke = printed(lattice(2, 0.35 * MM, BEDS['flat']))
    finder = LayerFinder()
    finder.layers(path, stroke, BED)
    other = path_through(path.points[stroke == 1], print_id='other')
    assert set(finder.layers(other, np.ones(len(other), np.intp), BED).layer) == {0}
