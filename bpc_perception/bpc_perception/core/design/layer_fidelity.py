"""How well each layer of a design is printed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.design.deviation import Deviations, Spread
from bpc_perception.core.design.pieces import Pieces
from bpc_perception.core.design.presence import Presence
from bpc_perception.core.geometry import Plane

DELTA_M = 0.5e-3  # closer than that, printed and design point match


@dataclass(frozen=True)
class LayerFidelity:
    """A layer of a design beside what is printed of it, seen from above.

    Attributes:
        layer: its number, from 0.
        fidelity: share of the points of the design to which printed ink is closer than delta, of
            those of which that is known (layer fidelity of P-OCT, Int. J. Bioprinting 9-1, pp.
            55-69); NaN without any.
        known: number of these points.
        designed: number of all points of the layer.
        to_print: distances from these points to printed ink [m].
        to_design: distances from printed ink, where it was measured, to the design [m].
    """

    layer: int
    fidelity: float
    known: int
    designed: int
    to_print: Spread
    to_design: Spread

    @property
    def hausdorff(self) -> float:
        """Hausdorff distance of what is known [m]: the largest in either direction; NaN = none."""
        return float(np.maximum(self.to_print.most, self.to_design.most))


def layers_of(pieces: Pieces, deviations: Deviations, presence: Index, up: Array,
              delta: float = DELTA_M) -> tuple[LayerFidelity, ...]:
    """Return how well each layer of a design is printed.

    What is yet to come or was not seen does not count. What was seen missing, or skipped, does.

    Args:
        pieces: M of the design, in the base frame.
        deviations: of the profile from it.
        presence: (M,) what became of each piece.
        up: (3,) of the design, in the base frame.
        delta: closer than which points match [m].
    """
    known = ~np.isin(presence, (Presence.YET_TO_COME, Presence.NOT_SEEN))
    measured = np.isfinite(deviations.middle).all(axis=1)
    plane = Plane(up, 0.0)
    return tuple(
        _layer(int(layer), pieces.where(pieces.layer == layer), known[pieces.layer == layer],
               deviations.middle[measured & (deviations.layer == layer)], plane, delta)
        for layer in np.unique(pieces.layer))


def _layer(layer: int, pieces: Pieces, known: Flags, middle: Array, plane: Plane,
           delta: float) -> LayerFidelity:
    """Return how well a layer is printed, by the middle (K, 3) of beads in it."""
    to_print = np.full(len(pieces), np.nan)
    to_design = np.empty(0)
    if len(middle):
        away = cKDTree(plane.coordinates(middle)).query(plane.coordinates(pieces.middle))[0]
        to_print = np.where(known, away, np.nan)
        offset, _ = pieces.offsets(middle, pieces.closest(middle))
        to_design = np.linalg.norm(plane.coordinates(offset), axis=1)
    # Where nothing is printed at all, nothing matches.
    matches = np.nan_to_num(to_print, nan=np.inf) < delta
    fidelity = (float(np.average(matches[known], weights=pieces.half[known])) if known.any()
                else np.nan)
    return LayerFidelity(layer, fidelity, int(known.sum()), len(pieces), Spread.of(to_print),
                         Spread.of(to_design))
