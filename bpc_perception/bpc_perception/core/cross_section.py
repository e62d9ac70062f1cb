"""Thickness from the image across the path: the default method.

A line is laid on the bed across each path point, and the image is read along it. Where the grey
level passes half-way between ink and bed, there is the edge, to a fraction of a pixel. The path
says which boundary is meant: the first that is met on either side, going outwards from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bpc_perception.core.capture import Capture
from bpc_perception.core.config import CrossSectionConfig
from bpc_perception.core.geometry import Array, invert, Plane, transform
from bpc_perception.core.profile import Status
from bpc_perception.core.surface import Mask, near, StatusArray
from bpc_perception.core.thickness import SidePoints

Floats = NDArray[np.float32]
Mask2 = NDArray[np.bool_]

STEP = 0.5  # between samples of a section [pixels]
SETTLED = 2.0  # an edge is one when the bed is seen for so long behind it [pixels]


@dataclass(frozen=True)
class Sections:
    """Lines on the bed across N path points, M samples each, from right to left.

    Attributes:
        foot: (N, 3) path points on the bed [m].
        lateral: (N, 3) unit vectors to the left of the direction of travel.
        offset: (M,) distances from the path, positive to the left [m].
        pixel: length of a pixel's side on the bed [m].
        uv: (N, M, 2) pixels of the samples.
        visible: (N, M) whether a sample is in the image and not hidden.
        colour: (N, M, 3) RGB.
    """

    foot: Array
    lateral: Array
    offset: Array
    pixel: float
    uv: Array
    visible: Mask2
    colour: Floats


def measure_cross_sections(
    capture: Capture, points: Array, T_base_camera: Array, bed: Plane, obstacle: Mask,
    config: CrossSectionConfig,
) -> tuple[SidePoints, StatusArray, Array]:
    """Side points, status (N,) and sigma (N,) of path points (N, 3)."""
    sections = lay_sections(capture, points, T_base_camera, bed, obstacle, config)
    ink, noise = ink_share(sections)
    centre = np.abs(sections.offset) <= sections.pixel
    inner = ink[:, centre].mean(axis=1)  # NaN where hidden
    # Next to the end of a run the blur of the camera leaves less than full ink.
    level = np.clip(inner, 0.5, 1.0) / 2
    left, left_sigma = outward_edge(sections, ink, level, noise, towards_left=True)
    right, right_sigma = outward_edge(sections, ink, level, noise, towards_left=False)

    status = np.full(len(points), Status.LOW_CONFIDENCE, np.uint8)
    status[np.isfinite(left + right) & (inner >= 0.5)] = Status.MEASURED
    status[(inner < 0.5) & (np.abs(inner) < 0.5)] = Status.GAP
    if noise > config.maximum_noise:
        status[:] = Status.LOW_CONFIDENCE
    sigma = np.hypot(np.hypot(left_sigma, right_sigma), config.edge_sigma * sections.pixel)
    sides = SidePoints(sections.foot + left[:, None] * sections.lateral,
                       sections.foot - right[:, None] * sections.lateral, left, right)
    return sides, status, sigma


def lay_sections(capture: Capture, points: Array, T_base_camera: Array, bed: Plane,
                 obstacle: Mask, config: CrossSectionConfig) -> Sections:
    """Lines across the path on the bed, and what the image shows along them."""
    foot = bed.project(points)
    direction = smoothed_tangents(foot, config.tangent_length)
    lateral = np.cross(bed.normal, direction)
    T_camera_base = invert(T_base_camera)
    distance = float(np.median(transform(T_camera_base, foot)[:, 2]))
    pixel = distance / capture.camera.focal_length
    count = int(np.ceil(config.reach / (STEP * pixel)))
    offset = np.linspace(-count, count, 2 * count + 1) * (STEP * pixel)
    places = foot[:, None] + offset[:, None] * lateral[:, None]
    uv = capture.camera.pixels(transform(T_camera_base, places.reshape(-1, 3)))
    inside = np.isfinite(uv.sum(axis=1)) & capture.camera.contains(uv)
    column, row = np.rint(np.where(inside[:, None], uv, 0.0)).astype(np.intp).T
    visible = inside & (near(obstacle, 1)[row, column] == 0)
    shape = (len(points), len(offset))
    uv = uv.reshape(*shape, 2)
    return Sections(foot, lateral, offset, pixel, uv, visible.reshape(shape),
                    sample_image(capture.image, uv))


def sample_image(image: NDArray[np.uint8], uv: Array) -> Floats:
    """RGB (N, M, 3) between pixels of an image (H, W, 3) at uv (N, M, 2), bilinear."""
    u, v = (uv[..., axis].astype(np.float32) for axis in (0, 1))
    blocks = np.array_split(np.arange(len(uv)), 1 + len(uv) // 30000)  # OpenCV's largest side
    floating = image.astype(np.float32)
    return np.concatenate([
        np.asarray(cv2.remap(floating, u[block], v[block], cv2.INTER_LINEAR,
                             borderMode=cv2.BORDER_REPLICATE), np.float32)
        for block in blocks if len(block)])


def smoothed_tangents(foot: Array, length: float) -> Array:
    """Unit tangents (N, 3) over about ``length`` [m] of the path (N, 3) around each point."""
    spacing = float(np.median(np.linalg.norm(np.diff(foot, axis=0), axis=1)))
    reach = int(np.clip(round(length / 2 / max(spacing, 1e-9)), 1, max(len(foot) - 1, 1)))
    index = np.arange(len(foot))
    ahead, behind = np.minimum(index + reach, len(foot) - 1), np.maximum(index - reach, 0)
    # As far back as ahead near the ends as well, but where there is only one side.
    reach_here = np.minimum(ahead - index, index - behind)
    both = reach_here > 0
    ahead = np.where(both, index + reach_here, ahead)
    behind = np.where(both, index - reach_here, behind)
    step = foot[ahead] - foot[behind]
    return step / np.linalg.norm(step, axis=1, keepdims=True)


def ink_share(sections: Sections) -> tuple[Array, float]:
    """How much of each sample (N, M) is ink, 0 = bed to 1 = ink, and its noise (1 sigma).

    The colours of ink and bed are told from the image: ink is what lies along the path, bed what
    lies beside it. Both may change along the path, as the light does.
    """
    ink_colour, bed_colour, spread = two_colours(sections)
    direction = np.linalg.solve(spread, ink_colour - bed_colour)
    direction /= direction @ (ink_colour - bed_colour)
    share = (sections.colour - bed_colour) @ direction
    share[~sections.visible] = np.nan
    for _ in range(2):
        bed = _along(share, (share < 0.25) & ~_grown(share > 0.4, 4), sections, 0.0)
        full = _along(share, (share > 0.75) & ~_grown(share < 0.6, 4), sections, 1.0)
        share = (share - bed[:, None]) / np.maximum(full - bed, 0.2)[:, None]
    plain = share[(share < 0.25) & ~_grown(share > 0.4, 4)]
    noise = 1.4826 * float(np.median(np.abs(plain))) if len(plain) else np.inf
    return share, noise


def two_colours(sections: Sections) -> tuple[Array, Array, Array]:
    """Mean colours (3,) of ink and bed, and the covariance (3, 3) around them."""
    near_path = np.abs(sections.offset) <= 2 * sections.pixel
    colours = sections.colour[sections.visible].astype(np.float64)
    central = sections.colour[:, near_path][sections.visible[:, near_path]].astype(np.float64)
    ink = np.median(central, axis=0)
    distance = np.linalg.norm(colours - ink, axis=1)
    bed = np.median(colours[distance >= np.percentile(distance, 90) / 2], axis=0)
    for _ in range(6):
        is_ink = (np.linalg.norm(colours - ink, axis=1) < np.linalg.norm(colours - bed, axis=1))
        if is_ink.all() or not is_ink.any():
            break
        ink, bed = np.median(colours[is_ink], axis=0), np.median(colours[~is_ink], axis=0)
    on_path = np.linalg.norm(central - ink, axis=1) < np.linalg.norm(central - bed, axis=1)
    if on_path.mean() < is_ink.mean():  # what prevails along the path is the ink
        ink, bed, is_ink = bed, ink, ~is_ink
    spread = np.eye(3)
    for mean, members in ((ink, colours[is_ink]), (bed, colours[~is_ink])):
        around = members - mean
        size = np.linalg.norm(around, axis=1)
        core = around[size <= np.median(size)] if len(size) else around
        if len(core) > 3:
            spread += core.T @ core / len(core)
    return ink, bed, spread


def outward_edge(sections: Sections, ink: Array, level: Array, noise: float,
                 towards_left: bool) -> tuple[Array, Array]:
    """Distance (N,) from the path to the first edge on one side [m], and its sigma; NaN = none."""
    middle = len(sections.offset) // 2
    outward = ink[:, middle:] if towards_left else ink[:, middle::-1]
    run = round(SETTLED / STEP)
    below = outward < level[:, None]  # False where hidden
    settled = np.cumsum(below, axis=1)[:, run - 1:]
    settled = settled - np.concatenate(
        (np.zeros((len(settled), 1), int), np.cumsum(below, axis=1)[:, :-run]), axis=1) == run
    first = np.argmax(settled, axis=1)
    known = settled.any(axis=1) & (first > 0)
    row, first = np.arange(len(first)), np.maximum(first, 1)
    inner, outer = outward[row, first - 1], outward[row, first]
    slope = inner - outer
    known &= (inner >= level) & (slope > 0)
    share = np.where(known, (inner - level) / np.where(known, slope, 1.0), np.nan)
    step = STEP * sections.pixel
    return (first - 1 + share) * step, noise * step / np.where(known, slope, np.nan)


def _along(share: Array, chosen: Mask2, sections: Sections, default: float) -> Array:
    """Median (N,) of the chosen samples of each section, smoothed along the path."""
    count = chosen.sum(axis=1)
    values = np.where(chosen, share, np.nan)
    known = np.flatnonzero(count >= 3)
    if len(known) == 0:
        return np.full(len(share), default)
    each = np.interp(np.arange(len(share)), known, np.nanmedian(values[known], axis=1))
    steps = np.linalg.norm(np.diff(sections.foot, axis=0), axis=1)
    width = 2 * round(0.003 / max(float(np.median(steps)), 1e-6)) + 1
    return np.asarray(median_filter(each, size=min(width, len(each)), mode='nearest'))


def _grown(mask: Mask2, reach: int) -> Mask2:
    """The mask grown along each section by ``reach`` samples either way."""
    kernel = np.ones((1, 2 * reach + 1), np.uint8)
    return np.asarray(cv2.dilate(mask.astype(np.uint8), kernel)) > 0
