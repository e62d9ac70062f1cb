"""Where a design lies in the robot base frame: told, or found from the path that was recorded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.design.alignment import (
    aligned,
    Alignment,
    explained,
    refined,
    SAME_COST_M,
)
from bpc_perception.core.design.design import Design, DesignError
from bpc_perception.core.design.pieces import Pieces
from bpc_perception.core.design.poses import starting_poses
from bpc_perception.core.design.recorded import RecordedInk
from bpc_perception.core.geometry import transform

LARGEST_RESIDUAL_M = 1e-3  # root mean square, of a path that follows the design
LEAST_EXPLAINED = 0.8  # share of the recorded ink that lies on the design, in order
LEAST_EXPLAINED_SCALED = 0.5  # the same of a design in another size
LARGEST_MISFIT = 0.02  # of the size
LARGEST_TILT_DEG = 10.0
TRIED = 10  # poses
HOPELESS = 0.5  # of the ink, by which a pose that is tried costs more than another
COARSE, FINE = 400, 4000  # points of the recorded ink
# Poses are the same that put the design no farther apart, and as good whose costs differ less.
SAME_M, SAME_COST = 0.5e-3, 0.02


@dataclass(frozen=True)
class Registration:
    """Where a design lies.

    Attributes:
        T_base_design: (4, 4) from the design's frame to the robot base; NaN = not found.
        residual: root mean square distance of the recorded ink from the design, across it [m];
            NaN = not found, or told.
        explained: share of the recorded ink that lies on the design, in its order; NaN alike.
        scale: size of the recorded ink against the design; NaN alike.
        refusal: why it is not found; empty = it is.
    """

    T_base_design: Array
    residual: float = np.nan
    explained: float = np.nan
    scale: float = np.nan
    refusal: str = ''


def place_at(x: float, y: float, z: float, yaw: float) -> Registration:
    """Return a registration that is told: the design's origin [m] and turn about z [rad].

    Raises:
        DesignError: a number is not finite.
    """
    if not np.isfinite((x, y, z, yaw)).all():
        raise DesignError(f'registration: expected finite numbers, found {x}, {y}, {z}, {yaw}'
                          '; give metres and radians')
    T_base_design = np.eye(4)
    T_base_design[:3, :3] = Rotation.from_euler('z', yaw).as_matrix()
    T_base_design[:3, 3] = x, y, z
    return Registration(T_base_design)


def register(design: Design, points: Array, stroke: Index, finished: bool = False,
             near: Registration | None = None) -> Registration:
    """Find where a design lies, from where the nozzle went while it laid ink.

    The design is turned about z and moved; tilted as well where the path says so. Strokes may be
    missing or surplus, and the print be half done. The order of the strokes and the direction in
    which they run decide between places that look alike, and then where fewer strokes are missing:
    a print that goes on is taken to have begun with its first one.

    Args:
        design: all of it.
        points: (N, 3) nozzle tip in the robot base frame [m].
        stroke: (N,) number of the recorded stroke, from 1; 0 = travel.
        finished: whether the print is over: then the last strokes may be missing as well.
        near: where it was found before, with less of the print: if it fits there, it is there.
    """
    ink = RecordedInk.of(points, stroke, finished)
    if ink is None:
        return _refused('registration: expected a recorded stroke of 0.5 mm or more, found none'
                        '; measure a print that lays ink, or tell where the design lies')
    pieces = Pieces.of(design)
    fine, coarse = ink.thinned(FINE), ink.thinned(COARSE)
    if near is not None and not near.refusal:
        best = refined(pieces, fine, explained(pieces, coarse, near.T_base_design))
        if not _misfit(pieces, fine, design, best):
            return _found(best)
    starts = sorted((explained(pieces, coarse, pose) for pose in starting_poses(design, fine)),
                    key=lambda one: one.cost)[:TRIED]
    tried = sorted((aligned(pieces, coarse, start.T_base_design) for start in starts
                    if start.cost <= starts[0].cost + HOPELESS * ink.length),
                   key=lambda one: one.cost)
    # Of those that leave out as much, the nearest.
    least = tried[0].cost + SAME_COST_M
    tried.sort(key=lambda one: (one.cost > least, one.residual))
    best = refined(pieces, fine, tried[0])
    refusal = _misfit(pieces, fine, design, best) or _ambiguity(pieces, coarse, best, tried)
    if refusal:
        return _refused(refusal)
    return _found(best)


def _found(best: Alignment) -> Registration:
    return Registration(best.T_base_design, best.residual, best.explained, best.scale)


def _refused(refusal: str) -> Registration:
    return Registration(np.full((4, 4), np.nan), refusal=refusal)


def _misfit(pieces: Pieces, ink: RecordedInk, design: Design, best: Alignment) -> str:
    """Return why the best alignment does not fit; empty = it does."""
    fits = best.residual <= LARGEST_RESIDUAL_M and best.explained >= LEAST_EXPLAINED
    scale = best.scale
    if not fits:
        found = max((explained(pieces, ink.thinned(COARSE), pose)
                     for pose in starting_poses(design, ink, scaled=True)),
                    key=lambda one: one.explained)
        scale = found.scale if found.explained >= LEAST_EXPLAINED_SCALED else np.nan
    if abs(scale - 1) > LARGEST_MISFIT:
        return (f'registration: expected the print as large as the design, found it {scale:.1%} '
                'of that; is the design in another unit, millimetres or inches?')
    if not fits:
        return ('registration: expected the recorded strokes on those of the design, found '
                f'{best.explained:.0%} of their length there, {1e3 * best.residual:.2f} mm off '
                '(root mean square); is it the design of this print? Else tell where it lies')
    tilt = float(np.degrees(np.arccos(np.clip(best.T_base_design[2, 2], -1, 1))))
    if tilt > LARGEST_TILT_DEG:
        return (f'registration: expected a bed tilted by up to {LARGEST_TILT_DEG:g} degrees, '
                f'found {tilt:.1f}; tell where the design lies')
    return ''


def _ambiguity(pieces: Pieces, ink: RecordedInk, best: Alignment,
               tried: list[Alignment]) -> str:
    """Return why another place is as good as the best; empty = none is."""
    corners = pieces.middle[[0, len(pieces) // 2, -1]]
    extent = np.ptp(pieces.middle, axis=0)
    corners = np.vstack((corners, pieces.middle.min(axis=0) + np.diag(extent)))
    slack = SAME_COST * ink.length
    for other in tried[1:]:
        apart = np.linalg.norm(transform(other.T_base_design, corners)
                               - transform(best.T_base_design, corners), axis=1).max()
        alike = other.cost <= tried[0].cost + slack and other.is_as_near(tried[0])
        if apart > max(SAME_M, 4 * best.residual) and alike:
            x, y, z = (1e3 * (other.T_base_design[:3, 3] - best.T_base_design[:3, 3])).tolist()
            return ('registration: expected one place where the design fits, found another as '
                    f'good, {x:+.1f}, {y:+.1f}, {z:+.1f} mm away; tell where the design lies')
    return ''
