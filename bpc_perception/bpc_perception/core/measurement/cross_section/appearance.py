"""What ink and bed look like along a path, and how much of each place is ink."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import masked_median
from bpc_perception.core.measurement.cross_section.sections import Sections, STEP

ASKED = 100  # about so many sections tell how much colours vary
BRIGHT = 5.0  # brighter than the bed by so many sigma is glare,
SPECK = 4.0  # unless it is smaller than this [square pixels], which noise is as well,
SURE = 2.0  # and nowhere brighter by so many times that
HALO = 2.5  # around glare the lens spreads its light so far [pixels]
BED_CORE = 0.5  # beside the path some of what lies there may be other ink
INK_CORE = 0.95  # shading and reflections are part of what ink looks like


@dataclass(frozen=True)
class Contrast:
    """How ink differs from bed in a print as a whole.

    Attributes:
        clearance: from which distance to all of the path bed is sure, if only because there is
            no more [m].
        step: (3,) from the colour of the bed to that of the ink.
        bed_spread, spread: (3, 3) how colours vary within the bed, and within both.
    """

    clearance: float
    step: Array
    bed_spread: Array
    spread: Array


@dataclass(frozen=True)
class Light:
    """What ink and bed look like at N sections.

    Attributes:
        bed: (2, N, 3) colours of the bed to the right and to the left.
        weight: (N, 3) how to weigh colour channels, so that a step from bed to ink is 1.
        noise: (N,) 1-sigma noise of a colour so weighed; large = ink is not told from bed.
        glare_from: (2, N) brightness, the mean of red, green and blue, above which a sample is
            neither ink nor bed.
        contrast: of the whole print; None = nothing is told apart.
    """

    bed: Array
    weight: Array
    noise: Array
    glare_from: Array
    contrast: Contrast | None

    def at(self, index: Index) -> Light:
        """The light at sections of these indices (K,)."""
        return Light(self.bed[:, index], self.weight[index], self.noise[index],
                     self.glare_from[:, index], self.contrast)


def find_light(sections: Sections, extruding: Flags, known: Contrast | None = None) -> Light:
    """What ink and bed look like along the path.

    Sections of a part of the print may hold too little ink to tell how it differs from the bed:
    then that has to be ``known`` from the whole.
    """
    on_path = np.abs(sections.offset) <= sections.pixel
    centre = sections.colour[:, on_path].mean(axis=1).astype(np.float64)
    centre[~sections.visible[:, on_path].all(axis=1)] = np.nan
    coarse = slice(None, None, round(1 / STEP))  # a sample a pixel
    colour = np.ascontiguousarray(sections.colour[:, coarse])
    visible = sections.visible[:, coarse]
    beside = sections.beside[:, coarse] & visible
    middle = np.searchsorted(sections.offset[coarse], 0.0, side='right')
    sides = slice(None, middle), slice(middle, None)
    some = slice(None, None, max(1, len(colour) // ASKED))
    bed = find_bed(sections, np.stack([masked_median(colour[:, side], beside[:, side])
                                       for side in sides]), centre, known)
    around_bed = np.concatenate([colour[:, side] - colours[:, None].astype(np.float32)
                                 for side, colours in zip(sides, bed, strict=True)], axis=1)
    step = centre - bed.mean(axis=0)
    bed_spread = (known.bed_spread if known is not None
                  else _covariance(around_bed[some][beside[some]], BED_CORE))
    typical = known.step if known is not None else _typical_step(step, bed_spread, extruding)
    if not typical.any():  # nothing is seen there, or all of one colour
        unknown = np.full(len(step), np.inf)
        return Light(bed, np.zeros_like(step), unknown, np.stack((unknown, unknown)), None)

    # Fisher's direction, twice: what varies within the ink, its shading, is seen only once it
    # is known where ink is.
    spread = bed_spread if known is None else known.spread
    for _ in range(2):
        towards = np.linalg.solve(spread, typical)
        share = step @ towards / (typical @ towards)
        local = sections.steady(np.where((share > 0.5)[:, None], step, np.nan))
        local = np.where(np.isfinite(local), local, typical)  # in a part without ink
        weight = np.linalg.solve(spread, local.T).T
        weight /= np.einsum('ni,ni->n', local, weight)[:, None]
        inked: Flags = _weighed(around_bed, weight) > 0.6
        inner: Flags = (inked & np.roll(inked, 1, axis=1) & np.roll(inked, -1, axis=1) & visible
                        & (share > 0.5)[:, None])
        # All of the ink, not its middle alone, where light from above is reflected.
        ink = masked_median(colour, inner)
        step = np.where(np.isfinite(ink), ink - bed.mean(axis=0), step)
        if known is None:
            around_ink = (colour[some] - ink[some, None])[inner[some]]
            spread = bed_spread + _covariance(around_ink, INK_CORE)
    noise = np.sqrt(np.einsum('ni,ij,nj->n', weight, bed_spread, weight))
    # On ink brighter than its bed, what is brighter still is no less ink.
    brightness = np.where(local.mean(axis=1) < 0, bed.mean(axis=2), np.inf)
    contrast = Contrast(float(sections.clearance.max()) / 2, typical, bed_spread, spread)
    return Light(bed, weight, noise, brightness + BRIGHT * np.sqrt(bed_spread.sum()) / 3,
                 known or contrast)


def _typical_step(step: Array, bed_spread: Array, extruding: Flags) -> Array:
    """Step (3,) from bed to ink where of all steps (N, 3) it is clear; 0 where none is known."""
    contrast = np.sqrt(np.einsum('ni,ij,nj->n', step, np.linalg.inv(bed_spread), step))
    laid = np.isfinite(contrast) & (extruding if extruding.any() else True)
    strong = laid & (contrast >= (np.median(contrast[laid]) if laid.any() else np.inf))
    return np.asarray(np.median(step[strong], axis=0)) if strong.any() else np.zeros(3)


def find_bed(sections: Sections, beside: Array, centre: Array,
             known: Contrast | None = None) -> Array:
    """Colours (2, N, 3) of the bed on both sides, from what lies beside and on the path.

    Where strands lie closely, what lies half-way between them may be ink as well. It is taken for
    bed only if it is nearer to the bed farther out than to the ink.
    """
    clearance = sections.clearance.max() / 2 if known is None else known.clearance
    sure = sections.clearance >= clearance
    open_bed = np.stack([sections.steady(np.where(known[:, None], colours, np.nan))
                         for known, colours in zip(sure, beside, strict=True)])
    open_bed = np.where(np.isfinite(open_bed), open_bed, open_bed[::-1])
    if known is None:
        step = centre - open_bed.mean(axis=0)
        size = np.linalg.norm(step, axis=1)
        strong = (np.median(step[size >= np.nanmedian(size)], axis=0)
                  if np.isfinite(size).any() else np.zeros(3))
    else:
        strong = known.step
    if strong.any():
        sure |= (beside - open_bed) @ strong < 0.4 * (strong @ strong)
    bed = np.stack([sections.steady(np.where(known[:, None], colours, np.nan))
                    for known, colours in zip(sure, beside, strict=True)])
    return np.where(np.isfinite(bed), bed, bed[::-1])


def ink_share(sections: Sections, light: Light) -> Floats:
    """How much of each sample (N, M) is ink: 0 = bed, 1 = ink; NaN where it is not seen.

    In and around glare the colour of what shines is not seen either.
    """
    middle = len(sections.offset) // 2
    share = _weighed(sections.colour, light.weight)
    glare, sure = np.zeros(share.shape, np.uint8), np.zeros(share.shape, bool)
    brightness = np.asarray(cv2.transform(sections.colour, np.full((1, 3), 1 / 3)))
    for side, part in ((0, slice(None, middle)), (1, slice(middle, None))):
        bed = (light.bed[side] * light.weight).sum(axis=1).astype(np.float32)
        share[:, part] -= bed[:, None]
        least = light.glare_from[side]
        most = least + (SURE - 1) * (least - light.bed[side].mean(axis=1))
        glare[:, part] = brightness[:, part] > least[:, None]
        sure[:, part] = brightness[:, part] > most[:, None]
    glare = _without_specks(glare, sure, SPECK / STEP * sections.pixel / sections.spacing)
    across = 2 * round(HALO / STEP) + 1
    along = 2 * round(HALO * sections.pixel / sections.spacing) + 1
    glare = np.asarray(cv2.dilate(glare, np.ones((along, across), np.uint8)), np.uint8)
    share[~sections.visible | (glare > 0)] = np.nan
    return share


def _without_specks(glare: NDArray[np.uint8], sure: Flags, area: float) -> NDArray[np.uint8]:
    """Glare (N, M) but for what hangs together on less than an area [samples], nowhere sure."""
    if not cv2.countNonZero(glare):
        return glare
    _, label, found, _ = cv2.connectedComponentsWithStats(glare)
    kept = found[:, cv2.CC_STAT_AREA] >= area
    kept[label[sure]] = True
    kept[0] = False
    return np.asarray(kept[label], np.uint8)


def _weighed(colour: Floats, weight: Array) -> Floats:
    """Colours (N, M, 3) weighed by (N, 3), as (N, M)."""
    return np.asarray(np.matmul(colour, weight[:, :, None].astype(np.float32))[..., 0])


def _covariance(residual: NDArray[np.floating[Any]], core: float) -> Array:
    """Covariance (3, 3) of the inner share ``core`` of residuals (K, 3), and never quite nothing.

    As if they were normally distributed, in which case a core has less of it.
    """
    floor = np.eye(3) * 0.5**2  # rounding to whole grey levels, and then some
    residual = residual[np.isfinite(residual).all(axis=1)]
    if len(residual) < 10:
        return floor
    size = np.linalg.norm(residual, axis=1)
    inner = residual[size <= np.quantile(size, core)]
    return np.asarray(inner.T @ inner / len(inner) / _inner_part(core) + floor)


@cache
def _inner_part(core: float) -> float:
    """Of the variance of a normal distribution in 3-D, what its inner share ``core`` has."""
    return float(chi2.cdf(chi2.ppf(core, 3), 5) / core)
