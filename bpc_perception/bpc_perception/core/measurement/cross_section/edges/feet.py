"""Where beads meet the bed: picture and cloud weighed by what each knows of it.

Light fades toward the rim of a bright bead; a dark one throws shade; one seen from the side hides
its foot, or shows more than that. So the edges in a picture lie beside the feet, all along a
print by about as much. The cloud tells heights whatever the light; its beads are all wrong by
about as much, too. By how much the two differ, from one side, tells how far each is off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from bpc_perception.core.arrays import Array, Flags, Floats
from bpc_perception.core.filters import masked_median
from bpc_perception.core.measurement.cross_section.by_cloud.cloud_beads import (
    CloudBeads,
    direction,
    MOST_LEANS,
)
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.edges.rim import between_samples
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.view import View

# What an edge of the picture is not sure of: at best; per share of light by which it is unlike a
# blurred step; and where a bead is seen from the side. Found with ray-traced pictures.
EDGE_SIGMA_PX, UNLIKE_SIGMA_PX, LEAN_SIGMA_PX = 0.03, 1.8, 0.2
BLUR_SIGMA_PX, SHARP_PX = 0.25, 1.0  # per pixel beyond a sharp one's blur: it mixes in the rim
MOST_UNLIKE = 0.08  # a picture that is sharpened, or lit from aside, is more so
USUAL_HALF_PX = 5.0  # half the width of a bead; of narrower ones less is seen apart
# From an edge: where its blur is read, what there is beside, and the level of the ink.
NEAR_PX, FAR_PX, INNER_PX = 1.0, 1.75, 3.0
PART_OF_HALF, CORE = 0.6, 0.85  # of half a width: the first two, and the last, lie no farther in
LIKELY_FLANK = (0.01, 0.4)  # share of ink at NEAR_PX outside
# From so many sigmas, and from this share of half a width, one of the two is wrong.
CONTRADICTION, CONTRADICTION_SHARE = 4.0, 0.25


@dataclass(frozen=True)
class Feet:
    """How far feet lie outward of edges, for B directions of view across the path [pixels].

    The two rows are for the side away from the camera, and for that toward it.

    Attributes:
        picture: (2, B) outward of the edges in the picture.
        cloud: (2, B) outward of the feet of beads in the cloud; NaN = they contradict each other.
        sigma: (2, B) 1-sigma uncertainty of both.
    """

    picture: Array
    cloud: Array
    sigma: Array

    def outward(self, lean: Array) -> tuple[Array, Array, Array]:
        """Return picture, cloud and sigma (N,) on one side [pixels].

        ``lean`` (N,) is how far the top of a bead seems shifted to that side, per height.
        """
        place = np.where(lean >= 0, 0, 1), direction(lean)
        return self.picture[place], self.cloud[place], self.sigma[place]


def lean_to_left(view: View, sections: Sections, normal: Array) -> Array:
    """Return how far to the left (N,) the top of a bead seems shifted, per height."""
    to_camera = view.viewpoint - sections.foot
    lean: Array = -np.einsum('nk,nk->n', to_camera, sections.lateral) / (to_camera @ normal)
    return lean


def find_feet(sections: Sections, ink: Floats, left: Edges, right: Edges, lean: Array,
              whole: Flags, cloud: CloudBeads, cloud_sigma: float) -> Feet:
    """Find how far the feet of a print's beads lie outward of what shows their edges.

    Args:
        sections: N sections on the bed.
        ink: (N, M) share of ink in each sample.
        left: edges on the left.
        right: edges on the right.
        lean: (N,) see ``lean_to_left``.
        whole: (N,) where a bead lies alone between its edges.
        cloud: beads in the cloud.
        cloud_sigma: of their widths, as a share of them.
    """
    half = (left.distance + right.distance) / 2
    known, directions = whole & np.isfinite(half), direction(lean)
    further = (cloud.left - left.distance, cloud.right - right.distance)
    beads, found = _Beads(sections, ink, left, right, half), np.full((3, 2, MOST_LEANS), np.nan)
    for one in np.unique(directions[known]).tolist():
        same = known & (directions == one)
        pixels, lean_of_these = beads.half_pixels(same), float(np.abs(lean[same]).mean())
        for side, away in enumerate((lean >= 0, lean < 0)):
            sides = same & away, same & ~away
            shift = np.concatenate([outward[rows] for outward, rows in zip(
                further, sides, strict=True)])
            shift = shift[np.isfinite(shift)] / sections.pixel
            found[:, side, one] = weigh(
                beads.picture_sigma(*sides, lean_of_these),
                float(np.median(shift)) if len(shift) else np.nan,
                cloud_sigma * pixels, pixels)
    return Feet(*_from_nearest(found))


@dataclass(frozen=True)
class _Beads:
    """Sections, the share of ink in their samples, edges, and half the widths between them."""

    sections: Sections
    ink: Floats
    left: Edges
    right: Edges
    half: Array

    def half_pixels(self, rows: Flags) -> float:
        """Return half the usual width of some beads [pixels]."""
        return float(np.median(self.half[rows])) / self.sections.pixel

    def picture_sigma(self, on_left: Flags, on_right: Flags, lean: float) -> float:
        """Return the 1-sigma uncertainty of edges in the picture, all along a print [pixels].

        Args:
            on_left: (N,) which edges on the left.
            on_right: (N,) which on the right.
            lean: how far from the side they are seen.
        """
        step, middle = SAMPLE_STEP_PX * self.sections.pixel, self.sections.on_path
        unlike, blur = unlike_step(
            np.concatenate((self.ink[on_left, middle:], self.ink[on_right, middle::-1])),
            np.concatenate((self.left.distance[on_left], self.right.distance[on_right])) / step,
            np.concatenate((self.half[on_left], self.half[on_right])) / step)
        narrow = max(USUAL_HALF_PX / self.half_pixels(on_left | on_right), 1.0)**2
        spread = BLUR_SIGMA_PX * max(blur * SAMPLE_STEP_PX - SHARP_PX, 0.0)
        return float(np.sqrt((EDGE_SIGMA_PX * narrow + UNLIKE_SIGMA_PX * unlike)**2 + spread**2
                             + (LEAN_SIGMA_PX * lean**2)**2))


def _from_nearest(found: Array) -> Array:
    """Return values (3, 2, B), with those of the nearest direction where one has none."""
    known = np.flatnonzero(np.isfinite(found[2, 0]))
    if not len(known):
        nothing = np.full(found.shape[1:], np.nan)
        return np.stack((np.zeros_like(nothing), nothing, np.full_like(nothing, EDGE_SIGMA_PX)))
    nearest = np.abs(np.arange(found.shape[2])[:, None] - known).argmin(axis=1)
    return np.asarray(found[:, :, known[nearest]])


def unlike_step(share: Floats, edge: Array, half: Array) -> tuple[float, float]:
    """Return by how much the picture of edges differs from that of a blurred step, and its blur.

    A lens shows as much ink outside of a step as it shows bed inside. Light that is lost toward
    the rim, and shade beside it, do not come in pairs; nor do they end as soon.

    Args:
        share: (K, M) of ink in samples across the path, in order of distance from it.
        edge: (K,) where the edge is [samples].
        half: (K,) half the width of the bead [samples].

    Returns:
        A share of light, and the 1-sigma blur [samples].
    """
    near, far, inner = (np.minimum(distance / SAMPLE_STEP_PX, part * half) for distance, part in (
        (NEAR_PX, PART_OF_HALF), (FAR_PX, PART_OF_HALF), (INNER_PX, CORE)))
    shown = np.stack([between_samples(share, place) for place in (
        edge - inner, edge - far, edge + near, edge + far)])
    level, inside, flank, outside = masked_median(shown, np.isfinite(shown))
    if not level > 0:
        return MOST_UNLIKE, 0.0
    blur = np.median(near) / -float(ndtri(np.clip(flank / level, *LIKELY_FLANK)))
    expected = float(ndtr(-np.median(far) / blur))
    unlike = abs(1 - inside / level - expected) + abs(outside / level - expected)
    return float(np.fmin(unlike, MOST_UNLIKE)), float(np.nan_to_num(blur))


def weigh(picture_sigma: float, shift: float, cloud_sigma: float,
          half: float) -> tuple[float, float, float]:
    """Return how far a foot lies outward of its edge in picture and cloud, and its sigma [pixels].

    Args:
        picture_sigma: of the edge in the picture.
        shift: how far outward of that the cloud has it; NaN = it tells nothing.
        cloud_sigma: of the edge in the cloud.
        half: half the width of the bead in the picture.
    """
    if np.isnan(shift + cloud_sigma):
        return 0.0, np.nan, picture_sigma
    sigmas = np.hypot(picture_sigma, cloud_sigma)
    if abs(shift) > min(CONTRADICTION * sigmas, CONTRADICTION_SHARE * half):
        return 0.0, np.nan, abs(shift)
    share = float((picture_sigma / sigmas)**2)
    return share * shift, (share - 1) * shift, float(np.sqrt(share)) * cloud_sigma
