"""Travel: whether ink is seen where the nozzle only went from one stroke to the next."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs, thinned
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.samples import Samples, unseen
from bpc_perception.core.measurement.track import Track, track_along
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import typical_spacing
from bpc_perception.core.profile import Status, StatusArray

OWN_INK_PX = 2.0  # beyond the edge of a stroke, ink may still be the stroke's


def look_at_travel(view: View, path: DepositionPath, stroke: Index, shown: Flags,
                   samples: Samples, bed: Plane,
                   look: Callable[[Track, Index], StatusArray]) -> Samples:
    """Return the samples of a path with those of travel looked at.

    Where travel passes over a stroke, nothing is known of it: the ink there is the stroke's.

    Args:
        view: the capture.
        path: N points.
        stroke: (N,) number of the stroke of each; 0 = travel.
        shown: (N,) which of them are in view, or nearly so.
        samples: of the strokes.
        bed: plane of the bed.
        look: tells whether ink is seen at an index of points (K,) of a track, as Status (K,).
    """
    kept = np.flatnonzero(shown)
    number = stroke[kept]
    travel, laid = np.flatnonzero(number == 0), np.flatnonzero(number > 0)
    if not len(travel) or not len(laid):
        return samples
    part = _lowered(path.where(shown), laid, bed)
    # Each travel is a way of its own.
    number = np.where(number == 0, -1 - runs(number)[0], number)
    track = track_along(part, number, np.arange(len(kept)))
    pixel = view.pixel_size(track.points)
    asked = travel[thinned(number[travel], max(1, round(pixel / typical_spacing(track.points))))]
    if len(asked) < 2:
        return samples
    found = look(track, asked)
    nearest = np.minimum(np.searchsorted(asked, travel), len(asked) - 1)
    status = found[nearest]
    over = _over_strokes(bed.coordinates(part.points), samples.of(kept[laid]), laid, travel,
                         OWN_INK_PX * pixel)
    status[over & (status == Status.OOZE)] = Status.NO_DATA
    blank = unseen(len(travel))
    return samples.with_part(kept[travel], Samples(blank.sides, status, blank.sigma))


def _lowered(path: DepositionPath, laid: Index, bed: Plane) -> DepositionPath:
    """Return the path with all of it as high above the bed as its strokes (S,) usually are."""
    height = bed.height(path.points)
    lift = height - np.median(height[laid])
    lift[laid] = 0.0
    return path.moved_to(path.points - lift[:, None] * bed.normal)


def _over_strokes(places: Array, samples: Samples, laid: Index, travel: Index,
                  margin: float) -> Flags:
    """Return which travel points (T,) lie on the ink of a stroke, or within a margin [m].

    Args:
        places: (N, 2) of the path points on the bed [m].
        samples: of the strokes.
        laid: (S,) index of the points of strokes.
        travel: (T,) index of those of travel.
        margin: [m].
    """
    half = np.fmax(samples.sides.left_distance, samples.sides.right_distance)
    usual = np.nanmedian(half) if np.isfinite(half).any() else 0.0
    half = np.where(np.isfinite(half), half, usual) + margin
    distance, near = cKDTree(places[laid]).query(places[travel])
    return np.asarray(distance <= half[near])


def as_travel(status: StatusArray) -> StatusArray:
    """Return what statuses of strokes (K,) mean on travel: ink is ooze, and a gap is none."""
    return np.select([status == Status.MEASURED, status == Status.GAP],
                     [Status.OOZE, Status.BARE], status).astype(np.uint8)
