"""Poses of a design to try: its strokes in their order, put on those that were recorded."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.design.design import Design
from bpc_perception.core.design.recorded import RecordedInk
from bpc_perception.core.geometry import transform

POINTS = 17  # of a stroke, that tell where it is
ALIKE = 0.1  # by how much of their length strokes that belong together may differ
FARTHEST_SHIFT = 500  # of one order against the other [strokes]
TRIED_SHIFTS = 7
PARTS = 3  # of the strokes, each of which may be complete
ROUNDS = 12  # until what most strokes say is found
FLOOR_M = 1e-4  # to which strokes have to agree
TILTED = 1.15  # by how much a tilt has to bring strokes nearer, to be one
LARGEST_TILT = 0.3  # [rad]; beyond it, a part of a flat design was turned over


def starting_poses(design: Design, ink: RecordedInk, scaled: bool = False) -> list[Array]:
    """Return poses T_base_design (4, 4) to try, the most likely first.

    Args:
        design: all of it.
        ink: as it was recorded.
        scaled: whether the design may have another size. Then poses are similarities.
    """
    pairs = _Pairs.of(design, ink, scaled)
    count, recorded = len(pairs.design), len(pairs.recorded)
    shifts = np.arange(-min(recorded - 1, FARTHEST_SHIFT), min(count, FARTHEST_SHIFT))
    weight = np.array([pairs.matching(shift) for shift in shifts.tolist()])
    likely = np.lexsort((np.abs(shifts), -weight.round(6)))[:TRIED_SHIFTS]
    poses = [pose for place in likely if weight[place] > 0
             for pose in pairs.poses(int(shifts[place]))]
    return [*poses, _pose_of_all(design, ink, scaled)]


@dataclass(frozen=True)
class _Pairs:
    """Strokes of the design beside those that were recorded.

    Attributes:
        design: (D, K, 3) points of each stroke, evenly along it [m].
        design_length: (D,) [m].
        recorded: (R, K, 3) the same of what was recorded.
        length: (R,) [m].
        begun: (D, K, 3) points of the design's strokes as far along as the last recorded stroke
            goes, which may not be done yet.
        scaled: whether the design may have another size.
    """

    design: Array
    design_length: Array
    recorded: Array
    length: Array
    begun: Array
    scaled: bool

    @classmethod
    def of(cls, design: Design, ink: RecordedInk, scaled: bool) -> _Pairs:
        share = np.linspace(0, 1, POINTS)
        last = float(ink.lengths[-1])
        borders = np.flatnonzero(np.diff(ink.stroke, prepend=-1, append=ink.stroke[-1] + 1))
        recorded = [_along(ink.points[one:two], ink.along[one:two] - ink.along[one],
                           share * (ink.along[two - 1] - ink.along[one]))
                    for one, two in pairwise(borders.tolist())]
        strokes = design.strokes
        return cls(
            np.array([_along(stroke.points, stroke.arc_length, share * stroke.length)
                      for stroke in strokes]),
            np.array([stroke.length for stroke in strokes]), np.array(recorded), ink.lengths,
            np.array([_along(stroke.points, stroke.arc_length,
                             share * min(last, stroke.length)) for stroke in strokes]), scaled)

    def _beside(self, shift: int) -> tuple[Index, Index, Flags]:
        """Return which strokes (P,) lie beside each other at a shift, and which of them fit."""
        mine = np.arange(max(0, -shift), min(len(self.length), len(self.design) - shift))
        ratio = self.length[mine] / self.design_length[mine + shift]
        size = float(np.median(ratio)) if self.scaled else 1.0
        fits = np.abs(ratio / size - 1) <= ALIKE
        if not self.scaled:
            fits |= (mine == len(self.length) - 1) & (ratio < 1)
        return mine, mine + shift, fits

    def matching(self, shift: int) -> float:
        """Return the length of recorded ink beside which there is a stroke as long [m]."""
        mine, _, fits = self._beside(shift)
        return float(self.length[mine[fits]].sum())

    def poses(self, shift: int) -> list[Array]:
        """Return poses (4, 4) that most strokes agree on at a shift: all, and each part of them.

        Where a stroke is missing, only those before it are beside their own.
        """
        mine, theirs, fits = self._beside(shift)
        mine, theirs = mine[fits], theirs[fits]
        source = self.design[theirs]
        if not self.scaled and mine[-1] == len(self.length) - 1:
            source[-1] = self.begun[theirs[-1]]
        parts = [slice(None), *(slice(part[0], part[-1] + 1) for part in np.array_split(
            np.arange(len(mine)), PARTS) if len(mine) >= PARTS)]
        return [_agreed(source[part], self.recorded[mine[part]], self.length[mine[part]],
                        self.scaled) for part in parts]


def _pose_of_all(design: Design, ink: RecordedInk, scaled: bool) -> Array:
    """Return the pose (4, 4) by the length of ink alone, wherever strokes begin and end."""
    points = np.concatenate([stroke.points for stroke in design.strokes])
    before = np.cumsum([0.0, *(stroke.length for stroke in design.strokes)])
    along = np.concatenate([start + stroke.arc_length for start, stroke
                            in zip(before[:-1], design.strokes, strict=True)])
    size = ink.length / along[-1] if scaled else 1.0
    kept = ink.along <= along[-1] * size
    source = _along(points, along, ink.along[kept] / size)
    return _agreed(source[:, None], ink.points[kept][:, None], np.ones(len(source)), scaled)


def _along(points: Array, arc_length: Array, asked: Array) -> Array:
    """Return the points (K, 3) at arc lengths (K,) of a line (N, 3)."""
    return np.stack([np.interp(asked, arc_length, column) for column in points.T], axis=1)


def _agreed(source: Array, target: Array, weight: Array, scaled: bool) -> Array:
    """Return the pose (4, 4) on which most of P groups of points (P, K, 3) agree.

    Args:
        source: in the design's frame [m].
        target: where they are [m].
        weight: (P,) of each group.
        scaled: whether it may have another size.
    """
    trust = weight
    pose = np.eye(4)
    for _ in range(ROUNDS):
        pose = fitted(source.reshape(-1, 3), target.reshape(-1, 3),
                      np.repeat(trust, source.shape[1]), scaled)
        misfit = np.sqrt(np.mean(np.sum((transform(pose, source) - target)**2, axis=2), axis=1))
        trust = weight / np.maximum(misfit, FLOOR_M)
    return pose


def fitted(source: Array, target: Array, weight: Array, scaled: bool = False) -> Array:
    """Return the pose (4, 4) that brings points (N, 3) nearest to others (N, 3).

    It turns about z, unless a tilt brings them clearly nearer. Weights are (N,).
    """
    flat = _fit(source, target, weight, scaled, np.array((1.0, 1.0, 0.0)))
    full = _fit(source, target, weight, scaled, np.ones(3))
    if full[2, 2] > np.cos(LARGEST_TILT) * np.cbrt(np.linalg.det(full[:3, :3])) and (
            _misfit(flat, source, target, weight)
            > TILTED * _misfit(full, source, target, weight) + 1e-6):
        return full
    return flat


def _misfit(pose: Array, source: Array, target: Array, weight: Array) -> float:
    away = np.sum((transform(pose, source) - target)**2, axis=1)
    return float(np.sqrt(np.average(away, weights=weight)))


def _fit(source: Array, target: Array, weight: Array, scaled: bool, used: Array) -> Array:
    """Return the nearest similarity by Umeyama (1991), for which coordinates (3,) are used."""
    centre, other = (np.average(points, axis=0, weights=weight) for points in (source, target))
    one, two = (source - centre) * used, (target - other) * used
    moments = (two * weight[:, None]).T @ one
    if used[2] == 0:
        angle = np.arctan2(moments[1, 0] - moments[0, 1], moments[0, 0] + moments[1, 1])
        rotation = Rotation.from_euler('z', angle).as_matrix()
    else:
        u, _, vt = np.linalg.svd(moments)
        sign = np.array((1.0, 1.0, np.sign(np.linalg.det(u @ vt))))
        rotation = (u * sign) @ vt
    size = 1.0
    if scaled:
        turned = one @ rotation.T
        size = float(np.sum(weight[:, None] * turned * two)
                     / max(np.sum(weight[:, None] * one**2), 1e-30))
        size = max(size, 1e-6)
    pose = np.eye(4)
    pose[:3, :3] = size * rotation
    pose[:3, 3] = other - pose[:3, :3] @ centre
    return pose
