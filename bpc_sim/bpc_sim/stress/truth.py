"""What can be known of each path sample of a scene, and a scene that carries this truth.

The cross segment of a sample is the piece of the line across the path on which its own pass has
laid ink: as long as the bead is wide, in a gap the path point alone. A single width exists, and
its edges are seen, where no other ink meets or nearly meets that segment.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_sim.ink.deposit import Deposit, SEAM
from bpc_sim.ink.strands import strands

STAMP_NS = 10**12  # of every capture: any time after the print
SPEED = 3e-3  # of the nozzle [m/s]

BORDER = 1.0  # this near to where ink starts or ends, either answer is right [pixels]
CLEARANCE = 2.0  # other ink this near is not surely resolved [pixels]
THIN = 3.0  # narrower ink is not surely seen [pixels]
TOUCH = 1e-6  # strands that are closer touch [m]
SAME = 1e-5  # nearer along the path, ink is the segment's own [m]
PASS = 1.25  # nearer along the path, ink is of the same pass [widths]

Categories = NDArray[np.uint8]


class Truth(IntEnum):
    """What is right to say of a sample.

    MEASURED: a single width exists and both of its edges are seen.
    GAP: the bed is seen, without ink.
    JUNCTION: ink of an earlier or later pass of the path meets the cross segment.
    HIDDEN: the path point or an edge is behind the nozzle or outside the image.
    EDGE: any answer: at a border of the others, to the distances above; at corners, where the
        segment meets the other leg; where spilled ink joins the bead; at the seam of a closed
        path, which meets itself without changing its width.
    """

    MEASURED = 0
    GAP = 1
    JUNCTION = 2
    HIDDEN = 3
    EDGE = 4


@dataclass(frozen=True, eq=False)
class StressScene:
    """A capture, the path of its print, and what is true of it; arrays of N samples.

    Attributes:
        name: of the scene.
        capture: what the camera delivers.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame.
        points: (N, 3) nozzle tip in the base frame [m].
        arc_length: (N,) along these points, evenly spaced [m].
        thickness: (N,) true width of the pass [m], 0 in gaps; to be compared where MEASURED.
        expected: (N,) values of Truth.
        pixel: length of a pixel's side on the bed [m].
    """

    name: str
    capture: Capture
    T_base_camera: Array
    points: Array
    arc_length: Array
    thickness: Array
    expected: Categories
    pixel: float

    def __len__(self) -> int:
        return len(self.points)

    @property
    def path(self) -> DepositionPath:
        """The path as a recorder gives it; the extruder knows nothing of the gaps."""
        unknown = np.full(len(self), np.nan)
        return DepositionPath(
            self.name, 0, STAMP_NS * 1e-9, True, self.arc_length / SPEED, self.arc_length,
            self.points, unknown, unknown, np.ones(len(self), bool))


def judge(deposit: Deposit, s: Array, pixel: float, drops: Array | None = None) -> Categories:
    """Categories (N,) of samples at arc lengths s (N,) [m], all in view.

    Args:
        deposit: the ink along the path.
        s: arc lengths [m].
        pixel: length of a pixel's side on the bed [m].
        drops: (D, 3) centre and radius of round drops of spilled ink [m].
    """
    width = deposit.width(s)
    near, far = clearances(deposit, s)
    if drops is not None:
        near = np.minimum(near, drop_clearance(deposit, s, drops))
    category = np.where(width > 0, Truth.MEASURED, Truth.GAP)
    border = np.abs(s[:, None] - deposit.runs.ravel()).min(axis=1, initial=np.inf)
    unsure = (border <= BORDER * pixel) | (np.minimum(near, far) <= CLEARANCE * pixel)
    unsure |= (width > 0) & (width < THIN * pixel)
    if deposit.curve.closed:
        unsure |= np.minimum(s, deposit.curve.length - s) <= deposit.profile(s) / 2
    category[unsure] = Truth.EDGE
    category[far <= TOUCH] = Truth.JUNCTION
    return category.astype(np.uint8)


def clearances(deposit: Deposit, s: Array) -> tuple[Array, Array]:
    """Distances (N,) [m] of cross segments at s (N,) from ink of the same and of other passes.

    Not positive where they meet; infinite where nothing is near. The same pass counts where
    it bends back onto the segment, as behind a corner.
    """
    half = deposit.width(s) / 2
    across = np.linspace(-1, 1, 21)
    points = (deposit.curve.points(s)[:, None]
              + deposit.curve.normals(s)[:, None] * (half[:, None] * across)[..., None])
    points = points.reshape(-1, 2)
    own = np.repeat(s, len(across))
    near, far = np.full((2, len(points)), np.inf)
    for strand in strands(deposit.curve):
        close = strand.near(points, deposit.max_width / 2 + 1e-3)
        if not len(close):
            continue
        foot, offset, _ = (values[:, 0] for values in strand.feet(points[close][:, None]))
        distance = np.maximum(np.abs(offset) - deposit.profile(foot) / 2,
                              deposit.beyond_run(foot))
        distance[(foot < strand.start - SEAM) | (foot > strand.end + SEAM)] = np.inf
        apart = np.abs(foot - own[close])
        if deposit.curve.closed:
            apart = np.minimum(apart, deposit.curve.length - apart)
        same = apart <= PASS * deposit.profile(own[close])
        distance[apart <= SAME] = np.inf
        near[close] = np.fmin(near[close], np.where(same, distance, np.inf))
        far[close] = np.fmin(far[close], np.where(same, np.inf, distance))
    shape = len(s), len(across)
    return near.reshape(shape).min(axis=1), far.reshape(shape).min(axis=1)


def drop_clearance(deposit: Deposit, s: Array, drops: Array) -> Array:
    """Distance (N,) [m] of cross segments at s (N,) from the nearest drop (D, 3)."""
    half = deposit.width(s)[:, None] / 2
    offset = drops[:, :2] - deposit.curve.points(s)[:, None]
    lateral = np.einsum('ijk,ik->ij', offset, deposit.curve.normals(s))
    beside = np.clip(lateral, -half, half)
    ahead = np.einsum('ijk,ik->ij', offset, deposit.curve.tangents(s))
    distance = np.hypot(ahead, lateral - beside)
    return np.asarray((distance - drops[:, 2]).min(axis=1, initial=np.inf))
