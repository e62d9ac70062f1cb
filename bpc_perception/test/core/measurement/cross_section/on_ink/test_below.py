"""How the bed lies below strokes on ink."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.on_ink.below import (
    BED_STEP,
    NORMALS,
    normals_by_path,
    normals_measured,
)
from bpc_perception.core.measurement.samples import Samples, unseen
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.profile import Status

MM = 1e-3
COUNT, SLOPE = 100, 0.1  # points of each of two layers; rise of the bed to the left
BED = Plane(np.array((0.0, 0.0, 1.0)), 0.0)
UP = np.array((0.0, -SLOPE, 1.0)) / np.hypot(SLOPE, 1)
NEWEST = np.arange(COUNT, 2 * COUNT)


def two_layers() -> Track:
    """A stroke along x, and another one on it."""
    x = np.tile(np.arange(COUNT) * 0.2 * MM, 2)
    layer = np.repeat((0, 1), COUNT)
    points = np.column_stack((x, 0 * x, MM + layer * 0.4 * MM))
    arc = np.arange(len(x)) * 0.2 * MM
    return Track('print', arc, points, np.ones(len(x), bool), 0 * arc, layer, arc, layer)


def laid(known: int) -> Samples:
    """What was measured: so many of the first points looked at have side points."""
    samples = unseen(2 * COUNT)
    sides = np.zeros((2 * COUNT, 3))
    sides[:, 1:] = MM * np.array((1.0, SLOPE))
    sides[BED_STEP * known:] = np.nan
    samples.status[:COUNT] = Status.MEASURED
    return Samples(SidePoints(sides, -sides, sides[:, 1], sides[:, 1]), samples.verdicts,
                   samples.sigma, samples.sizes, samples.seen_in)


@pytest.mark.parametrize('known', [NORMALS, 20])
def test_the_side_points_of_the_first_layer_tell_how_the_bed_lies(known: int) -> None:
    normal = normals_measured(two_layers(), NEWEST, BED, laid(known), MM)
    np.testing.assert_allclose(normal, np.tile(UP, (COUNT, 1)), atol=1e-6)


@pytest.mark.parametrize('known', [0, 1, NORMALS - 1])
def test_where_too_few_are_known_the_path_tells_it(known: int) -> None:
    track = two_layers()
    np.testing.assert_array_equal(normals_measured(track, NEWEST, BED, laid(known), MM),
                                  normals_by_path(track, NEWEST, BED))


def test_where_the_first_layer_was_not_measured_the_path_tells_it() -> None:
    track = two_layers()
    np.testing.assert_array_equal(
        normals_measured(track, NEWEST, BED, unseen(2 * COUNT), MM),
        normals_by_path(track, NEWEST, BED))
