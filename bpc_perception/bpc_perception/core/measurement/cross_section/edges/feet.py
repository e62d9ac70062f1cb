"""Where beads meet the bed: picture and cloud weighed by what each knows of it.

Light fades toward the rim of a bright bead; a dark one throws shade; one seen from the side hides
its foot, or shows more than that. So the edges in a picture lie beside the feet, all along a
print by about as much. The cloud tells heights whatever the light. Points of the whole print,
folded into one section, show where height begins to a tenth of a pixel, though a single point is
noisier than that. Where light goes into the ink, the cloud steps down at its feet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from bpc_perception.core.arrays import Array, Flags, Floats
from bpc_perception.core.filters import masked_median
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.edges.folded_section import (
    fit_feet,
    REACH,
)
from bpc_perception.core.measurement.cross_section.edges.rim import between_samples
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.view import View

LEAN_STEP = 0.2  # of the tangent of the view across the path, within which it is about the same
MOST_LEANS = 11  # beyond an angle of 63 degrees nothing is told apart
# What an edge of the picture is not sure of: at best; per share of light by which it is unlike a
# blurred step; and where a bead is seen from the side. Found with ray-traced pictures.
EDGE_SIGMA_PX, UNLIKE_SIGMA_PX, LEAN_SIGMA_PX = 0.03, 1.8, 0.2
MOST_UNLIKE = 0.08  # a picture that is sharpened, or lit from aside, is more so
USUAL_HALF_PX = 5.0  # half the width of a bead; of narrower ones less is seen apart
# From an edge: where its blur is read, what there is beside, and the level of the ink.
NEAR_PX, FAR_PX, INNER_PX = 1.0, 1.75, 3.0
PART_OF_HALF, CORE = 0.6, 0.85  # of half a width: the first two, and the last, lie no farther in
LIKELY_FLANK = (0.01, 0.4)  # share of ink at NEAR_PX outside
CLOUD_SIGMA_PX = 0.08  # what the cloud is not sure of at best
# From so many sigmas, and from this share of half a width, one of the two is wrong.
CONTRADICTION, CONTRADICTION_SHARE = 4.0, 0.25


@dataclass(frozen=True)
class Feet:
    """How far feet lie outward of the picture's edges, for B directions of view across the path.

    Attributes:
        far, near: (B,) on the side away from the camera, and toward it [pixels].
        far_sigma, near_sigma: (B,) their 1-sigma uncertainties [pixels].
    """

    far: Array
    near: Array
    far_sigma: Array
    near_sigma: Array

    def outward(self, lean: Array) -> tuple[Array, Array]:
        """Return the shifts of edges and their sigmas (N,) on one side [pixels].

        ``lean`` (N,) is how far the top of a bead seems shifted to that side, per height.
        """
        row, away = _direction(lean), lean >= 0
        return (np.where(away, self.far[row], self.near[row]),
                np.where(away, self.far_sigma[row], self.near_sigma[row]))


def lean_to_left(view: View, sections: Sections, normal: Array) -> Array:
    """Return how far to the left (N,) the top of a bead seems shifted, per height."""
    to_camera = view.viewpoint - sections.foot
    lean: Array = -np.einsum('nk,nk->n', to_camera, sections.lateral) / (to_camera @ normal)
    return lean


def find_feet(sections: Sections, ink: Floats, left: Edges, right: Edges, lean: Array,
              whole: Flags) -> Feet:
    """Find how far the feet of a print's beads lie outward of the edges of the picture.

    Args:
        sections: N sections on the bed.
        ink: (N, M) share of ink in each sample.
        left: edges on the left.
        right: edges on the right.
        lean: (N,) see ``lean_to_left``.
        whole: (N,) where a bead lies alone between its edges.
    """
    half, middle = (left.distance + right.distance) / 2, (left.distance - right.distance) / 2
    known = whole & np.isfinite(half)
    direction, away = _direction(lean), np.where(lean >= 0, 1.0, -1.0)
    # Along the rays of the camera noise does not move a point.
    seen_at = sections.place + sections.height * lean[:, None].astype(np.float32)
    with np.errstate(invalid='ignore'):
        u = (seen_at - middle[:, None]) * (away / half)[:, None]
        height = sections.height / half[:, None]
        counts = (known[:, None] & (np.abs(u) < REACH) & np.isfinite(height)
                  & ~sections.foreign & ~sections.hidden)
    beads = _Beads(sections, ink, left, right, half)
    found, sigma = np.full((2, 2, MOST_LEANS), np.nan)
    section = None
    # From where most is seen the section is known best, and it is the same from everywhere.
    for one in np.argsort(-np.bincount(direction[known], minlength=MOST_LEANS), kind='stable'):
        same = known & (direction == one)
        if not same.any():
            break
        lean_of_these, pixels = float(np.abs(lean[same]).mean()), beads.half_pixels(same)
        rows = counts & same[:, None]
        cloud = fit_feet(u[rows], height[rows], lean_of_these, section)
        section = cloud.section if section is None else section
        for side, toward in enumerate((away > 0, away < 0)):
            found[side, one], sigma[side, one] = weigh(
                beads.picture_sigma(same & toward, same & ~toward, lean_of_these),
                float(cloud.shift[side]) * pixels,
                float(np.hypot(cloud.sigma[side] * pixels, CLOUD_SIGMA_PX)), pixels)
    return Feet(*_from_nearest(found, 0.0), *_from_nearest(sigma, EDGE_SIGMA_PX))


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
        unlike = unlike_step(
            np.concatenate((self.ink[on_left, middle:], self.ink[on_right, middle::-1])),
            np.concatenate((self.left.distance[on_left], self.right.distance[on_right])) / step,
            np.concatenate((self.half[on_left], self.half[on_right])) / step)
        narrow = max(USUAL_HALF_PX / self.half_pixels(on_left | on_right), 1.0)**2
        return float(np.hypot(EDGE_SIGMA_PX * narrow + UNLIKE_SIGMA_PX * unlike,
                              LEAN_SIGMA_PX * lean**2))


def _from_nearest(values: Array, otherwise: float) -> Array:
    """Return values (2, B), in the place of NaN that of the nearest direction which has one."""
    known = np.flatnonzero(np.isfinite(values[0]))
    if not len(known):
        return np.full_like(values, otherwise)
    nearest = np.abs(np.arange(values.shape[1])[:, None] - known).argmin(axis=1)
    return np.asarray(values[:, known[nearest]])


def unlike_step(share: Floats, edge: Array, half: Array) -> float:
    """Return by how much the picture of edges differs from that of a blurred step.

    A lens shows as much ink outside of a step as it shows bed inside. Light that is lost toward
    the rim, and shade beside it, do not come in pairs; nor do they end as soon.

    Args:
        share: (K, M) of ink in samples across the path, in order of distance from it.
        edge: (K,) where the edge is [samples].
        half: (K,) half the width of the bead [samples].
    """
    near, far, inner = (np.minimum(distance / SAMPLE_STEP_PX, part * half) for distance, part in (
        (NEAR_PX, PART_OF_HALF), (FAR_PX, PART_OF_HALF), (INNER_PX, CORE)))
    shown = np.stack([between_samples(share, place) for place in (
        edge - inner, edge - far, edge + near, edge + far)])
    level, inside, flank, outside = masked_median(shown, np.isfinite(shown))
    if not level > 0:
        return MOST_UNLIKE
    blur = np.median(near) / -float(ndtri(np.clip(flank / level, *LIKELY_FLANK)))
    expected = float(ndtr(-np.median(far) / blur))
    unlike = abs(1 - inside / level - expected) + abs(outside / level - expected)
    return float(np.fmin(unlike, MOST_UNLIKE))


def weigh(picture_sigma: float, shift: float, cloud_sigma: float,
          half: float) -> tuple[float, float]:
    """Return shift and sigma of an edge, of what the picture and the cloud know of it [pixels].

    Args:
        picture_sigma: of the edge in the picture, where the shift is 0.
        shift: what the cloud says; NaN = nothing.
        cloud_sigma: of that.
        half: half the width of the bead in the picture.
    """
    if np.isnan(shift):
        return 0.0, picture_sigma
    sigmas = np.hypot(picture_sigma, cloud_sigma)
    if abs(shift) > min(CONTRADICTION * sigmas, CONTRADICTION_SHARE * half):
        return 0.0, abs(shift)
    share = picture_sigma**2 / (picture_sigma**2 + cloud_sigma**2)
    return share * shift, float(np.sqrt(share)) * cloud_sigma


def _direction(lean: Array) -> Array:
    """Return the number (N,) of the direction from which a path is seen."""
    return np.minimum(np.rint(np.abs(lean) / LEAN_STEP), MOST_LEANS - 1).astype(np.intp)
