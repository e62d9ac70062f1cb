"""What is known of a value in several ways, each with its sigma."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.filters import running_mean
from bpc_perception.core.measurement.cross_section.on_ink.bead import POOLED_M
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

# Along so much path, the width of a bead changes at random by this share of it.
WALK_M, WALK_SHARE = 1e-3, 0.03
Known = tuple[Array, Array]  # values and their sigmas, (N,) each


def best_of(*known: Known) -> Known:
    """Return the values (N,) with the smallest sigma (N,); NaN where nothing is known."""
    values, sigmas = (np.stack(each) for each in zip(*known, strict=True))
    best = np.argmin(np.where(np.isfinite(values + sigmas), sigmas, np.inf), axis=0)[None]
    return (np.take_along_axis(values, best, axis=0)[0],
            np.take_along_axis(sigmas, best, axis=0)[0])


def mean_of(*known: Known) -> Known:
    """Return the means (N,) of what is known, weighed by its sigmas (N,); NaN where nothing is."""
    values, sigmas = (np.stack(each) for each in zip(*known, strict=True))
    weights = np.where(np.isfinite(values + sigmas), sigmas, np.inf)**-2.0
    total = weights.sum(axis=0)
    with np.errstate(invalid='ignore', divide='ignore'):
        return np.nansum(weights * values, axis=0) / total, total**-0.5


def carried_along(width: Array, sigma: Array, sections: Sections) -> Known:
    """Return widths (N,) to be expected from those seen before and behind on a bead [m].

    The width walks at random along the path: the farther away it is seen, the less is known.
    """
    width, around = mean_around(width, sections), np.isfinite(width)
    walk = (WALK_SHARE * np.nanmedian(width))**2 if around.any() else np.nan
    index, known = np.arange(len(width)), np.flatnonzero(around)
    if not len(known):
        return np.full(len(width), np.nan), np.full(len(width), np.nan)
    after = np.searchsorted(known, index)
    sides = []
    for other in (known[np.maximum(after - 1, 0)], known[np.minimum(after, len(known) - 1)]):
        far = np.abs(sections.along[other] - sections.along)
        same = sections.piece[other] == sections.piece
        sides.append((np.where(same, width[other], np.nan),
                      np.sqrt(sigma[other]**2 + walk * far / WALK_M)))
    return mean_of(*sides)


def mean_around(values: Array, sections: Sections) -> Array:
    """Return the mean (N,) of values (N,) over a stretch around each; NaN where it has none."""
    window = 2 * round(POOLED_M / sections.spacing) + 1
    mean = running_mean(values[:, None], window, sections.piece)[:, 0]
    return np.where(np.isfinite(values), mean, np.nan)
