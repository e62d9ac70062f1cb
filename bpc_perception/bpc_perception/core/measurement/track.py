"""What of a path is measured: the points of its strokes that are in view, in unbroken pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs
from bpc_perception.core.geometry import unit_vectors
from bpc_perception.core.path.deposition_path import DepositionPath

FAR_M = 1e3  # between strokes that are not connected, as length along the ink
CONNECTED_M = 0.001  # a stroke that begins so near to the end of the last, in about the same
CONNECTED_COS = 0.7  # direction, goes on with it
DIRECTION_POINTS = 5  # that tell a direction


@dataclass(frozen=True)
class Track:
    """N points of a path, in pieces between which it breaks off.

    Attributes:
        print_id: of the print.
        time: (N,) when the nozzle passed [s].
        points: (N, 3) nozzle tip in the robot base frame [m].
        extruding: (N,) whether ink was being pushed out.
        flow_rate: (N,) that was commanded [m^3/s]; NaN = unknown.
        piece: (N,) number of the piece that each point belongs to, never falling.
        along: (N,) length along the ink; strokes that are not connected are ``FAR_M`` apart [m].
        layer: (N,) of each; see path.layers.
    """

    print_id: str
    time: Array
    points: Array
    extruding: Flags
    flow_rate: Array
    piece: Index
    along: Array
    layer: Index

    def __len__(self) -> int:
        return len(self.time)

    def of(self, index: Index) -> Track:
        """Return the points of an index (K,), increasing."""
        return Track(self.print_id, self.time[index], self.points[index], self.extruding[index],
                     self.flow_rate[index], self.piece[index], self.along[index],
                     self.layer[index])


def track_along(path: DepositionPath, stroke: Index, kept: Index,
                layer: Index | None = None) -> Track:
    """Return the track along points of a path.

    Args:
        path: P points.
        stroke: (P,) number of the stroke of each, from 1; those of travel are below 1.
        kept: (N,) index of the points, increasing.
        layer: (P,) of each point; None = all on the bed.
    """
    points, number = path.points[kept], stroke[kept]
    other = number[1:] != number[:-1]
    connected = ~other
    first, end = runs(number)
    for last in np.flatnonzero(other & (number[1:] > 0) & (number[:-1] > 0)).tolist():
        connected[last] = _goes_on(points[first[last]:last + 1], points[last + 1:end[last + 1]])
    step = np.where(other, np.linalg.norm(np.diff(points, axis=0), axis=1),
                    np.diff(path.arc_length[kept]))
    along = np.concatenate(([0.0], np.cumsum(np.where(connected, step, FAR_M))))[:len(kept)]
    broken = (np.diff(kept) > 1) & ~(other & connected) | ~connected
    piece = np.concatenate(([0], np.cumsum(broken)))[:len(kept)]
    layer = np.zeros(len(path), np.intp) if layer is None else layer
    return Track(path.print_id, path.time[kept], points, path.extruding[kept],
                 path.flow_rate[kept], piece, along, layer[kept])


def _goes_on(stroke: Array, following: Array) -> bool:
    """Return whether a stroke (A, 3) goes on in the next (B, 3)."""
    if np.linalg.norm(following[0] - stroke[-1]) > CONNECTED_M:
        return False
    before, after = unit_vectors(np.stack((
        stroke[-1] - stroke[-1 - DIRECTION_POINTS:][0],
        following[:DIRECTION_POINTS + 1][-1] - following[0])))
    return bool(before @ after > CONNECTED_COS)
