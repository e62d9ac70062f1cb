"""Where passes of the path cross or touch each other."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.measurement.cross_section.sections.sections import Sections


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
    half, foot, margin = width / 2, sections.foot, sections.pixel
    pairs = index[cKDTree(foot[index]).query_pairs(
        2 * float(half[index].max()) + margin, output_type='ndarray')]
    # Most are neighbours on one pass.
    pairs = pairs[_arc_between(sections, pairs.T) > half[pairs].sum(axis=1)]
    for one, other in (pairs.T, pairs[:, ::-1].T):
        away = foot[other] - foot[one]
        across = np.abs(np.einsum('nk,nk->n', away, sections.lateral[one]))
        distance = np.linalg.norm(away, axis=1)
        along = np.sqrt(np.maximum(distance**2 - across**2, 0.0))
        reached = np.hypot(np.maximum(across - half[one] - margin, 0.0), along) < half[other]
        # A bend of one pass is at most half a circle on its chord, plus half a width at each end.
        arc = _arc_between(sections, (one, other))
        met[one[reached & (arc > np.pi / 2 * distance + half[one] + half[other])]] = True
    return met


def _arc_between(sections: Sections, pairs: Index | tuple[Index, Index]) -> Array:
    """Return the length of ink (K,) between two sections each [m]."""
    one, other = pairs
    return np.asarray(np.abs(sections.along[one] - sections.along[other]))
