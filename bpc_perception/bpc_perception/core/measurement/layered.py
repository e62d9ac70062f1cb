"""Prints in layers: strokes are measured while they lie open, and keep their results."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.cross_section.method import measure_cross_sections
from bpc_perception.core.measurement.cross_section.on_ink.first_layer import (
    first_layer_measured,
    first_layer_unseen,
)
from bpc_perception.core.measurement.cross_section.on_ink.method import measure_on_ink
from bpc_perception.core.measurement.kept import answered, Kept
from bpc_perception.core.measurement.samples import Samples, unseen
from bpc_perception.core.measurement.scale import steady_window
from bpc_perception.core.measurement.track import track_along
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import typical_spacing
from bpc_perception.core.profile import Status

MOST_LOOKS = 3  # that give an answer; the best of them is kept
NOTHING = Kept('', np.empty(0), unseen(0), np.empty(0, np.intp))


@dataclass(frozen=True)
class Places:
    """Where N points of a path lie.

    Attributes:
        stroke: (N,) number of the stroke of each; 0 = travel.
        layer: (N,) of each, see path.layers.
        shown: (N,) whether it is in view, or nearly so.
    """

    stroke: Index
    layer: Index
    shown: Flags


def measure_layers(view: View, path: DepositionPath, places: Places, bed: Plane,
                   config: ThicknessConfig, memory: PrintMemory) -> Samples:
    """Measure the strokes of a print in layers that lie open in a capture.

    Args:
        view: the capture.
        path: N points.
        places: where they lie.
        bed: plane of the bed.
        config: how to measure.
        memory: of the captures before.
    """
    config = memory.reach.applied(config)
    kept = (memory.kept or NOTHING).at(path)
    shown = np.flatnonzero(places.shown & (places.stroke > 0))
    track = track_along(path, places.stroke, shown, places.layer)
    below = (first_layer_measured(kept.samples, path, places.layer, bed)
             or first_layer_unseen(view, kept.samples, path, places.layer, track, bed, config))
    if below is None:
        return kept.samples
    # Beside ink of a layer above it is not told which edge is whose.
    unsure = 2 * below.width
    away = away_from_above(bed.coordinates(path.points), places.layer, unsure)
    covered = away < below.width
    known = memory.last.results.known if memory.last is not None else None
    newest = track.layer == track.layer[-1:].max(initial=0)
    wanted = ~(away[shown] < unsure) & (kept.looks[shown] < np.where(newest, MOST_LOOKS, 1))
    # What is around tells how light and ink change, and is not kept.
    asked = maximum_filter1d(wanted, 2 * steady_window(typical_spacing(track.points)) - 1)
    for layer in np.unique(track.layer[wanted]).tolist():
        index = np.flatnonzero(asked & (track.layer == layer) & ~covered[shown])
        if layer == 0:
            found = measure_cross_sections(view, track, bed, config, index, known).samples
        else:
            found = measure_on_ink(view, track, bed, config, index, below,
                                   known, kept.samples.of(shown))
        chosen = np.flatnonzero(wanted[index])
        kept = kept.with_better(shown[index[chosen]], found.of(chosen))
    memory.kept = kept
    return with_covered(kept.samples, covered)


def away_from_above(places: Array, layer: Index, reach: float) -> Array:
    """Return how far (N,) samples are from the path of layers above [m]; inf = beyond reach.

    Args:
        places: (N, 2) of the path points along the bed [m].
        layer: (N,) of each.
        reach: how far is looked [m].
    """
    away = np.full(len(layer), np.inf)
    for number in range(int(layer.max())):
        own = np.flatnonzero(layer == number)
        away[own], _ = cKDTree(places[layer > number]).query(places[own],
                                                             distance_upper_bound=reach)
    return away


def with_covered(samples: Samples, covered: Flags) -> Samples:
    """Return samples of which those that were covered before they were measured are OCCLUDED."""
    never = covered & ~answered(samples)
    return replace(samples, verdicts=samples.verdicts.where(never, Status.OCCLUDED))
