"""Travel: whether ink is seen where the nozzle only went from one stroke to the next."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.filters import runs
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.appearance.contrast import Contrast
from bpc_perception.core.measurement.cross_section.method import measure_cross_sections
from bpc_perception.core.measurement.samples import Samples, unseen
from bpc_perception.core.measurement.track import track_along
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import typical_spacing
from bpc_perception.core.profile import Status

OWN_INK_PX = 2.0  # beyond the edge of a stroke, ink may still be the stroke's
# What a section across travel says of it.
SEEN = {Status.MEASURED: Status.OOZE, Status.GAP: Status.BARE, Status.OCCLUDED: Status.OCCLUDED,
        Status.NO_DATA: Status.NO_DATA, Status.LOW_CONFIDENCE: Status.LOW_CONFIDENCE,
        Status.JUNCTION: Status.NO_DATA}


def look_at_travel(view: View, path: DepositionPath, stroke: Index, shown: Flags,
                   samples: Samples, bed: Plane, config: ThicknessConfig,
                   contrast: Contrast | None) -> Samples:
    """Return the samples of a path with those of travel looked at.

    Where travel passes over a stroke, nothing is known of it: the ink there is the stroke's.

    Args:
        view: the capture.
        path: N points.
        stroke: (N,) number of the stroke of each; 0 = travel.
        shown: (N,) which of them are in view, or nearly so.
        samples: of the strokes.
        bed: plane of the bed.
        config: how to measure.
        contrast: how ink differs from bed; None = nothing can be known.
    """
    travel = shown & (stroke == 0)
    if contrast is None or not travel.any() or not (shown & (stroke > 0)).any():
        return samples
    kept = np.flatnonzero(shown)
    numbers = stroke.copy()
    numbers[stroke == 0] = -1 - runs(stroke)[0][stroke == 0]  # each travel by itself
    track = track_along(_lowered(path, stroke, bed), numbers, kept)
    own = stroke[kept] == 0
    step = max(1, round(view.pixel_size(track.points) / typical_spacing(track.points)))
    chosen = np.flatnonzero(own & (np.arange(len(kept)) % step == 0))
    if len(chosen) < 2:
        return samples
    found = measure_cross_sections(view, track, bed, config, chosen, contrast).samples.status
    status = np.full(len(path), Status.NO_DATA, np.uint8)
    asked = np.flatnonzero(own)
    nearest = np.minimum(np.searchsorted(chosen, asked), len(chosen) - 1)
    status[kept[asked]] = _TRAVEL_STATUS[found[nearest]]
    over = _over_strokes(bed.coordinates(path.points), samples,
                         np.flatnonzero(shown & (stroke > 0)), np.flatnonzero(travel),
                         OWN_INK_PX * view.pixel_size(track.points))
    status[over] = Status.NO_DATA
    index = np.flatnonzero(travel)
    part = unseen(len(index))
    return samples.with_part(index, Samples(part.sides, status[index], part.sigma))


def _lowered(path: DepositionPath, stroke: Index, bed: Plane) -> DepositionPath:
    """Return the path with its travel lowered to the height of the strokes."""
    height = bed.height(path.points)
    usual = np.median(height[stroke > 0])
    points = path.points - np.where(stroke > 0, 0.0, height - usual)[:, None] * bed.normal
    return path.moved_to(points)


def _over_strokes(places: Array, samples: Samples, strokes: Index, travel: Index,
                  margin: float) -> Index:
    """Return which of the travel points (K,) lie on the ink of a stroke, or within a margin [m].

    Args:
        places: (N, 2) of all path points on the bed [m].
        samples: of all path points.
        strokes: (S,) index of those of strokes.
        travel: (T,) index of those of travel.
        margin: [m].
    """
    sides = samples.sides.left_distance[strokes], samples.sides.right_distance[strokes]
    half = np.fmax(*sides)
    usual = np.nanmedian(half) if np.isfinite(half).any() else 0.0
    half = np.where(np.isfinite(half), half, usual) + margin
    distance, near = cKDTree(places[strokes]).query(places[travel])
    return travel[distance <= half[near]]


_TRAVEL_STATUS = np.zeros(max(Status) + 1, np.uint8)
_TRAVEL_STATUS[list(SEEN)] = list(SEEN.values())
