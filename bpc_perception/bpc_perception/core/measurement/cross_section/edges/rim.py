"""Where an edge is steepest: its place when the ink's own level is nowhere seen beside it.

The rim of a bead is darker or brighter than what lies farther in: it is turned away from the lamp,
and the ridge shines. On a bead only a few pixels wide no level of the ink can be read beside
the edge, and a crossing half-way to what is read there is too far out or in, always to the same
side. A step blurred by lens and pixels is steepest at the step, whatever its height.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from bpc_perception.core.arrays import Array, Floats, Index
from bpc_perception.core.filters import running_mean

# All lengths along a section are in samples, see SAMPLE_STEP_PX.
REACH = 6  # from the edge outward and inward
FLANK = np.arange(-1, 3)  # around the steepest place; farther in is the bead's ridge
INWARD = 4.0  # from the edge to where it is seen how the ink's level changes
NARROW_HALF, WIDE_HALF = 5.5, 10.0  # half the width of a bead whose ridge is at its rim, and not
# Three slopes alone hardly tell place from variance. Straight lines between pixels move the place
# by a fifth of a pixel, where a stretch does not pass all places between two rows of pixels.
TRUST_IN_ROW = 0.2
LEAST_SLOPE = 0.02  # of the greatest; less is noise
BLUR_VARIANCE = (0.5, 30.0)  # from pixels alone to a lens out of focus [samples^2]
OBLIQUE_GAIN = 1.25  # the variance differs by so much along a path seen from aside
MOST_BEND = 0.3  # that a change of the ink's level accounts for
REFLECTED = -1.2  # steepest so far inward, the rim itself shines and is not seen
FARTHEST = 2.0  # that the steepest place may lie outward
SHARP = 2.2  # 1-sigma blur up to which these hold
PLACES_ASKED = 8  # in a stretch of path
USUAL_SHIFT = 0.2  # larger ones have to be better founded


def steepest_shift(share: Floats, edge: Array, noise: Array, in_row: Array, rows: int,
                   spacing: float, piece: Index) -> Array:
    """Return how far outward of edges (N,) the share of ink is steepest (N,) [samples].

    A stretch of path is taken together, since a slope is read less surely than a level.

    Args:
        share: (N, K) samples outward from N path points, 1 = ink, 0 = bed, NaN = not seen.
        edge: (N,) where it falls to half [samples]; NaN = none.
        noise: (N,) 1-sigma of a share.
        in_row: (N,) how well the path keeps to its place between rows of pixels, see Sections.
        rows: length of a stretch [path points].
        spacing: of path points [pixels].
        piece: (N,) number of the piece of path; a stretch lies within one.

    Returns:
        NaN where there is no edge, or a reflection runs along it.
    """
    step = max(1, rows // PLACES_ASKED)
    pooled = _pooled(share, edge, rows, piece)[::step]
    fall = _slopes(pooled)
    peak = _steepest(fall)
    greatest = fall[np.arange(len(fall)), peak]
    known = np.isfinite(pooled).all(axis=1) & (greatest > 0)
    if not known.any():
        return np.full(len(edge), np.nan)
    result = np.full(len(pooled), np.nan)
    pooled, greatest, peak = pooled[known], greatest[known], peak[known]
    flank = fall[known][np.arange(len(peak))[:, None], peak[:, None] + FLANK] / greatest[:, None]
    top, variance = _gaussian(np.maximum(flank, LEAST_SLOPE),
                              inner_trust(float(np.nanmedian(edge)), in_row[::step][known]))
    place = peak + 2 + top
    shift = place - REACH - _bend(pooled, place, greatest, variance)
    # By so much noise moves the top of a parabola through neighbouring slopes.
    pixels = max(rows * spacing, 1.0)
    error = 0.4 * np.median(noise) / np.sqrt(pixels) * variance / greatest
    wide = np.maximum(np.sqrt(variance) / SHARP, 1.0)  # out of focus all lies farther apart
    plain = (shift >= REFLECTED * wide) & (shift <= FARTHEST * wide)
    result[known] = np.where(plain, shift * USUAL_SHIFT**2 / (USUAL_SHIFT**2 + error**2), np.nan)
    near = (np.arange(len(edge)) + step // 2) // step
    return result[np.minimum(near, len(result) - 1)]


def inner_trust(edge: float, in_row: Array) -> Array:
    """Return the weight (N,) of the slope inward of the steepest one.

    In a narrow bead that slope shows the ridge as well. Where the path keeps to a row of pixels
    (N,) it is needed all the same.

    Args:
        edge: how far out the edges are [samples].
        in_row: (N,) see Sections.
    """
    wide = np.clip((edge - NARROW_HALF) / (WIDE_HALF - NARROW_HALF), 0, 1)
    return np.maximum(wide, TRUST_IN_ROW * in_row)


def _pooled(share: Floats, edge: Array, rows: int, piece: Index) -> Array:
    """Return the mean share (N, 2 REACH + 1) around edges (N,), over a stretch of path."""
    values = between_samples(share, edge[:, None] + np.arange(-REACH, REACH + 1))
    values[np.isnan(edge)] = np.nan
    return running_mean(values, rows, piece)


def _slopes(pooled: Array) -> Array:
    """Return how steeply (N, 2 REACH - 3) shares (N, 2 REACH + 1) fall outward.

    Between pixels the image is read off straight lines. These blur it at half a pixel and not at
    whole ones: where a path keeps to the rows of pixels, every other slope would be less.
    """
    fall = (pooled[:, :-2] - pooled[:, 2:]) / 2
    return np.asarray((fall[:, :-2] + 2 * fall[:, 1:-1] + fall[:, 2:]) / 4)


def _steepest(fall: Array) -> Index:
    """Return where (N,) slopes (N, K) are greatest, with room for ``FLANK`` around."""
    ends = slice(1, fall.shape[1] - FLANK[-1])
    return np.argmax(np.nan_to_num(fall[:, ends], nan=-np.inf), axis=1) + ends.start


def _bend(pooled: Array, place: Array, greatest: Array, variance: Array) -> Array:
    """Return how far outward (N,) of the edge the share is steepest as the ink's level changes.

    The level gains c a sample up to H at the rim. The blurred edge falls by H g - c G, with g a
    Gaussian of variance s^2 about the edge and G its integral from outside. It is steepest where
    H g' = -c g, outward of the edge by c s^2 / H.

    Args:
        pooled: (N, 2 REACH + 1) shares around the edges.
        place: (N,) where they are steepest [samples].
        greatest: (N,) slope there.
        variance: (N,) of the blur [samples^2].
    """
    height = greatest * np.sqrt(2 * np.pi * variance)
    expected = height * (ndtr(INWARD / np.sqrt(variance)) - 0.5)
    gained = expected - (between_samples(pooled, place - INWARD) - between_samples(pooled, place))
    return np.clip(gained / INWARD * variance / height, -MOST_BEND, MOST_BEND)


def _gaussian(values: Array, inner: Array) -> tuple[Array, Array]:
    """Return places and variances (N,) of Gaussians through values (N, len(FLANK)) > 0.

    They are parabolas through the logarithms, weighted by the squares of the values (Guo, IEEE
    Signal Processing Magazine 28(5), 2011). One lens makes all edges about equally wide.

    Args:
        values: (N, len(FLANK)) at ``FLANK``.
        inner: (N,) weight of what lies inward, see ``inner_trust``.
    """
    powers = FLANK[:, None].astype(float) ** np.arange(3)
    weight, level = values**2, np.log(values)
    weight[:, FLANK < 0] *= inner[:, None]
    moments = np.einsum('nk,ki,kj->nij', weight, powers, powers)
    square = np.linalg.solve(moments, np.einsum('nk,ki->ni', weight * level, powers)[..., None])
    with np.errstate(divide='ignore'):
        free = np.clip(np.where(square[:, 2, 0] < 0, -0.5 / square[:, 2, 0], np.inf),
                       *BLUR_VARIANCE)
    usual = float(np.median(free))
    variance = np.clip(free, usual / OBLIQUE_GAIN, usual * OBLIQUE_GAIN)
    # With its variance known, what is left of the parabola is a straight line.
    right = np.einsum('nk,ki->ni', weight * (level + FLANK**2 / (2 * variance[:, None])),
                      powers[:, :2])
    slope = np.linalg.solve(moments[:, :2, :2], right[..., None])[:, 1, 0]
    return np.clip(slope * variance, -1.0, 1.0), variance


def between_samples(values: NDArray[np.floating[Any]], place: Array) -> Array:
    """Return values (N, K) at places (N,) or (N, J) between samples; beyond the ends, the ends."""
    inner = np.minimum(np.fmax(place, 0.0), values.shape[1] - 1.001)  # NaN is the first
    base = inner.astype(np.intp)
    part = inner - base
    row = np.arange(len(values)).reshape(-1, *(1,) * (place.ndim - 1))
    return np.asarray((1 - part) * values[row, base] + part * values[row, base + 1])
