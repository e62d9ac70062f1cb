"""The feet of a bead in the cloud, from the points of a whole print folded into one section.

A section is h = H (1 - |u|^a)^b between its feet, u = -1 .. 1: an ellipse with a = 2 and b = 1/2,
a parabola with b = 1, and about what surface tension makes of ink in between. Around it lies the
bed, which may bend. All lengths are in half widths of the bead in the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.filters import runs

REACH, BARE = 1.7, 1.25  # how far points count, and from where on all is bed,
FAR_BARE = 1.5  # where u = -1 .. 1 is told by the cloud
CENTRAL, RIM = 0.3, (0.85, 1.0)  # of a bead's ridge, and of its rim
BIN = 0.04  # points so close together are taken as one
AT_FEET = 0.8, 1.2  # where gaps between points make a foot unsure
LEAST_POINTS, LEAST_IN_BIN = 250, 5
ROUNDS, SETTLED = 12, 0.02  # at most, or until a round changes less than this share of a stride
NODES = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 41))  # u, close together at the feet
# What is fitted: the feet on the far and on the near side, H, a, b, how deep light goes, level and
# bend of the bed. So it is among beads, within so much; and so far a round may go.
USUAL = np.array((1.0, 1.0, 0.0, 2.1, 0.8, 0.0, 0.0, 0.0))
USUAL_SIGMA = np.array((0.15, 0.15, 9.0, 0.5, 0.3, 0.01, 0.02, 0.02))
# Of H, a, b and how deep light goes, by which beads of one print differ.
LIKE_SIGMA = np.array((0.03, 0.15, 0.06, 0.02))
LEAST = np.array((0.6, 0.6, 0.03, 1.3, 0.15, -0.02, -0.1, -0.1))
MOST = np.array((1.5, 1.5, 3.0, 5.0, 1.0, 1.0, 0.1, 0.1))  # none is more pointed than a parabola,
MOST_SUNKEN = MOST + 0.2 * (np.arange(8) == 4)  # though a fit may pass by it
STRIDE = np.array((0.1, 0.1, 0.2, 0.5, 0.1, 0.1, 0.05, 0.05))
DIFFERENCE = np.array((0.03, 0.03, 0.01, 0.05, 0.02, 0.01))  # the last two need none
TOP, DEPTH, BED = 2, 5, 6  # places of H, of how deep light goes, and of the first of the bed
SHAPE_SIGMA = 0.02  # by which heights differ from the section
MEDIAN_GAIN = 1.25  # of noise in a median, against that in a mean
ALIKE = 5.0  # neighbouring points of a cloud err alike: so many tell no more than one
LEAST_HEIGHT = 3.0  # in sigmas of a point: of what is flatter no foot is seen
# Light may go into ink whose rim is lower than this share of its height. How deep is not known
# beforehand: fits begin from all of these feet and depths, and have to be so much better.
LOW_RIM, DEPTH_SIGMA, BETTER = 0.12, 0.1, 0.8
FEET, FAR_FEET, DEPTHS = (1.0, 1.08), (1.0, 1.12, 1.25), (0.1, 0.2, 0.3)
LEAST_SOLID = 0.9  # no shade makes a bead look so much wider
MOST_MISFIT = 2.0  # usual square of what a bin is off, in sigmas; more is no bead on an even bed
MOST_ASKEW = 0.15  # by which a bead lies to one side of its picture
LEAN_SIGMA = 0.04  # of feet that are seen from the side
OUTER = 0.9  # from here to the foot a flank tells where the foot is


@dataclass(frozen=True)
class FoldedFeet:
    """Feet of beads, found from one side; lengths in half widths of the picture.

    Attributes:
        shift: (2,) how far they lie outward of u = 1, on the far and the near side.
        sigma: (2,) their 1-sigma uncertainties.
        section: (4,) H, a, b and how deep light goes; None = nothing is known.
    """

    shift: Array
    sigma: Array
    section: Array | None


class _Points(NamedTuple):
    """Places, heights and sigmas (B,) of points in bins, and their lean, see ``fit_feet``."""

    place: Array
    height: Array
    sigma: Array
    lean: float


class _Fit(NamedTuple):
    """What is fitted, with its covariance, and how badly: sum and median of squares."""

    values: Array
    covariance: Array
    misfit: float
    usual_misfit: float


def fit_feet(u: Array, height: Array, lean: float, like: Array | None = None, *,
             edges_seen: bool = True) -> FoldedFeet:
    """Find the feet of beads.

    Args:
        u: (K,) places of points across beads, along the rays of the camera; positive away from it.
        height: (K,) of the points above the bed.
        lean: how far a height seems shifted away from the camera, per height.
        like: (4,) the section as it was found from another side; None = not known.
        edges_seen: whether u = -1 .. 1 are edges in a picture, beside which a low rim shows that
            light goes into the ink; False = the cloud alone tells where beads are.

    Returns:
        NaN where the cloud tells nothing: there are few points, the bead is flat, or the bed
        around it is not even. Where nobody knows whether light goes into the ink, sigma is larger.
    """
    nothing = FoldedFeet(np.full(2, np.nan), np.full(2, np.nan), None)
    bare = np.abs(u) > (BARE if edges_seen else FAR_BARE)
    central = np.abs(u) < CENTRAL
    rim = (np.abs(u) > RIM[0]) & (np.abs(u) < RIM[1])
    if min(len(u) / 10, bare.sum(), central.sum(), rim.sum()) < LEAST_POINTS / 10:
        return nothing
    bed, top = float(np.median(height[bare])), float(np.median(height[central]))
    noise = float(np.hypot(1.4826 * np.median(np.abs(height[bare] - bed)), SHAPE_SIGMA))
    if top < LEAST_HEIGHT * noise:
        return nothing
    points = _Points(*_in_bins(u, height, noise), lean)
    low_rim = bool(np.median(height[rim]) < LOW_RIM * top)
    may_be_sunken = like is None and (low_rim or not edges_seen)
    best, doubt = _best_fit(points, *_usual(top, like),
                            (FEET if edges_seen else FAR_FEET) if may_be_sunken else (),
                            edges_seen)
    askew = edges_seen and abs(best.values[0] - best.values[1]) > MOST_ASKEW
    if best.usual_misfit > MOST_MISFIT or askew:
        return nothing
    flank = section_height(np.array((OUTER,)), 0.0, _symmetric(best.values))
    sigma = np.sqrt(np.diagonal(best.covariance)[:2] + (SHAPE_SIGMA * (1 - OUTER) / flank)**2
                    + doubt**2 + _gap_at_feet(points.place)**2 + (LEAN_SIGMA * lean**2)**2)
    return FoldedFeet(best.values[:2] - 1, sigma, best.values[TOP:BED])


def section_height(u: Array, lean: float, fitted: Array) -> Array:
    """Return the height (K,) of a bead seen at places (K,); see ``fit_feet``.

    ``fitted`` are far foot, near foot, H, a, b, and how deep light goes.
    """
    far, near, top, a, b, depth = fitted
    z = top * np.maximum(1 - np.abs(NODES)**a, 0.0)**b - depth
    seen_at = (far - near) / 2 + (far + near) / 2 * NODES + z * lean
    # What lies behind a ridge is hidden by it.
    return np.asarray(np.interp(u, np.maximum.accumulate(seen_at), z, left=0.0, right=0.0))


def _in_bins(u: Array, height: Array, noise: float) -> tuple[Array, Array, Array]:
    """Return mean place, median height, and its 1-sigma uncertainty (B,), of points in bins."""
    place = np.floor(u / BIN).astype(np.intp)
    order = np.lexsort((height, place))
    first, end = runs(place[order])
    begins = np.unique(first)
    count = end[begins] - begins
    begins, count = begins[count >= LEAST_IN_BIN], count[count >= LEAST_IN_BIN]
    total = np.append(0.0, np.cumsum(u[order]))
    middle = (height[order[begins + (count - 1) // 2]] + height[order[begins + count // 2]]) / 2
    return ((total[begins + count] - total[begins]) / count, middle,
            np.hypot(MEDIAN_GAIN * noise * np.sqrt(ALIKE / count), SHAPE_SIGMA))


def _gap_at_feet(place: Array) -> float:
    """Return how far a foot may be off where no point lies near it, given places (B,).

    So it is where a path keeps to a row of pixels.
    """
    near = np.sort(np.abs(place))
    gaps = np.diff(near[(near > AT_FEET[0]) & (near < AT_FEET[1])])
    return max(float(gaps.max(initial=0.0)) - BIN, 0.0) / 2


def _best_fit(points: _Points, usual: Array, usual_sigma: Array,
              sunken_feet: tuple[float, ...], edges_seen: bool) -> tuple[_Fit, Array]:
    """Fit a section to ink that light does not go into, or does.

    Fits of the latter begin with feet at each of ``sunken_feet``; without any, light does not go
    into it. Comes with how far the feet (2,) may be off where nobody knows which.
    """
    solid, sure = _fit(points, usual, usual_sigma, usual, MOST), np.zeros(TOP)
    if not sunken_feet:
        return solid, sure
    sunken = min((_fit(points, *_sunken(usual, usual_sigma, foot, depth))
                  for foot, depth in product(sunken_feet, DEPTHS)), key=lambda fit: fit.misfit)
    if sunken.misfit <= BETTER * solid.misfit:
        return sunken, sure
    # Of a low rim no shade makes a bead look so much wider.
    unlikely = edges_seen and solid.values[:TOP].min() < LEAST_SOLID
    if unlikely or (not edges_seen and sunken.misfit < solid.misfit):
        return solid, np.abs(sunken.values[:TOP] - solid.values[:TOP])
    return solid, sure


def _usual(top: float, like: Array | None) -> tuple[Array, Array]:
    """Return what is known beforehand, given how high a bead seems to be, and its sigmas."""
    usual, sigma = USUAL.copy(), USUAL_SIGMA.copy()
    usual[TOP] = top
    if like is not None:
        usual[TOP:BED], sigma[TOP:BED] = like, LIKE_SIGMA
    return usual, sigma


def _sunken(usual: Array, sigma: Array, foot: float,
            depth: float) -> tuple[Array, Array, Array, Array]:
    """Return the same of ink into which light goes so deep, where to begin, and how far to go."""
    usual, sigma = usual.copy(), sigma.copy()
    usual[TOP], usual[DEPTH], sigma[DEPTH] = usual[TOP] + depth, depth, DEPTH_SIGMA
    start = usual.copy()
    start[:TOP] = foot
    return usual, sigma, start, MOST_SUNKEN


def _symmetric(fitted: Array) -> Array:
    """Return a section with its feet at -1 and 1, and its cloud at its surface."""
    return np.concatenate(((1.0, 1.0), fitted[TOP:DEPTH], (0.0,)))


def _fit(points: _Points, usual: Array, usual_sigma: Array, start: Array, most: Array) -> _Fit:
    """Fit a section to points, by the method of Gauss and Newton."""
    u, height, sigma, lean = points
    bed = np.stack((np.ones_like(u), u**2))
    fitted = start
    for _ in range(ROUNDS):
        bead = section_height(u, lean, fitted[:BED])
        off = (height - bead - fitted[BED:] @ bed) / sigma
        change = np.concatenate((
            [(section_height(u, lean, fitted[:BED] + one) - bead) / one.sum()
             for one in np.diag(DIFFERENCE)], bed)) / sigma
        normal = change @ change.T + np.diag(1 / usual_sigma**2)
        towards = change @ off + (usual - fitted) / usual_sigma**2
        step = np.clip(np.linalg.solve(normal, towards), -STRIDE, STRIDE)
        fitted = np.clip(fitted + step, LEAST, most)
        if (np.abs(step) < SETTLED * STRIDE).all():
            break
    return _Fit(fitted, np.linalg.inv(normal), float(off @ off), float(np.median(off**2)))
