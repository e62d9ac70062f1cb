"""How well a design lies on recorded ink, and how to bring it nearer."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.design.pieces import Pieces
from bpc_perception.core.design.poses import fitted
from bpc_perception.core.design.recorded import RecordedInk
from bpc_perception.core.geometry import transform

NEAR_M = 1e-3  # from a stroke that runs the same way, within which ink is of it
SAME_WAY = 0.5  # cosine
ORDER_M = 1e-3  # of ink, by which order may be wrong by noise
LAST = 0.98  # of what lies on the design, in its order, tells how far the print has come
HOLE = 2.5  # points without which there is a hole in what was printed
ALIKE = 0.05  # by how much of its length a stroke may differ from its design
SAME_COST_M = 1e-3  # that makes no alignment better
ROUNDS, SLIDES = 25, 4
STILL_M = 1e-6  # a step that is none
AS_NEAR = 1.5
LEAST_SPREAD_M = 5e-5  # of distances: what is nearer counts fully
# A motion that so little depends on is not told by the path, such as a turn about a line.
UNKNOWN = 0.01
# A tilt is one by F(2, n) at which chance is 1 of 400, n ways of ink that err independently.
TILTED, INDEPENDENT_M = 6.0, 0.5e-3


@dataclass(frozen=True)
class Alignment:
    """A design at a place.

    Attributes:
        T_base_design: (4, 4), or a similarity [m].
        residual: root mean square distance of the ink that lies on it, across [m]; NaN = none.
        explained: share of the ink that lies on it, in its order.
        cost: length of the ink that does not, and of strokes that are left out [m].
        scale: size of the recorded ink against the design.
    """

    T_base_design: Array
    residual: float
    explained: float
    cost: float
    scale: float

    def is_as_near(self, other: Alignment) -> bool:
        """Return whether the ink is about as near to the design as by another alignment."""
        return self.residual <= max(AS_NEAR * other.residual, LEAST_SPREAD_M)


def explained(pieces: Pieces, ink: RecordedInk, pose: Array) -> Alignment:
    """Return how well a design in pieces lies on ink, by a similarity (4, 4).

    What of the design lies behind the last ink is yet to come, unless the ink is all there is.
    """
    scale = float(np.cbrt(np.linalg.det(pose[:3, :3])))
    found = _Matches.of(pieces, ink, pose)
    away = scale * np.linalg.norm(found.offset, axis=1)
    near = found.same_way & (away <= NEAR_M)
    order = pieces.ink[found.piece[near]]
    kept = _in_order(order)
    done = np.sort(order[kept])
    share = len(done) / len(ink)
    end = float(np.quantile(done, LAST)) if len(done) else 0.0
    last = [pieces.ink[-1]] if ink.complete else []
    hole = np.diff([0.0, *done[done <= end], *last]) - HOLE * ink.length / scale / len(ink)
    residual = float(np.sqrt(np.mean(away[near]**2))) if near.any() else np.nan
    cost = (1 - share) * ink.length + scale * float(hole[hole > 0].sum())
    return Alignment(pose, residual, share, cost, scale)


def aligned(pieces: Pieces, ink: RecordedInk, pose: Array) -> Alignment:
    """Return a design that was brought as near to ink as can be, from a pose (4, 4)."""
    found = _nearer(pieces, ink, pose)
    along = _nearer(pieces, ink, _slid(pieces, ink, found.T_base_design))
    return along if along.cost <= found.cost + SAME_COST_M and along.is_as_near(found) else found


def _nearer(pieces: Pieces, ink: RecordedInk, pose: Array) -> Alignment:
    """Return the alignment to which a pose (4, 4) leads."""
    flat = explained(pieces, ink, _brought(pieces, ink, pose, 'turned'))
    tilted = explained(pieces, ink, _brought(pieces, ink, pose, 'tilted'))
    ways = 2 * ink.length / INDEPENDENT_M
    told = flat.residual**2 > (1 + 2 * TILTED / ways) * tilted.residual**2
    return tilted if told or tilted.cost < flat.cost - NEAR_M else flat


def _slid(pieces: Pieces, ink: RecordedInk, pose: Array) -> Array:
    """Return a pose (4, 4) by which strokes begin and end where they were recorded.

    Near to a circle, or to parallel lines, is not where they begin.

    Args:
        pieces: of the design.
        ink: as recorded.
        pose: that shows which stroke of the design each recorded one is.
    """
    matched = _Matches.of(pieces, ink, pose)
    laid = pieces.stroke[np.where(matched.same_way, matched.piece, 0)]
    count = np.bincount(pieces.stroke, 2 * pieces.half)
    begin = np.concatenate(([0.0], np.cumsum(count)[:-1]))
    source, target = [], []
    for number, length in enumerate(ink.lengths.tolist()):
        own = np.flatnonzero(ink.stroke == number)
        stroke = int(np.bincount(laid[own]).argmax())
        ratio = length / count[stroke]
        if abs(ratio - 1) <= ALIKE:
            share = (ink.along[own] - ink.along[own[0]]) / length
            place = np.searchsorted(pieces.ink, begin[stroke] + share * count[stroke])
            source.append(pieces.middle[np.minimum(place, len(pieces) - 1)])
            target.append(ink.points[own])
    if not source:
        return pose
    one, other = np.concatenate(source), np.concatenate(target)
    for _ in range(SLIDES):
        away = np.linalg.norm(transform(pose, one) - other, axis=1)
        pose = fitted(one, other, 1 / np.maximum(away, NEAR_M))
    return pose


def refined(pieces: Pieces, ink: RecordedInk, found: Alignment) -> Alignment:
    """Return an alignment by all points, with the size that the ink has against the design."""
    best = aligned(pieces, ink, found.T_base_design)
    similar = _brought(pieces, ink, best.T_base_design, 'scaled')
    scale = float(np.cbrt(np.linalg.det(similar[:3, :3])))
    return Alignment(best.T_base_design, best.residual, best.explained, best.cost, scale)


@dataclass(frozen=True)
class _Matches:
    """Which pieces N points of ink belong to.

    Attributes:
        points: (N, 3) in the design's frame [m].
        piece: (N,) number of the piece.
        offset: (N, 3) from it [m].
        held: (N,) whether the point lies beyond the end of a stroke, or is such an end itself.
        same_way: (N,) whether it runs the same way.
    """

    points: Array
    piece: Index
    offset: Array
    held: Flags
    same_way: Flags

    @classmethod
    def of(cls, pieces: Pieces, ink: RecordedInk, pose: Array) -> _Matches:
        back = np.asarray(np.linalg.inv(pose), np.float64)
        points = transform(back, ink.points)
        ways = ink.directions @ (back[:3, :3] / np.cbrt(np.linalg.det(back[:3, :3]))).T
        piece = pieces.nearest(points, np.nan_to_num(ways))
        offset, along = pieces.offsets(points, piece)
        opens, closes = pieces.opens[piece], pieces.closes[piece]
        held = (opens & (along < -pieces.half[piece])) | (closes & (along > pieces.half[piece]))
        # An end belongs to an end.
        for ends, side in ((ink.begins & opens, -1), (ink.ends & closes, 1)):
            away = (along - side * pieces.half[piece])[:, None] * pieces.tangent[piece]
            across = offset - np.einsum('nk,nk->n', offset, pieces.tangent[piece])[:, None] * (
                pieces.tangent[piece])
            offset = np.where(ends[:, None], across + away, offset)
            held |= ends
        same_way = np.einsum('nk,nk->n', np.nan_to_num(ways), pieces.tangent[piece]) >= SAME_WAY
        return cls(points, piece, offset, held, same_way)


def _in_order(order: Array) -> Index:
    """Return the index (K,) of the longest part of numbers (N,) that does not fall [m]."""
    rounded = np.floor(order / ORDER_M)
    tops: list[float] = []
    places: list[int] = []
    before = np.full(len(order), -1)
    for index, value in enumerate(rounded.tolist()):
        place = bisect_right(tops, value)
        before[index] = places[place - 1] if place else -1
        tops[place:place + 1], places[place:place + 1] = [value], [index]
    kept = []
    last = places[-1] if places else -1
    while last >= 0:
        kept.append(last)
        last = int(before[last])
    return np.array(kept[::-1], np.intp)


def _brought(pieces: Pieces, ink: RecordedInk, pose: Array, how: str) -> Array:
    """Return a pose (4, 4) from which the ink is nearest to the lines of the design.

    By Gauss and Newton, with weights that fall with distance (Tukey's biweight).

    Args:
        pieces: of the design.
        ink: as recorded.
        pose: to begin with.
        how: 'turned' about z and moved, 'tilted' as well, or 'scaled' on top of that.
    """
    back = np.linalg.inv(pose)
    for _ in range(ROUNDS):
        found = _Matches.of(pieces, ink, np.linalg.inv(back))
        step = _step(pieces, found, how)
        back = step @ back
        if np.abs(transform(step, found.points) - found.points).max() < STILL_M:
            break
    return np.asarray(np.linalg.inv(back))


def _step(pieces: Pieces, found: _Matches, how: str) -> Array:
    """Return the similarity (4, 4) that brings matched points nearer to their pieces."""
    centre = found.points.mean(axis=0)
    arm = found.points - centre
    size = max(float(np.sqrt(np.mean(np.sum(arm**2, axis=1)))), 1e-6)
    arm = arm / size
    weight = _weights(np.linalg.norm(found.offset, axis=1)) * found.same_way
    if not weight.any():
        return np.eye(4)
    axes = np.eye(3)
    turns = axes if how != 'turned' else axes[2:]
    columns = [np.cross(axis, arm) for axis in turns]
    columns += [np.broadcast_to(axis, arm.shape) for axis in axes]
    if how == 'scaled':
        columns.append(arm)
    motion = np.stack(columns, axis=2)
    # Along a stroke a point may lie anywhere, but not beyond its end.
    tangent = pieces.tangent[found.piece] * ~found.held[:, None]
    motion = motion - tangent[:, :, None] * np.einsum('nk,nkc->nc', tangent, motion)[:, None]
    root = np.sqrt(weight)[:, None]
    matrix = (root[:, :, None] * motion).reshape(-1, motion.shape[2])
    inverse = np.linalg.pinv(matrix.T @ matrix, rcond=UNKNOWN**2, hermitian=True)
    solved = -inverse @ matrix.T @ (root * found.offset).ravel() / size
    count = len(turns)
    step = np.eye(4)
    step[:3, :3] = Rotation.from_rotvec(solved[:count] @ turns).as_matrix()
    if how == 'scaled':
        step[:3, :3] *= 1 + np.clip(solved[-1], -0.2, 0.2)
    step[:3, 3] = centre + size * solved[count:count + 3] - step[:3, :3] @ centre
    return step


def _weights(away: Array) -> Array:
    """Return the weight (N,) of distances (N,) [m]."""
    spread = max(1.48 * float(np.median(away)), LEAST_SPREAD_M)
    return np.asarray(np.clip(1 - (away / (4.7 * spread))**2, 0, None)**2)
