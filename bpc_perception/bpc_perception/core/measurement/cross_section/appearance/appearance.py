"""What ink and bed look like along a path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import masked_median, running_mean
from bpc_perception.core.measurement.cross_section.appearance.bed_colour import find_bed
from bpc_perception.core.measurement.cross_section.appearance.clipping import (
    clipped_where_used,
    left_out,
)
from bpc_perception.core.measurement.cross_section.appearance.contrast import (
    Contrast,
    core_covariance,
)
from bpc_perception.core.measurement.cross_section.sections.lines import less_each
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.scale import steady_window
from bpc_perception.core.profile import Cause, CauseArray

SECTIONS_ASKED = 100  # about this number tells how much colours vary
# What is brighter than the bed is glare from this number of sigma, and from this share of the step
# from ink to bed: a bed that is mottled has brighter places, which no more look like ink.
GLARE_SIGMAS, GLARE_STEP = 5.0, 0.2
BED_CORE = 0.5  # share of what lies beside the path that is surely bed; the rest may be other ink
INK_CORE = 0.95  # share of the ink that counts: shading and reflections are part of how it looks
ROUNDS = 2  # of finding the direction in which ink and bed differ, and then the ink
INKY = 0.5  # share of ink from which a section's middle is taken for ink,
INKY_PIXEL = 0.6  # and a pixel
FEW_INKY = 0.2  # of the sections around, with so few nothing that was laid stands out


# Why ink is not told from bed.
UNTOLD = Cause.OVEREXPOSED, Cause.OLD_INK, Cause.LOW_CONTRAST


@dataclass(frozen=True)
class Appearance:
    """What ink and bed look like at N sections.

    Attributes:
        bed: (2, N, 3) colours of the bed to the right and to the left.
        weight: (N, 3) how to weigh colour channels, so that a step from bed to ink is 1.
        noise: (N,) 1-sigma noise of a colour so weighed; large = ink is not told from bed.
        clipped: (N,) whether a channel is clipped that tells ink from bed.
        like_ink: (N,) whether the bed looks like ink of another print.
        glare_from: (2, N) brightness, the mean of red, green and blue, above which a sample is
            neither ink nor bed.
        contrast: of the whole print; None = nothing is told apart.
    """

    bed: Array
    weight: Array
    noise: Array
    clipped: Flags
    like_ink: Flags
    glare_from: Array
    contrast: Contrast | None

    def at(self, index: Index) -> Appearance:
        """Return the appearance at sections of these indices (K,)."""
        return Appearance(self.bed[:, index], self.weight[index], self.noise[index],
                          self.clipped[index], self.like_ink[index], self.glare_from[:, index],
                          self.contrast)

    def untold(self, maximum_noise: float) -> CauseArray:
        """Return why ink is not told from bed (N,); NONE = it is, with no more noise than this."""
        conditions = self.clipped, self.like_ink, self.noise > maximum_noise
        return np.select(conditions, UNTOLD, Cause.NONE).astype(np.uint8)


@dataclass(frozen=True)
class _Pixels:
    """Samples of N sections once a pixel, K each.

    Attributes:
        colour: (N, K, 3) RGB.
        visible: (N, K) whether a sample is seen.
        beside: (N, K) whether it is seen where bed is to be expected.
        sides: which of the K lie on the right and the left.
        some: which of the N sections tell how much colours vary.
    """

    colour: Floats
    visible: Flags
    beside: Flags
    sides: tuple[slice, slice]
    some: slice


def find_appearance(sections: Sections, extruding: Flags,
                    known: Contrast | None = None) -> Appearance:
    """Find what ink and bed look like along the path.

    Args:
        sections: N sections.
        extruding: (N,) whether ink was being pushed out.
        known: how ink differs from bed in the whole print. It is needed for a part of the print,
            which may hold too little ink to tell.
    """
    pixels = once_a_pixel(sections)
    centre = colours_on_path(sections)
    bed, open_bed = find_bed(sections, np.stack([
        masked_median(pixels.colour[:, side], pixels.beside[:, side])
        for side in pixels.sides]), centre, known)
    from_bed = _less_bed(pixels, bed)
    step = centre - bed.mean(axis=0)
    if known is not None:
        bed_spread, typical, spread = known.bed_spread, known.step, known.spread
    else:
        some = pixels.some
        bed_spread = core_covariance(from_bed[some][pixels.beside[some]], BED_CORE)
        # bed_spread stays what it is: of what is left out the noise counts for nothing.
        spread = bed_spread + np.diag(left_out(bed, centre, bed_spread))
        typical = typical_step(step, spread, extruding)
    if not typical.any():  # nothing is seen there, or all of one colour
        unknown = np.full(len(step), np.inf)
        none = np.zeros(len(step), bool)
        return Appearance(bed, np.zeros_like(step), unknown, none, none,
                          np.stack((unknown, unknown)), None)

    print_bed = known.bed if known is not None else np.nanmedian(bed.mean(axis=0), axis=0)
    # What varies within the ink, its shading, is seen only once it is known where ink is.
    for _ in range(ROUNDS):
        inky = share_of_ink(step, typical, spread) > INKY
        local = local_step(sections, step, inky, typical)
        weight = fisher_weights(local, spread)
        ink_pixels = _pixels_in_ink(pixels, weighed(from_bed, weight) > INKY_PIXEL, inky)
        # All of the ink, not its middle alone, where light from above is reflected.
        ink = masked_median(pixels.colour, ink_pixels)
        step = np.where(np.isfinite(ink), ink - bed.mean(axis=0), step)
        if known is None:
            spread = (bed_spread + _ink_spread(pixels, ink, ink_pixels)
                      + np.diag(left_out(bed, ink, bed_spread)))
    noise = np.sqrt(np.einsum('ni,ij,nj->n', weight, bed_spread, weight))
    like_ink = looks_like_ink(sections, bed.mean(axis=0) - print_bed, inky, typical, spread)
    clipped = clipped_where_used(bed, ink, bed_spread, weight, local)
    noise[like_ink | clipped] = np.inf
    # On ink brighter than its bed, what is brighter still is no less ink. Bed is darkened by ink
    # close to it, and by how much differs.
    brightest = np.maximum(bed, open_bed).mean(axis=2)
    step_up = -local.mean(axis=1)  # from ink to bed
    excess = np.maximum(GLARE_SIGMAS * np.sqrt(bed_spread.sum()) / 3, GLARE_STEP * step_up)
    glare_from = np.where(step_up > 0, brightest + excess, np.inf)
    contrast = known or Contrast(float(sections.clearance.max()) / 2, print_bed, typical,
                                 bed_spread, spread)
    return Appearance(bed, weight, noise, clipped, like_ink, glare_from, contrast)


def once_a_pixel(sections: Sections) -> _Pixels:
    """Return the sections with one sample a pixel."""
    coarse = slice(None, None, round(1 / SAMPLE_STEP_PX))
    colour = np.ascontiguousarray(sections.colour[:, coarse])
    visible = sections.visible[:, coarse]
    middle = int(np.searchsorted(sections.offset[coarse], 0.0, side='right'))
    return _Pixels(colour, visible, sections.beside[:, coarse] & visible,
                   (slice(None, middle), slice(middle, None)),
                   slice(None, None, max(1, len(colour) // SECTIONS_ASKED)))


def colours_on_path(sections: Sections) -> Array:
    """Return the mean colours (N, 3) within a pixel of the path; NaN where not all is seen."""
    on_path = np.abs(sections.offset) <= sections.pixel
    centre = sections.colour[:, on_path].mean(axis=1).astype(np.float64)
    centre[~sections.visible[:, on_path].all(axis=1)] = np.nan
    return centre


def typical_step(step: Array, bed_spread: Array, extruding: Flags) -> Array:
    """Return the step (3,) from bed to ink where it is clear; 0 where none is known.

    Args:
        step: (N, 3) from the colour of the bed to that on the path.
        bed_spread: (3, 3) how the colour of the bed varies.
        extruding: (N,) whether ink was being pushed out.
    """
    contrast = np.sqrt(np.einsum('ni,ij,nj->n', step, np.linalg.inv(bed_spread), step))
    laid = np.isfinite(contrast) & (extruding if extruding.any() else True)
    strong = laid & (contrast >= (np.median(contrast[laid]) if laid.any() else np.inf))
    return np.asarray(np.median(step[strong], axis=0)) if strong.any() else np.zeros(3)


def share_of_ink(step: Array, typical: Array, spread: Array) -> Array:
    """Return how much (N,) of a typical step (3,) there is in steps (N, 3) from the bed.

    It is read along Fisher's direction [Fisher 1936]; ``spread`` (3, 3) is how colours vary within
    ink and bed.
    """
    towards = np.linalg.solve(spread, typical)
    return np.asarray(step @ towards / (typical @ towards))


def local_step(sections: Sections, step: Array, inky: Flags, typical: Array) -> Array:
    """Return the step (N, 3) from bed to ink around each section, from the inky (N,) ones."""
    local = sections.steady(np.where(inky[:, None], step, np.nan))
    return np.where(np.isfinite(local), local, typical)  # in a part without ink


def looks_like_ink(sections: Sections, from_print: Array, inky: Flags, typical: Array,
                   spread: Array) -> Flags:
    """Return where (N,) what is taken for bed is ink of another print, on both sides.

    It looks like this print's ink, and what was laid there does not stand out. In a dark corner of
    the picture the bed may look so, but there ink is darker still.

    Args:
        sections: N sections.
        from_print: (N, 3) colours of the bed less that of the whole print's bed.
        inky: (N,) which sections have ink on their path, by what is taken for their bed.
        typical: (3,) step from bed to ink.
        spread: (3, 3) how colours vary within ink and bed.
    """
    like_ink = share_of_ink(from_print, typical, spread) > INKY
    around = running_mean(inky[:, None].astype(float), steady_window(sections.spacing),
                          sections.piece)[:, 0]
    return np.asarray(like_ink & (around < FEW_INKY))


def fisher_weights(step: Array, spread: Array) -> Array:
    """Return the weights (N, 3) of colour channels that make steps (N, 3) from bed to ink 1."""
    weight: Array = np.linalg.solve(spread, step.T).T
    weight /= np.einsum('ni,ni->n', step, weight)[:, None]
    return weight


def weighed(colour: Floats, weight: Array) -> Floats:
    """Return colours (N, M, 3) weighed by (N, 3), as (N, M)."""
    return np.asarray(np.matmul(colour, weight[:, :, None].astype(np.float32))[..., 0])


def _less_bed(pixels: _Pixels, bed: Array) -> Floats:
    """Return colours (N, K, 3) less those of the bed (2, N, 3) on their side."""
    return np.concatenate([less_each(pixels.colour[:, side], colours)
                           for side, colours in zip(pixels.sides, bed, strict=True)], axis=1)


def _pixels_in_ink(pixels: _Pixels, inked: Flags, inky: Flags) -> Flags:
    """Return which pixels (N, K) are ink among ink, in sections that are inky (N,)."""
    inner: Flags = (inked & np.roll(inked, 1, axis=1) & np.roll(inked, -1, axis=1)
                    & pixels.visible & inky[:, None])
    return inner


def _ink_spread(pixels: _Pixels, ink: Array, ink_pixels: Flags) -> Array:
    """Return how colours vary (3, 3) within the ink, around its colour (N, 3) at each section."""
    some = pixels.some
    inked = ink_pixels[some]
    usual = ink[some][np.nonzero(inked)[0]]
    return core_covariance(pixels.colour[some][inked] - usual, INK_CORE)
