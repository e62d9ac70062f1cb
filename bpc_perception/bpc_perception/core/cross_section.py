"""Thickness from the image across the path: the default method.

The image is read along a line across each path point. Where it passes half-way from ink to what
lies beside it, there is the edge, to a fraction of a pixel. Which edge is meant the path says: the
first on either side, going outwards from it. What ink and bed look like is taken from the
image itself, near each point: ink lies along the path, bed far from all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid
from scipy.spatial import cKDTree
from scipy.stats import chi2

from bpc_perception.core.capture import Capture
from bpc_perception.core.config import CrossSectionConfig
from bpc_perception.core.geometry import Array, Plane
from bpc_perception.core.profile import Status
from bpc_perception.core.sections import (
    Flags,
    lay_sections,
    masked_median,
    running_median,
    Sections,
    STEP,
)
from bpc_perception.core.surface import StatusArray
from bpc_perception.core.thickness import SidePoints

Index = NDArray[np.intp]

SETTLED = 2.0  # what is shorter is noise [pixels]
GLARE = 7.0  # a shorter stretch of bed with ink behind it may be glare [pixels]
PLATEAU = (1.5, 3.5)  # from the edge to where its two levels are read [pixels]
RIM = 0.1  # a centre this near to half ink is the end of a run, and not judged
BRIGHT = 5.0  # brighter than the bed by so many sigma is glare
SMOOTHING_GAIN = 0.61  # root of (1 + 4 + 1) / 16, for noise that is independent
PASSES = 3  # of reading levels and moving the edge
HALO = 2.5  # around glare the lens spreads its light so far [pixels]
BED_CORE = 0.5  # beside the path some of what lies there may be other ink
INK_CORE = 0.95  # shading and reflections are part of what ink looks like
SPIKE = 1.0  # an edge so far from those around it is a flaw of the image [pixels]
ISLAND = 0.003  # so is a stretch between two jumps that is shorter [m]


@dataclass(frozen=True)
class Light:
    """What ink and bed look like at N sections.

    Attributes:
        bed: (2, N, 3) colours of the bed to the right and to the left.
        weight: (N, 3) how to weigh colour channels, so that a step from bed to ink is 1.
        noise: (N,) 1-sigma noise of a colour so weighed; large = ink is not told from bed.
        glare_from: (2, N) brightness, the mean of red, green and blue, above which a sample is
            neither ink nor bed.
    """

    bed: Array
    weight: Array
    noise: Array
    glare_from: Array


@dataclass(frozen=True)
class Edges:
    """First edges outward from N path points on one side.

    Attributes:
        distance: (N,) from the path [m]; NaN = none found.
        sigma: (N,) its 1-sigma uncertainty from noise [m].
        hidden, outside, joined: (N,) whether an obstacle, the image's border or ink up to
            another pass of the path comes first.
    """

    distance: Array
    sigma: Array
    hidden: Flags
    outside: Flags
    joined: Flags


def measure_cross_sections(
    capture: Capture, points: Array, extruding: Flags, T_base_camera: Array, bed: Plane,
    config: CrossSectionConfig,
) -> tuple[SidePoints, StatusArray, Array]:
    """Side points, status (N,) and sigma (N,) of path points (N, 3)."""
    sections = lay_sections(capture, points, T_base_camera, bed, config)
    light = find_light(sections, extruding)
    ink = ink_share(sections, light)
    right, left = (find_edges(sections, light.noise, ink, side) for side in (0, 1))
    width = left.distance + right.distance

    # Of the middle third, so that a spot of glare on the path does no harm.
    typical = running_median(width, 2 * round(0.005 / sections.spacing) + 1)
    reach = np.fmax(typical / 6, sections.pixel)[:, None]
    centre = masked_median(ink, (np.abs(sections.offset) <= reach) & np.isfinite(ink))
    status = np.full(len(points), Status.LOW_CONFIDENCE, np.uint8)
    status[(centre >= 0.5 + RIM) & np.isfinite(width)] = Status.MEASURED
    around = (np.abs(sections.offset) <= 2.4 * reach) & (ink > 0.5 + RIM)
    bare = around.sum(axis=1) * STEP * sections.pixel < reach[:, 0] / 2
    status[(np.abs(centre) <= 0.5 - RIM) & bare & ~sections.raised] = Status.GAP
    inked = centre >= 0.5 + RIM
    status[inked & (left.outside | right.outside)] = Status.NO_DATA
    status[inked & (left.hidden | right.hidden)] = Status.OCCLUDED
    status[light.noise > config.maximum_noise] = Status.LOW_CONFIDENCE
    status[(status == Status.MEASURED) & leans_over_gap(sections, status)] = Status.LOW_CONFIDENCE
    crossing = meets_itself(sections, typical, inked) | left.joined | right.joined
    status[crossing & inked] = Status.JUNCTION
    middle = len(sections.offset) // 2
    status[~sections.inside[:, middle] | ~sections.depth] = Status.NO_DATA
    status[sections.hidden[:, middle]] = Status.OCCLUDED

    sigma = width_sigma(left, right, width, sections.pixel, config)
    sides = SidePoints(sections.foot + left.distance[:, None] * sections.lateral,
                       sections.foot - right.distance[:, None] * sections.lateral,
                       left.distance, right.distance)
    return sides, status, sigma


def width_sigma(left: Edges, right: Edges, width: Array, pixel: float,
                config: CrossSectionConfig) -> Array:
    """1-sigma uncertainty (N,) of a width (N,) [m].

    The noise of both edges; what sampling leaves; and the light on the bead, which shades its
    edges and shines on its ridge: the fewer pixels the bead has, the less of that is seen apart.
    """
    noise = config.noise_gain * np.hypot(left.sigma, right.sigma)
    narrow = config.light_sigma * (10 * pixel / width) ** 2
    return np.sqrt(noise**2 + (config.edge_sigma * pixel) ** 2 + (narrow * pixel) ** 2)


def find_light(sections: Sections, extruding: Flags) -> Light:
    """What ink and bed look like along the path."""
    middle = np.abs(sections.offset) <= sections.pixel
    centre = sections.colour[:, middle].mean(axis=1).astype(np.float64)
    centre[~sections.visible[:, middle].all(axis=1)] = np.nan
    coarse = slice(None, None, round(1 / STEP))  # a sample a pixel
    colour = sections.colour[:, coarse].astype(np.float64)
    visible = sections.visible[:, coarse]
    beside = sections.beside[:, coarse] & visible
    is_left = sections.offset[coarse] > 0
    bed = find_bed(sections, np.stack((masked_median(colour, beside & ~is_left),
                                       masked_median(colour, beside & is_left))), centre)
    around_bed = colour - np.where(is_left[:, None], bed[1][:, None], bed[0][:, None])
    bed_spread = _covariance(around_bed[beside], BED_CORE)

    step = centre - bed.mean(axis=0)
    contrast = np.sqrt(np.einsum('ni,ij,nj->n', step, np.linalg.inv(bed_spread), step))
    laid = np.isfinite(contrast) & (extruding if extruding.any() else True)
    if not laid.any():
        unknown = np.full(len(step), np.inf)
        return Light(bed, np.zeros_like(step), unknown, np.stack((unknown, unknown)))
    typical = np.median(step[laid & (contrast >= np.median(contrast[laid]))], axis=0)

    # Fisher's direction, twice: what varies within the ink, its shading, is seen only once it
    # is known where ink is.
    spread = bed_spread
    for _ in range(2):
        towards = np.linalg.solve(spread, typical)
        share = step @ towards / (typical @ towards)
        local = sections.steady(np.where((share > 0.5)[:, None], step, np.nan))
        weight = np.linalg.solve(spread, local.T).T
        weight /= np.einsum('ni,ni->n', local, weight)[:, None]
        inked = np.einsum('nmk,nk->nm', around_bed, weight) > 0.6
        inner = inked & np.roll(inked, 1, axis=1) & np.roll(inked, -1, axis=1) & visible
        inner &= (share > 0.5)[:, None]
        # All of the ink, not its middle alone, where light from above is reflected.
        ink = masked_median(colour, inner)
        step = np.where(inner.any(axis=1)[:, None], ink - bed.mean(axis=0), step)
        spread = bed_spread + _covariance((colour - ink[:, None])[inner], INK_CORE)
    noise = np.sqrt(np.einsum('ni,ij,nj->n', weight, bed_spread, weight))
    # On ink brighter than its bed, what is brighter still is no less ink.
    brightness = np.where(local.mean(axis=1) < 0, bed.mean(axis=2), np.inf)
    return Light(bed, weight, noise, brightness + BRIGHT * np.sqrt(bed_spread.sum()) / 3)


def find_bed(sections: Sections, beside: Array, centre: Array) -> Array:
    """Colours (2, N, 3) of the bed on both sides, from what lies beside and on the path.

    Where strands lie closely, what lies half-way between them may be ink as well. It is taken for
    bed only if it is nearer to the bed farther out than to the ink.
    """
    sure = sections.clearance >= sections.clearance.max() / 2
    open_bed = np.stack([sections.steady(np.where(known[:, None], colours, np.nan))
                         for known, colours in zip(sure, beside, strict=True)])
    open_bed = np.where(np.isfinite(open_bed), open_bed, open_bed[::-1])
    step = centre - open_bed.mean(axis=0)
    size = np.linalg.norm(step, axis=1)
    if np.isfinite(size).any():
        strong = np.median(step[size >= np.nanmedian(size)], axis=0)
        share = (beside - open_bed) @ strong / (strong @ strong)
        sure |= share < 0.4
    bed = np.stack([sections.steady(np.where(known[:, None], colours, np.nan))
                    for known, colours in zip(sure, beside, strict=True)])
    return np.where(np.isfinite(bed), bed, bed[::-1])


def ink_share(sections: Sections, light: Light) -> Array:
    """How much of each sample (N, M) is ink: 0 = bed, 1 = ink; NaN where it is not seen.

    In and around glare the colour of what shines is not seen either.
    """
    middle = len(sections.offset) // 2
    share = np.empty(sections.colour.shape[:2])
    glare = np.zeros(share.shape, np.uint8)
    brightness = sections.colour.mean(axis=2)
    for side, part in ((0, slice(None, middle)), (1, slice(middle, None))):
        share[:, part] = np.einsum(
            'nmk,nk->nm', sections.colour[:, part] - light.bed[side][:, None], light.weight)
        glare[:, part] = brightness[:, part] > light.glare_from[side][:, None]
    across = 2 * round(HALO / STEP) + 1
    along = 2 * round(HALO * sections.pixel / sections.spacing) + 1
    glare = np.asarray(cv2.dilate(glare, np.ones((along, across), np.uint8)), np.uint8)
    share[~sections.visible | (glare > 0)] = np.nan
    return share


def find_edges(sections: Sections, noise: Array, ink: Array, side: int) -> Edges:
    """The first edges outward on the right (0) or left (1) side.

    Behind an edge the bed has to be seen for a while. A stretch too short for that, with ink
    again behind it, may be glare on the bead, or bed before a drop spilled beside it: then the
    nearer or the farther edge is right, whichever goes on along the path.
    """
    middle = len(sections.offset) // 2
    outward = slice(middle, None) if side else slice(middle, None, -1)
    share = ink[:, outward]
    foreign = np.maximum.accumulate(sections.foreign[:, outward], axis=1)
    outside = share < 0.5  # False where it is not seen
    nearer, farther = (_first_run(outside | foreign, round(length / STEP))
                       for length in (SETTLED, GLARE))
    count = share.shape[1]
    column = np.arange(count)
    border = np.where(foreign.any(axis=1), np.argmax(foreign, axis=1), count)
    before = column < nearer[:, None]
    hidden: Flags = np.any(sections.hidden[:, outward] & before, axis=1)
    missing: Flags = np.any(~sections.inside[:, outward] & before, axis=1)
    joined = (nearer >= border) & (border < count) & ~hidden & ~missing

    step = STEP * sections.pixel
    known = ~(hidden | missing | joined)
    candidates = []
    for first in (nearer, farther):
        found = known & (first > 0) & (first < np.minimum(border, count))
        position, slope = refine(share, np.clip(first, 1, count - 1), noise)
        candidates.append(np.where(found, (position * step, noise * step / slope), np.nan))
    near, far = candidates
    sure = nearer == farther
    expected = sections.steady(np.where(sure, near[0], np.nan))
    share_sure = sections.steady(sure.astype(float))
    expected = np.where(share_sure > 0.5, expected, sections.steady(far[0]))
    take_far = ~sure & ~(np.abs(near[0] - expected) <= np.abs(far[0] - expected))
    distance, sigma = np.where(take_far, far, near)
    flaw = flaws(distance, np.fmax(4 * sigma, SPIKE * sections.pixel), sections.spacing)
    distance[flaw], sigma[flaw] = np.nan, np.nan
    smooth = smoothed(distance)
    return Edges(smooth, sigma * np.where(smooth == distance, 1.0, SMOOTHING_GAIN), hidden,
                 missing, joined)


def _first_run(flags: Flags, length: int) -> Index:
    """Where (N,) the first run of so many True starts in each row (N, K); K = there is none."""
    padded = np.pad(flags, ((0, 0), (0, length)), constant_values=True)
    total = np.pad(np.cumsum(padded, axis=1), ((0, 0), (1, 0)))
    full: Flags = np.equal(total[:, length:] - total[:, :-length], length)
    return np.argmax(full[:, :flags.shape[1] + 1], axis=1)


def flaws(distance: Array, tolerance: Array, spacing: float) -> Flags:
    """Where (N,) an edge (N,) [m] does not go on from its neighbours, to a tolerance (N,) [m].

    Single ones, and short stretches that begin and end with a jump, as where a reflection runs
    along the side of a bead.
    """
    single = np.abs(distance - running_median(distance, 5)) > tolerance
    jump = np.abs(np.diff(distance)) > np.maximum(tolerance[1:], spacing)
    unknown = np.isnan(distance)
    border = np.concatenate(([True], jump | unknown[1:] | unknown[:-1]))
    stretch = np.cumsum(border) - 1
    length = np.bincount(stretch)[stretch] * spacing
    jumps = np.bincount(stretch, np.concatenate(([False], jump)), len(border))
    # A stretch begins with its own jump, and ends with that of the next.
    ends = np.append(jumps[1:], 0.0)
    return single | ((length < ISLAND) & (jumps > 0)[stretch] & (ends > 0)[stretch])


def smoothed(values: Array) -> Array:
    """Values (N,) with 1/4 of each neighbour's mixed in, where both are known."""
    result = values.copy()
    middle = (values[:-2] + 2 * values[1:-1] + values[2:]) / 4
    result[1:-1] = np.where(np.isfinite(middle), middle, values[1:-1])
    return result


