"""What can be known of each sample of a path.

The cross segment of a sample is the piece of the line across the path on which its own pass has
laid ink: as long as the bead is wide; in a gap, the path point alone. A single width exists, and
its edges are seen, where no other ink meets or nearly meets that segment.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curve_pieces import curve_pieces
from bpc_sim.ink.deposit import Deposit, SEARCH_MARGIN_M

INK_BORDER_PX = 1.0  # this near to a start or an end of ink, any answer is right
INK_CLEARANCE_PX = 2.0  # other ink this near may not be resolved
THIN_INK_PX = 3.0  # narrower ink may not be seen
TOUCHING_M = 1e-6  # strands that are closer touch
OWN_INK_M = 1e-5  # along the path: nearer ink belongs to the segment itself
SAME_PASS_WIDTHS = 1.25  # along the path: nearer ink belongs to the same pass
POINTS_ACROSS = 21  # of a cross segment

Categories = NDArray[np.uint8]


class Truth(IntEnum):
    """The right answer for a sample.

    MEASURED: a single width exists and both of its edges are seen.
    GAP: the bed is seen, without ink.
    JUNCTION: ink of an earlier or later pass of the path meets the cross segment.
    HIDDEN: the path point or an edge is behind the nozzle or outside the image.
    EDGE: any answer is right: at a border between the others, up to the distances above; at
        corners, where the segment meets the other leg; where spilled ink joins the bead; at the
        seam of a closed path, which meets itself without a change of width.
    """

    MEASURED = 0
    GAP = 1
    JUNCTION = 2
    HIDDEN = 3
    EDGE = 4


@dataclass(frozen=True, eq=False)
class Clearances:
    """Distances (N,) [m] of cross segments from other ink.

    Not positive where they meet; infinite where nothing is near.

    Attributes:
        same_pass: distance from ink of the same pass where it bends back, as behind a corner.
        other_pass: distance from ink of an earlier or later pass.
    """

    same_pass: Array
    other_pass: Array


def classify_samples(deposit: Deposit, s: Array, pixel: float,
                     drops: Array | None = None) -> Categories:
    """Return the values (N,) of Truth of samples that are all in view.

    Args:
        deposit: the ink along the path.
        s: (N,) arc lengths [m].
        pixel: length of a pixel's side on the bed [m].
        drops: (D, 3) centre and radius of round drops of spilled ink [m].
    """
    width = deposit.width(s)
    clearances = find_clearances(deposit, s)
    near, far = clearances.same_pass, clearances.other_pass
    if drops is not None:
        near = np.minimum(near, drop_clearance(deposit, s, drops))
    category = np.where(width > 0, Truth.MEASURED, Truth.GAP)
    border = np.abs(s[:, None] - deposit.runs.ravel()).min(axis=1, initial=np.inf)
    unsure = border <= INK_BORDER_PX * pixel
    unsure |= np.minimum(near, far) <= INK_CLEARANCE_PX * pixel
    unsure |= (width > 0) & (width < THIN_INK_PX * pixel)
    if deposit.curve.closed:
        unsure |= np.minimum(s, deposit.curve.length - s) <= deposit.profile(s) / 2
    category[unsure] = Truth.EDGE
    category[far <= TOUCHING_M] = Truth.JUNCTION
    return category.astype(np.uint8)


def find_clearances(deposit: Deposit, s: Array) -> Clearances:
    """Find the distances of cross segments at arc lengths s (N,) [m] from other ink."""
    across = np.linspace(-1, 1, POINTS_ACROSS)
    half = deposit.width(s) / 2
    points = (deposit.curve.points(s)[:, None]
              + deposit.curve.normals(s)[:, None] * (half[:, None] * across)[..., None])
    points = points.reshape(-1, 2)
    own = np.repeat(s, len(across))
    near, far = np.full((2, len(points)), np.inf)
    for piece in curve_pieces(deposit.curve):
        close = piece.near(points, deposit.max_width / 2 + SEARCH_MARGIN_M)
        if not len(close):
            continue
        feet = piece.feet(points[close][:, None])
        foot, offset = feet.s[:, 0], feet.offset[:, 0]
        distance = np.maximum(np.abs(offset) - deposit.profile(foot) / 2,
                              deposit.beyond_run(foot))
        distance[~piece.spans(foot)] = np.inf
        apart = np.abs(foot - own[close])
        if deposit.curve.closed:
            apart = np.minimum(apart, deposit.curve.length - apart)
        same = apart <= SAME_PASS_WIDTHS * deposit.profile(own[close])
        distance[apart <= OWN_INK_M] = np.inf
        near[close] = np.fmin(near[close], np.where(same, distance, np.inf))
        far[close] = np.fmin(far[close], np.where(same, np.inf, distance))
    shape = len(s), len(across)
    return Clearances(near.reshape(shape).min(axis=1), far.reshape(shape).min(axis=1))


def drop_clearance(deposit: Deposit, s: Array, drops: Array) -> Array:
    """Return the distance (N,) [m] of cross segments at s (N,) from the nearest drop (D, 3)."""
    half = deposit.width(s)[:, None] / 2
    offset = drops[:, :2] - deposit.curve.points(s)[:, None]
    lateral = np.einsum('ijk,ik->ij', offset, deposit.curve.normals(s))
    beside = np.clip(lateral, -half, half)
    ahead = np.einsum('ijk,ik->ij', offset, deposit.curve.tangents(s))
    distance = np.hypot(ahead, lateral - beside)
    return np.asarray((distance - drops[:, 2]).min(axis=1, initial=np.inf))
