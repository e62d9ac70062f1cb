"""The ink of some strokes as one shape in the plane, and the holes in it."""

from __future__ import annotations

import numpy as np
import shapely

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.printability.flat_print import FlatPrint

SAME_M = 1e-8  # nearer than this, lines are the same
STRAIGHT_M = 2e-5  # off a line of the path: poses are no better


def bead_union(flat: FlatPrint, chosen: Flags, errors: Array | float = 0.0) -> shapely.Geometry:
    """Return the shape of the beads of chosen samples (N,) [m].

    Between two neighbours of a stroke it is what their four side points span.

    Args:
        flat: the print.
        chosen: (N,) samples.
        errors: (2, N) how much farther out the sides lie than measured [m].
    """
    left, right = flat.sides(errors)
    start = np.flatnonzero(chosen[:-1] & chosen[1:] & (flat.stroke[:-1] == flat.stroke[1:]))
    corners = np.stack((left[start], right[start], right[start + 1], left[start + 1]), axis=1)
    # At a sharp turn the sides cross each other.
    return shapely.union_all(shapely.convex_hull(shapely.linestrings(corners)))


def path_union(flat: FlatPrint, chosen: Flags, width: Array) -> shapely.Geometry:
    """Return the shape of strands on the lines of the path of chosen samples (N,) [m].

    Args:
        flat: the print.
        chosen: (N,) samples.
        width: (N,) wanted [m].
    """
    strands = []
    for number in np.unique(flat.stroke[chosen]):
        own = chosen & (flat.stroke == number)
        if np.count_nonzero(own) > 1:
            line = shapely.LineString(flat.points[own]).simplify(STRAIGHT_M)
            strands.append(line.buffer(float(np.mean(width[own])) / 2, cap_style='flat',
                                       join_style='mitre'))
    return shapely.union_all(strands)



def holes(shape: shapely.Geometry, narrowest: float) -> list[shapely.Polygon]:
    """Return the holes of a shape that are wider than ``narrowest`` [m] somewhere.

    A piece of the shape that lies in a hole for itself is not of the hole.
    """
    parts = shapely.get_parts(shape)
    found = []
    for part in parts:
        for ring in part.interiors:
            hole = shapely.Polygon(ring)
            islands = shapely.union_all(parts[shapely.contains(hole, parts)])
            if not hole.buffer(-narrowest / 2).is_empty:
                found.append(hole.difference(islands))
    return found


def share_off(ring: shapely.Geometry, shape: shapely.Geometry) -> float:
    """Return which share of a closed line is no part of the outline of a shape."""
    return float(ring.difference(shape.boundary.buffer(SAME_M)).length / ring.length)