def refine(share: Array, first: Index, noise: Array) -> tuple[Array, Array]:
    """Where (N,) shares (N, K) pass half-way between the levels on either side, and how steeply.

    Levels are read beside the edge itself, since light, shade and a camera's blur near the
    end of a run change them from place to place; and again from where that moves the edge to. The
    half-way crossing is then moved to where as much ink lies outside as bed inside, which
    holds for whole pixels as well. In samples from the path; NaN = no edge.
    """
    near, far = (round(distance / STEP) for distance in PLATEAU)
    row = np.arange(len(share))[:, None]
    steps = np.arange(near, far + 1)

    def read(index: Index) -> Array:
        return share[row, np.clip(index, 0, share.shape[1] - 1)]

    start = first[:, None]
    for _ in range(PASSES):
        inside = read(np.maximum(start - 1 - steps, 0))
        # A reflection near the edge takes away from the ink: then what it leaves counts.
        fullest = np.percentile(inside, 90, axis=1) - np.maximum(0.1, 2 * noise)
        inner = np.maximum(np.median(inside, axis=1), fullest)
        outer = np.median(read(start + steps), axis=1)
        step = np.where((inner - outer > 0.3) & (inner > 0.3) & (outer < 0.5), inner - outer,
                        np.nan)
        index = start + np.arange(-near - 1, near + 1)
        values = (read(index) - outer[:, None]) / step[:, None] - 0.5
        falls = (values[:, :-1] >= 0) & (values[:, 1:] < 0)
        nearest = np.argmin(np.where(falls, np.abs(index[:, :-1] + 0.5 - start), np.inf), axis=1)
        above, below = (values[row[:, 0], nearest + ahead] for ahead in (0, 1))
        slope = np.where(falls.any(axis=1), above - below, np.nan)
        crossing = index[row[:, 0], nearest] + above / slope
        start = np.where(np.isfinite(crossing), np.ceil(crossing), 1).astype(np.intp)[:, None]

    reach = np.linspace(-near, near, 4 * near + 1)
    place = np.where(np.isfinite(crossing), crossing, 1.0)[:, None] + reach
    base = np.floor(place).astype(np.intp)
    part = place - base
    values = (1 - part) * read(base) + part * read(base + 1)
    values = (values - outer[:, None]) / step[:, None] - 0.5
    surplus = trapezoid(values, reach, axis=1)
    shift = surplus / np.maximum(values[:, 0] - values[:, -1], 0.5)
    return crossing + np.clip(shift, -1.0, 1.0), slope * step


