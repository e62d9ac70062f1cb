"""How far nozzle and bead are from the design, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.design.design import Design
from bpc_perception.core.design.pieces import Pieces
from bpc_perception.core.design.recorded import TANGENT_M
from bpc_perception.core.filters import runs
from bpc_perception.core.geometry import unit_vectors
from bpc_perception.core.path.tangents import smoothed_tangents
from bpc_perception.core.profile import Status, ThicknessProfile

AROUND = 16  # pieces around a point, among which one of its own stroke is looked for
BESIDE_M = 0.1e-3  # by which it may be farther
REACH_M = 2e-3  # from the design, beyond which ink is none of it


@dataclass(frozen=True)
class Spread:
    """How values are spread, of which NaN does not count.

    Attributes:
        count: how many are known.
        mean, rms: mean and root mean square; NaN without any.
        most, most_of_95: the largest of their sizes, and that below which 95 % are; NaN alike.
    """

    count: int
    mean: float
    rms: float
    most: float
    most_of_95: float

    @classmethod
    def of(cls, values: Array) -> Spread:
        """Return the spread of values (N,)."""
        known = values[np.isfinite(values)]
        if not len(known):
            return cls(0, np.nan, np.nan, np.nan, np.nan)
        size = np.abs(known)
        return cls(len(known), float(known.mean()), float(np.sqrt(np.mean(known**2))),
                   float(size.max()), float(np.percentile(size, 95)))


@dataclass(frozen=True)
class Deviations:
    """N samples of a profile beside the design.

    Attributes:
        piece: (N,) number of the design's piece that each is of; -1 = none, or travel.
        layer: (N,) number of the layer that each is in, also where it is beside the design; -1 on
            travel.
        nozzle: (N,) how far the nozzle passed to the left of the design, along its direction and
            seen from above [m]; NaN where it is of no piece.
        bead: (N,) the same of the middle of the bead [m]; NaN unless MEASURED as well.
        width: (N,) wanted [m]; NaN = not told, or of no piece.
        middle: (N, 3) of the bead, as high as the nozzle was, in the base frame [m]; NaN unless
            MEASURED.
        surplus: (N,) whether ink was commanded where no design is.
    """

    piece: Index
    layer: Index
    nozzle: Array
    bead: Array
    width: Array
    middle: Array
    surplus: Flags


def deviations_of(profile: ThicknessProfile, pieces: Pieces, up: Array,
                  reach: float = REACH_M) -> Deviations:
    """Return how far the samples of a profile are from a design.

    Args:
        profile: N samples.
        pieces: of the design, in the base frame, see ``placed``.
        up: (3,) of the design, in the base frame.
        reach: within which ink is of the design [m].
    """
    laid = profile.stroke > 0
    near = path_pieces(profile.points, profile.stroke, pieces)
    found = np.where(near >= 0, near, 0)
    offset, _ = pieces.offsets(profile.points, found)
    inside = laid & (near >= 0) & (np.linalg.norm(offset, axis=1) <= reach)
    left = unit_vectors(np.cross(up, pieces.tangent))
    measured = profile.status == Status.MEASURED
    middle = np.where(measured[:, None], (profile.left_points + profile.right_points) / 2, np.nan)
    # Side points lie on the surface, the design where the nozzle is.
    middle = middle + up * ((profile.points - middle) @ up)[:, None]
    own = pieces.nearest(middle, np.where((near >= 0)[:, None], pieces.tangent[found], np.nan))
    at = np.where(own >= 0, own, 0)
    bead = np.einsum('nk,nk->n', pieces.offsets(middle, at)[0], left[at])
    nozzle = np.einsum('nk,nk->n', offset, left[found])
    return Deviations(
        piece=np.where(inside, found, -1),
        layer=np.where(laid & (near >= 0), pieces.layer[found], -1),
        nozzle=np.where(inside, nozzle, np.nan),
        bead=np.where(inside & (own >= 0), bead, np.nan),
        width=np.where(inside, pieces.width[found], np.nan),
        middle=middle, surplus=laid & ~inside & (near >= 0))


def placed(design: Design, T_base_design: Array) -> tuple[Pieces, Array]:
    """Return a design in pieces in the base frame, and where up (3,) is there.

    Args:
        design: in its own frame.
        T_base_design: (4, 4) where it lies.
    """
    return Pieces.of(design.moved_by(T_base_design)), T_base_design[:3, 2]


def path_pieces(points: Array, stroke: Index, pieces: Pieces) -> Index:
    """Return the piece (N,) that is near each point of strokes (N, 3); -1 = travel, not known.

    Args:
        points: (N, 3) in the base frame [m].
        stroke: (N,) number of the stroke; 0 = travel.
        pieces: in the base frame.
    """
    near = np.full(len(points), -1)
    laid = np.flatnonzero((stroke > 0) & np.isfinite(points).all(axis=1))
    if len(laid):
        piece = runs(stroke)[0][laid]
        ways = smoothed_tangents(points[laid], piece, np.arange(len(laid)), TANGENT_M)
        found = pieces.nearest(points[laid], np.nan_to_num(ways))
        near[laid] = _on_own_stroke(points[laid], piece, found, pieces)
    return near


def _on_own_stroke(points: Array, piece: Index, found: Index, pieces: Pieces) -> Index:
    """Return pieces (N,) of the design's stroke that most of a path's stroke is of, if near.

    At a corner the path runs neither way, and where it turns back it may seem to run as another.

    Args:
        points: (N, 3) of the path [m].
        piece: (N,) number of the stroke of the path.
        found: (N,) number of the design's piece.
        pieces: of the design.
    """
    pair, count = np.unique(np.stack((piece, pieces.stroke[found])), axis=1, return_counts=True)
    order = np.lexsort((count, pair[0]))
    last = np.flatnonzero(np.diff(pair[0][order], append=-1) != 0)
    own = pair[1][order[last]][np.searchsorted(pair[0][order[last]], piece)]
    away, near = cKDTree(pieces.middle).query(points, min(AROUND, len(pieces)))
    away, near = away.reshape(len(points), -1), near.reshape(len(points), -1)
    same = pieces.stroke[near] == own[:, None]
    first = np.argmax(same, axis=1)[:, None]
    chosen, far = (np.take_along_axis(values, first, axis=1)[:, 0] for values in (near, away))
    limit = np.linalg.norm(points - pieces.middle[found], axis=1) + BESIDE_M
    wrong = (pieces.stroke[found] != own) & same.any(axis=1) & (far <= limit)
    return np.where(wrong, chosen, found)
