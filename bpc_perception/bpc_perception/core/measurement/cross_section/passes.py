"""Where passes of the path cross or touch each other."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs, windows_around
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

FAR_OUT_PX = 2.0  # an edge this much farther out than usual may be that of other ink
MOST_TURN = -0.17  # cosine of the angle, 100 degrees, from which a path turns back
QUERIES = 4096  # sections that are asked for at once, which bounds the memory


def meets_other_pass(sections: Sections, width: Array, inked: Flags) -> Flags:
    """Return where (N,) ink of another pass of the path lies on a section.

    Args:
        sections: N sections.
        width: (N,) of the bead that is to be expected [m].
        inked: (N,) whether there is ink at the path.
    """
    met = np.zeros(len(width), bool)
    index = np.flatnonzero(inked & np.isfinite(width))
    if len(index) == 0:
        return met
    low, high = ends_of_cells(sections.foot[index], sections.along[index], sections.pixel / 2)
    low, high = index[low], index[high]
    # Passes on top of each other, however many: those laid first and last in a cell are enough.
    half = width / 2
    apart = np.maximum(_arc_between(sections, (index, low)), _arc_between(sections, (index, high)))
    met[index] = apart > _longest_bend(sections.pixel, 2 * half[index])
    others = np.unique(np.concatenate((low, high)))
    alone = index[~met[index]]
    for start in range(0, len(alone), QUERIES):
        met[_met_among(sections, half, alone[start:start + QUERIES], others)] = True
    return met


def reaches_other_part(sections: Sections, left: Array, right: Array, width: Array) -> Flags:
    """Return where (N,) the bead seems to reach the ink of another part of its own pass.

    So it is next to the square turns of an infill, where the ink of three legs runs together. The
    edge lies much farther out than a bead is wide, and by far nearer to another part of the path.

    Args:
        sections: N sections.
        left: (N,) distance of the left edge from the path [m]; NaN = no edge.
        right: (N,) that of the right edge.
        width: (N,) of the bead that is to be expected [m].
    """
    half, margin = width / 2, FAR_OUT_PX * sections.pixel
    side, index = np.nonzero(np.stack((left, right)) > half + margin)
    reaches = np.zeros(len(width), bool)
    if len(index) == 0:  # as a rule
        return reaches
    out = np.where(side == 0, left[index], right[index])
    sign = np.where(side == 0, 1.0, -1.0)
    edge = sections.foot[index] + (sign * out)[:, None] * sections.lateral[index]
    apart, _ = cKDTree(sections.foot).query(edge)
    reaches[index[(apart < out - margin) & (apart < half[index] + margin)]] = True
    return reaches


def turns_back(sections: Sections, width: Array) -> Flags:
    """Return where (N,) the path turns back within half a width or so: there both legs lie.

    Args:
        sections: N sections.
        width: (N,) of the bead that is to be expected [m].
    """
    if not np.isfinite(width).any():
        return np.zeros(len(width), bool)
    reach = float(np.nanmedian(width)) / 2 + FAR_OUT_PX * sections.pixel
    first, end = windows_around(sections.piece, round(reach / sections.spacing))
    along = np.einsum('nk,nk->n', sections.lateral[first], sections.lateral[end - 1])
    return np.asarray(along < MOST_TURN)


def ends_of_cells(points: Array, along: Array, size: float) -> tuple[Index, Index]:
    """Return for each point (N, 3) the first and the last along the ink in the same cell.

    Args:
        points: [m].
        along: (N,) length along the ink [m].
        size: of a cell [m].
    """
    cell = np.floor(points / size).astype(np.int64)
    order = np.lexsort((along, *cell.T))
    new = np.append(True, (np.diff(cell[order], axis=0) != 0).any(axis=1))
    first, end = runs(np.cumsum(new))
    low, high = np.empty((2, len(points)), np.intp)
    low[order], high[order] = order[first], order[end - 1]
    return low, high


def _met_among(sections: Sections, half: Array, asked: Index, others: Index) -> Index:
    """Return which of the asked sections (K,) ink of other ones (L,) lies on.

    Args:
        sections: N sections.
        half: (N,) half the width of the bead that is to be expected [m].
        asked: index.
        others: index.
    """
    foot, margin = sections.foot, sections.pixel
    reach = float(half[asked].max() + half[others].max()) + margin
    pairs = cKDTree(foot[asked]).sparse_distance_matrix(
        cKDTree(foot[others]), reach, output_type='ndarray')
    one, other, distance = asked[pairs['i']], others[pairs['j']], pairs['v']
    # Most are neighbours on one pass.
    far = _arc_between(sections, (one, other)) > _longest_bend(distance, half[one] + half[other])
    one, other, distance = one[far], other[far], distance[far]
    across = np.abs(np.einsum('nk,nk->n', foot[other] - foot[one], sections.lateral[one]))
    along = np.sqrt(np.maximum(distance**2 - across**2, 0.0))
    reached = np.hypot(np.maximum(across - half[one] - margin, 0.0), along) < half[other]
    return np.unique(one[reached])


def _longest_bend(distance: Array | float, width: Array) -> Array:
    """Return how much path (K,) a bend of one pass has at most between two of its places [m].

    It is half a circle on the chord, a distance (K,) [m], plus half a width at each end (K,).
    """
    return np.asarray(np.pi / 2 * distance + width)


def _arc_between(sections: Sections, pairs: Index | tuple[Index, Index]) -> Array:
    """Return the length of ink (K,) between two sections each [m]."""
    one, other = pairs
    return np.asarray(np.abs(sections.along[one] - sections.along[other]))
