"""Lines across the path that follow the surface, which may bend."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import masked_median, running_median, thinned
from bpc_perception.core.geometry import unit_vectors
from bpc_perception.core.measurement.cross_section.sections.lines import (
    distances_along,
    heights,
    Lines,
    pixels_along,
    points_at,
)
from bpc_perception.core.measurement.scale import steady_step, steady_window
from bpc_perception.core.measurement.view import View

LEAST_BED = 0.05  # of what is seen beside the path
NOZZLE_STEP = 4  # the nozzle's height is looked at on every n-th of the lines looked at


def follow_surface(view: View, lines: Lines, piece: Index, spacing: float, beside: Flags,
                   normal: Array, obstacle_height: float) -> Lines:
    """Return lines whose feet lie on the surface, and which are turned to run along it.

    The cloud shows how high the bed is on both sides. The surface bends slowly: not every line is
    looked at.

    Args:
        view: the capture.
        lines: (N,) across the path at the nozzle tip, with M samples.
        piece: (N,) number of the piece of path that each line is on.
        spacing: between path points [m].
        beside: (N, M) where bed is to be expected.
        normal: (3,) of the bed.
        obstacle_height: what stands higher is no bed [m].
    """
    step = 2 * steady_step(spacing)
    looked_at = thinned(piece, step)
    some, bare = lines.of(looked_at), beside[looked_at]
    few = np.arange(0, len(looked_at), NOZZLE_STEP)
    nozzle = nozzle_height(view, some.of(few), bare[few], normal, obstacle_height)
    some = replace(some, foot=some.foot + nozzle * normal)
    points = _cloud_along(view, some)
    height = heights(view, points, some, normal)
    place = distances_along(view, points, some)
    bed = bare & (np.abs(height) < obstacle_height)
    level, slope = level_and_slope(height, place, bed, steady_window(spacing * step),
                                   piece[looked_at])
    every = np.arange(len(lines.foot))
    level, slope = (np.interp(every, looked_at, values) for values in (nozzle + level, slope))
    return replace(lines, foot=lines.foot + level[:, None] * normal,
                   lateral=unit_vectors(lines.lateral + slope[:, None] * normal))


def nozzle_height(view: View, lines: Lines, bare: Flags, normal: Array,
                  obstacle_height: float) -> float:
    """Return how high the bed lies above the nozzle tip, as a rule below 0; 0 = not known [m].

    The nozzle keeps about the same height above the surface all along the path. What is seen
    farther above the tip stands in front, as the nozzle itself does; unless hardly anything else
    is seen, as where the nozzle's offset is wrong.
    """
    height = heights(view, _cloud_along(view, lines), lines, normal)
    seen = height[bare & np.isfinite(height)]
    low = seen[seen < obstacle_height]
    bed = low if len(low) > LEAST_BED * len(seen) else seen
    return float(np.median(bed)) if len(bed) else 0.0


def level_and_slope(height: Floats, place: Floats, bed: Flags, window: int,
                    piece: Index) -> tuple[Array, Array]:
    """Return how high (N,) the surface lies [m], and how steeply (N,) it rises to the left.

    Args:
        height: (N, M) of points of the cloud above the feet of their lines [m].
        place: (N, M) of the same points along their lines [m].
        bed: (N, M) which of them are of the bed.
        window: lines over which both are taken as steady.
        piece: (N,) number of the piece of path that each line is on.
    """
    sides = [bed & side for side in (place < 0, place > 0)]
    right, left = (running_median(masked_median(height, side), window, piece) for side in sides)
    right_place, left_place = (masked_median(place, side) for side in sides)
    slope = running_median((left - right) / (left_place - right_place), window, piece)
    slope = np.where(np.isfinite(slope), slope, 0.0)
    right, left = right - slope * right_place, left - slope * left_place
    # Where only one side is seen, that one says it.
    level = running_median(np.where(np.isfinite(right + left), (right + left) / 2,
                                    np.where(np.isfinite(right), right, left)), window,
                           piece)
    return np.where(np.isfinite(level), level, 0.0), slope


def _cloud_along(view: View, lines: Lines) -> Floats:
    return points_at(view.capture.cloud, pixels_along(view, lines))
