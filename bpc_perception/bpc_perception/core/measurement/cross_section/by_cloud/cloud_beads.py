"""Beads as the cloud shows them, whatever their colour is.

All of a print, folded into one section, tells what its beads look like; a model of that is fitted
to the points of a millimetre or two of path, which tell how wide the bead is there. Light that
goes into the ink puts its points below its surface, and at its feet below the bed: that shows.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import running_mean, windows_around
from bpc_perception.core.measurement.cross_section.by_cloud.folded_section import (
    fit_feet,
    REACH,
    section_height,
)
from bpc_perception.core.measurement.cross_section.by_cloud.rough_beads import (
    HALF_LEVEL,
    rough_beads,
)
from bpc_perception.core.measurement.cross_section.pooled_fit import (
    fit_without_outliers,
    PooledFit,
)
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.scale import steady_window
from bpc_perception.core.measurement.side_points import Columns

POOLED_M = 1e-3  # to either side along the path
FOLDS = 3  # of finding what beads look like
# Of moving each bead to where it fits, while it is learned what beads look like and at last; and
# of leaving out what lies far off. A neck that is half as wide as what is around takes five moves.
FIRST_MOVES, MOVES, ROUNDS = 2, 5, 2
FITTED = 1.6  # of half a width: so much of the bed counts, too
WIDER = 1.5  # than they seem at first, beads are at most
STEP = 0.04  # of half a width, over which slopes of the section are taken
# So far beads are from the model: place, half width, height per height, bed.
PLACE_SIGMA_M, HALF_SIGMA, TOP_SIGMA, BED_SIGMA_M = 2e-4, 0.12, 0.15, 3e-5
NOISE_M = 2e-4  # of a point, at first
# Neighbours in a cloud err alike, and beads are not quite of one shape.
SIGMA_GAIN = 1.7
MODEL_SIGMA = 0.016  # of a width, as a share of it: no bead has quite the shape that is fitted
PLACE, HALF, TOP = range(3)  # of what is fitted
LEAN_STEP = 0.2  # of the tangent of the view across the path, within which it is about the same
MOST_LEANS = 11  # beyond an angle of 63 degrees nothing is told apart


@dataclass(frozen=True)
class BeadModel:
    """What beads of a print look like in the cloud, for B directions of view across the path.

    Attributes:
        sections: (B, 4) H, a, b and how deep light goes, see ``folded_section``, in half widths;
            NaN = from there the cloud shows none.
        sigma: of a width, as a share of it: the same all along the print.
    """

    sections: Array
    sigma: float

    def height(self, u: Array, lean: Array) -> Array:
        """Return the height (N, K) of beads at places (N, K) of rays that lean (N,)."""
        height, directions = np.empty_like(u), direction(lean)
        for one in np.unique(directions).tolist():
            rows = directions == one
            height[rows] = section_height(u[rows].ravel(), float(lean[rows].mean()), np.append(
                (1.0, 1.0), self.sections[one])).reshape(-1, u.shape[1])
        return height

    @property
    def depth(self) -> float:
        """How deep light goes into the ink, in half widths."""
        return float(np.nanmedian(self.sections[:, -1]))

    @property
    def half_way_down(self) -> float:
        """Where a bead is half as high as it is seen, in half widths."""
        top, a, b, depth = self.sections[np.isfinite(self.sections[:, 0])][0]
        return float((1 - ((top + depth) / (2 * top))**(1 / b))**(1 / a))


def direction(lean: Array) -> Index:
    """Return the number (N,) of the direction from which a path is seen.

    ``lean`` (N,) is how far the top of a bead seems shifted across the path, per height.
    """
    return np.minimum(np.rint(np.abs(lean) / LEAN_STEP), MOST_LEANS - 1).astype(np.intp)


@dataclass(frozen=True)
class Lines:
    """Middles and half widths (N,) of beads, to the left of the path [m]; NaN = not known."""

    middle: Array
    half: Array

    def moved(self, shift: Array, wider: Array) -> Lines:
        """Return them moved by (N,) half widths to the left, and wider by factors (N,)."""
        return Lines(self.middle + shift * self.half, self.half * wider)

    def or_else(self, other: Lines) -> Lines:
        """Return others, but these where those are not known."""
        known = np.isfinite(other.middle + other.half)
        return Lines(np.where(known, other.middle, self.middle),
                     np.where(known, other.half, self.half))

    def steady(self, sections: Sections) -> Lines:
        """Return them as they are about: noise in them would widen what is folded by them."""
        both = sections.steady(np.stack((self.middle, self.half), axis=1))
        return Lines(*running_mean(both, steady_window(sections.spacing), sections.piece).T)


@dataclass(frozen=True)
class CloudBeads(Columns):
    """Beads at N path points; NaN where the cloud does not tell.

    Attributes:
        left, right: (N,) distances from the path to their feet [m].
        sigma: (N,) 1-sigma uncertainty of the width between them, without that of the model [m].
        top: (N,) how high they are, per height of the model.
    """

    left: Array
    right: Array
    sigma: Array
    top: Array

    @property
    def width(self) -> Array:
        """(N,) [m]."""
        return self.left + self.right

    @property
    def lines(self) -> Lines:
        """Their middles and half widths."""
        return Lines((self.left - self.right) / 2, self.width / 2)


@dataclass(frozen=True)
class _Points:
    """Points of the cloud across K path points.

    Attributes:
        place: (K, M) to the left of the path, along the rays: noise does not move a point [m].
        height: (K, M) above the feet of the sections [m]; NaN where a point is not of this bead.
        lean: (K,) how far the top of a bead seems shifted, per height.
        away: (K,) 1 where that is to the left, -1 to the right.
        window: rows that are fitted together.
        repeated: how often each point is among them.
    """

    place: Array
    height: Array
    lean: Array
    away: Array
    window: tuple[Index, Index]
    repeated: float

    def across(self, lines: Lines) -> Array:
        """Return the places (K, M) across beads, in half widths, positive away from the camera."""
        return np.asarray((self.place - lines.middle[:, None])
                          * (self.away / lines.half)[:, None])


def find_cloud_beads(sections: Sections, lean: Array, pictured: Lines | None = None,
                     model: BeadModel | None = None) -> tuple[CloudBeads, BeadModel | None]:
    """Find beads in the cloud, and what they look like.

    Args:
        sections: N sections.
        lean: (N,) see ``edges.feet.lean_to_left``.
        pictured: about where they are; None = the cloud alone tells.
        model: what beads of the print look like; None = these sections tell it.

    Returns:
        The beads, and the model; None = the cloud shows none.
    """
    rows = sections.a_pixel_apart
    some = sections.of(rows, 1)
    start = (rough_lines(some, model) if pictured is None
             else Lines(pictured.middle[rows], pictured.half[rows])).steady(some)
    if not (np.isfinite(start.middle) & (start.half > 0)).all():
        return _unknown(len(lean)), None
    points = _points_of(some, lean[rows], start)
    if model is None:
        model, start = _learned(some, points, start, pictured is not None)
    if model is None:
        return _unknown(len(lean)), None
    beads = _fitted(points, start, model, MOVES)
    return beads.at(np.interp(np.arange(len(lean)), rows, np.arange(len(rows)))), model


def rough_lines(sections: Sections, model: BeadModel | None) -> Lines:
    """Return about where beads are in the cloud, and how wide if they look like a model."""
    middle, width = rough_beads(_smoothed(sections))
    return Lines(middle, width / 2 * (HALF_LEVEL / model.half_way_down if model else 1.0))


def _unknown(count: int) -> CloudBeads:
    return CloudBeads(*np.full((4, count), np.nan))


def _points_of(sections: Sections, lean: Array, start: Lines) -> _Points:
    """Return the points across sections, as far as they tell of beads that are about so wide."""
    step = max(1, round(1 / SAMPLE_STEP_PX))
    farthest = float((np.abs(start.middle) + REACH * WIDER * start.half).max())
    near = np.flatnonzero(np.abs(sections.offset) <= farthest)[::step]
    height = np.where(_of_bead(sections), sections.height, np.nan)[:, near].astype(np.float64)
    place = sections.place[:, near] + height * lean[:, None]
    return _Points(place, height, np.abs(lean), np.where(lean >= 0, 1.0, -1.0),
                   windows_around(sections.piece, round(POOLED_M / sections.spacing)),
                   max(1.0, sections.pixel / sections.spacing))


def _of_bead(sections: Sections) -> Flags:
    """Return which points (N, M) may be of these beads, or of the bed beside them."""
    return np.asarray(sections.visible & ~sections.foreign & np.isfinite(sections.height))


def _smoothed(sections: Sections) -> Sections:
    """Return sections whose points are means along the path: one of a low bead tells nothing."""
    window = 2 * round(POOLED_M / sections.spacing) + 1
    counts = _of_bead(sections)
    height, place = (running_mean(np.where(counts, values, np.nan).astype(np.float64), window,
                                  sections.piece).astype(np.float32)
                     for values in (sections.height, sections.place))
    return replace(sections, height=height, place=place)


def _learned(sections: Sections, points: _Points, start: Lines,
             edges_seen: bool) -> tuple[BeadModel | None, Lines]:
    """Return what beads look like, and about where they are.

    Args:
        sections: K sections.
        points: across them.
        start: about where they are.
        edges_seen: whether the picture tells that; the cloud tells it worse, and better each time
            it is known what beads look like.
    """
    model: BeadModel | None = None
    for _ in range(1 if edges_seen else FOLDS):
        if model is not None:
            start = start.or_else(
                _fitted(points, start, model, FIRST_MOVES).lines).steady(sections)
        model, start = _folded(points, start, edges_seen)
        if model is None:
            break
    return model, start


def _folded(points: _Points, lines: Lines,
            edges_seen: bool) -> tuple[BeadModel | None, Lines]:
    """Return what beads look like, by all points folded into one section, and where they are."""
    u, height = points.across(lines), points.height / lines.half[:, None]
    counts, directions = (np.abs(u) < REACH) & np.isfinite(height), direction(points.lean)
    found, like, seen = np.full((MOST_LEANS, 7), np.nan), None, np.unique(directions)
    # From where most is seen the section is known best, and it is the same from everywhere.
    for one in seen[np.argsort(-np.bincount(directions)[seen], kind='stable')].tolist():
        same = directions == one
        rows = counts & same[:, None]
        feet = fit_feet(u[rows], height[rows], float(points.lean[same].mean()), like,
                        edges_seen=edges_seen)
        if feet.section is not None:
            like = feet.section if like is None else like
            wider, shift = 1 + feet.shift.mean(), (feet.shift[0] - feet.shift[1]) / 2
            found[one] = (wider, shift, np.hypot(*feet.sigma) / 2,
                          *feet.section / (wider, 1.0, 1.0, wider))
    if like is None:
        return None, lines
    # From where nothing was seen beads look as from the nearest direction.
    found = found[seen[np.abs(np.arange(MOST_LEANS)[:, None] - seen).argmin(axis=1)]]
    wider, shift, sigma = found[directions, :3].T
    return (BeadModel(found[:, 3:], float(np.hypot(np.nanmedian(sigma), MODEL_SIGMA))),
            lines.moved(np.nan_to_num(shift) * points.away, np.nan_to_num(wider, nan=1.0)))


def _fitted(points: _Points, start: Lines, model: BeadModel, moves: int) -> CloudBeads:
    """Move and widen beads until they fit the points around them.

    Args:
        points: across K path points.
        start: about where the beads are; none is far from it.
        model: what they look like.
        moves: how often.
    """
    change, sigma = np.zeros((len(start.half), 4)), np.full(len(start.half), np.nan)
    for _ in range(moves):
        found = _change(points, start, change, model)
        change, sigma = found.values, 2 * SIGMA_GAIN * np.sqrt(found.covariance[:, HALF, HALF])
    middle, half = start.middle + change[:, PLACE], start.half + change[:, HALF]
    return CloudBeads(half + middle, half - middle, sigma, 1 + change[:, TOP])


def _change(points: _Points, start: Lines, change: Array, model: BeadModel) -> PooledFit:
    """Fit how far beads are moved, widened, made higher, and on a higher bed (K, 4).

    ``change`` (K, 4) is the same as known so far.
    """
    by_place, by_half, by_top, _ = np.nan_to_num(change).T
    lines = Lines(start.middle + by_place, start.half + by_half)
    u, top = points.across(lines), 1 + by_top[:, None]
    known = np.nan_to_num(u)
    height, above, below = (model.height(place, points.lean)
                            for place in (known, known + STEP, known - STEP))
    slope, high = (above - below) / (2 * STEP) * top, height * lines.half[:, None]
    basis = -slope * points.away[:, None], -u * slope, high, np.ones_like(u)
    off = (points.height - high + by_place[:, None] * basis[0] + by_half[:, None] * basis[1])
    fitted = (np.abs(u) < FITTED) & np.isfinite(off)
    return fit_without_outliers(
        basis, off, fitted, points.window, NOISE_M,
        (PLACE_SIGMA_M, HALF_SIGMA * start.half, TOP_SIGMA, BED_SIGMA_M), points.repeated,
        ROUNDS)[0]