def leans_over_gap(sections: Sections, status: StatusArray) -> Flags:
    """Where (N,) what looks like ink may be the end of a bead that hides a gap behind it.

    Seen obliquely along the path, the ridge of a bead's end covers the bed beyond.
    """
    arc = np.arange(len(status)) * sections.spacing
    gaps = arc[status == Status.GAP]
    if len(gaps) == 0:
        return np.zeros(len(status), bool)
    after = np.searchsorted(gaps, arc)
    padded = np.concatenate(([-np.inf], gaps, [np.inf]))
    ahead, behind = padded[after + 1] - arc, arc - padded[after]
    reach = np.abs(sections.lean) + sections.spacing / 2
    leaning = np.abs(sections.lean) > RIM * sections.pixel
    return np.asarray(leaning & (np.where(sections.lean > 0, ahead, behind) < reach))


def meets_itself(sections: Sections, typical: Array, inked: Flags) -> Flags:
    """Where (N,) ink of another pass of the path lies on the cross segment of this one.

    ``typical`` (N,) are the widths to be expected [m].
    """
    met = np.zeros(len(typical), bool)
    index = np.flatnonzero(inked & np.isfinite(typical))
    if len(index) == 0:
        return met
    half, foot, margin = typical / 2, sections.foot, sections.pixel
    pairs = cKDTree(foot[index]).query_pairs(
        2 * float(half[index].max()) + margin, output_type='ndarray')
    for one, other in (index[pairs].T, index[pairs[:, ::-1]].T):
        apart = foot[other] - foot[one]
        across = np.abs(np.einsum('nk,nk->n', apart, sections.lateral[one]))
        distance = np.linalg.norm(apart, axis=1)
        along = np.sqrt(np.maximum(distance**2 - across**2, 0.0))
        reached = np.hypot(np.maximum(across - half[one] - margin, 0.0), along) < half[other]
        # A bend of one pass is no longer than half a circle on its chord, and some.
        arc = np.abs(one - other) * sections.spacing
        met[one[reached & (arc > np.pi / 2 * distance + half[one] + half[other])]] = True
    return met


def _covariance(residual: Array, core: float) -> Array:
    """Covariance (3, 3) of the inner share ``core`` of residuals (K, 3), and never quite nothing.

    As if they were normally distributed, in which case a core has less of it.
    """
    floor = np.eye(3) * 0.5**2  # rounding to whole grey levels, and then some
    residual = residual[np.isfinite(residual).all(axis=1)]
    if len(residual) < 10:
        return floor
    size = np.linalg.norm(residual, axis=1)
    inner = residual[size <= np.quantile(size, core)]
    part = chi2.cdf(chi2.ppf(core, 3), 5) / core
    return np.asarray(inner.T @ inner / len(inner) / part + floor)
