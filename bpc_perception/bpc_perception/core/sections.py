"""Lines on the surface across the path, and what camera and cloud show along them."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.spatial import cKDTree

from bpc_perception.core.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Array, invert, Plane, transform

Floats = NDArray[np.float32]
Flags = NDArray[np.bool_]

STEP = 0.5  # between samples of a section [pixels]
RAISED = 0.0004  # what stands this far above the bed is no bed [m]
WINDOW = 0.008  # length of path over which surface and light are taken as steady [m]


@dataclass(frozen=True)
class Sections:
    """Lines across N path points, M samples each, from right to left of the direction of travel.

    Attributes:
        foot: (N, 3) points of the surface below the nozzle tip [m].
        lateral: (N, 3) unit vectors along the surface to the left.
        lean: (N,) how far a bead's ridge seems to be shifted along the path, seen from where
            the camera stands, positive forward [m]; 0 where its height is not known.
        offset: (M,) distances from the path, positive to the left [m].
        pixel: length of a pixel's side on the surface [m].
        spacing: between path points [m].
        inside: (N, M) whether a sample lies in the image.
        hidden: (N, M) whether something stands in front of it.
        depth: (N,) whether the cloud knows the surface there.
        raised: (N,) whether the cloud has something there that stands above the bed.
        beside: (N, M) whether it lies so far from all of the path that bed is to be expected.
        clearance: (2, N) how far that is from the path, on the right and the left [m].
        foreign: (N, M) whether another pass of the path is nearer than this one.
        colour: (N, M, 3) RGB.
    """

    foot: Array
    lateral: Array
    lean: Array
    offset: Array
    pixel: float
    spacing: float
    inside: Flags
    hidden: Flags
    depth: Flags
    raised: Flags
    beside: Flags
    clearance: Array
    foreign: Flags
    colour: Floats

    @property
    def visible(self) -> Flags:
        """Where (N, M) the surface is seen."""
        return self.inside & ~self.hidden

    def steady(self, values: Array) -> Array:
        """Running median (N, ...) along the path of values (N, ...) with NaN = unknown.

        Unknown stretches take what is known nearest by; all NaN where nothing is.
        """
        return running_median(values, 2 * round(WINDOW / 2 / self.spacing) + 1)


def lay_sections(capture: Capture, points: Array, T_base_camera: Array, bed: Plane,
                 config: ThicknessConfig) -> Sections:
    """Lines across path points (N, 3), following the surface where it bends."""
    T_camera_base = invert(T_base_camera)
    normal = bed.normal
    tangent = smoothed_tangents(points, config.cross_section.tangent_length)
    lateral = _unit(np.cross(normal, tangent))
    spacing = typical_spacing(points)
    distance = float(np.median(transform(T_camera_base, points)[:, 2]))
    pixel = distance / capture.camera.focal_length
    count = int(np.ceil(config.cross_section.reach / (STEP * pixel)))
    offset = np.linspace(-count, count, 2 * count + 1) * (STEP * pixel)
    beside, clearance, foreign = _territory(points, lateral, offset, spacing)

    # The nozzle keeps about the same height above the surface all along.
    coarse = slice(None, None, 4)
    height, _ = _heights(capture, points, lateral, offset[coarse], normal, T_base_camera)
    gap = np.where(beside[:, coarse], height, np.nan)
    foot = points + np.nanmedian(gap) * normal if np.isfinite(gap).any() else points
    height, place = _heights(capture, foot, lateral, offset[coarse], normal, T_base_camera)
    side_height, side_place = [], []
    for chosen in (place < 0, place > 0):
        mask = chosen & beside[:, coarse] & (np.abs(height) < config.obstacle_height)
        side_height.append(masked_median(height, mask))
        side_place.append(masked_median(place, mask))
    window = 2 * round(WINDOW / 2 / spacing) + 1
    right, left = (running_median(value, window) for value in side_height)
    width = side_place[1] - side_place[0]
    slope = running_median((left - right) / width, window)
    slope = np.where(np.isfinite(slope), slope, 0.0)
    right, left = right - slope * side_place[0], left - slope * side_place[1]
    level = running_median(np.where(np.isfinite(right + left), (right + left) / 2,
                                    np.where(np.isfinite(right), right, left)), window)
    foot = foot + np.where(np.isfinite(level), level, 0.0)[:, None] * normal
    lateral = _unit(lateral + slope[:, None] * normal)

    uv = _pixels(capture, foot, lateral, offset, T_camera_base)
    height, _ = _heights(capture, foot, lateral, offset, normal, T_base_camera)
    margin = 2 * round(config.obstacle_margin / STEP) + 1
    along = 2 * round(config.obstacle_margin * pixel / spacing) + 1
    high = (height > config.obstacle_height).astype(np.uint8)
    hidden = cv2.dilate(high, np.ones((along, margin), np.uint8)) > 0
    ridge = running_median(masked_median(height, (np.abs(offset) <= pixel) & np.isfinite(height)),
                           window)
    to_camera = T_base_camera[:3, 3] - foot
    lean = -ridge * np.einsum('nk,nk->n', to_camera, tangent) / (to_camera @ normal)
    return Sections(
        foot, lateral, np.where(np.isfinite(lean), lean, 0.0), offset, pixel, spacing,
        capture.camera.contains(uv), np.asarray(hidden), np.isfinite(height).mean(axis=1) > 0.1,
        _raised(height, offset, pixel, beside), beside, clearance, foreign,
        sample_image(capture.image, uv))


def sample_image(image: NDArray[np.uint8], uv: Array) -> Floats:
    """RGB (N, M, 3) between the pixels of an image (H, W, 3), bilinear at uv (N, M, 2)."""
    u, v = (uv[..., axis].astype(np.float32) for axis in (0, 1))
    floating = image.astype(np.float32)
    blocks = np.array_split(np.arange(len(uv)), 1 + len(uv) // 30000)  # OpenCV's largest side
    return np.concatenate([
        np.asarray(cv2.remap(floating, u[block], v[block], cv2.INTER_LINEAR,
                             borderMode=cv2.BORDER_REPLICATE), np.float32)
        for block in blocks if len(block)])


def smoothed_tangents(points: Array, length: float) -> Array:
    """Unit tangents (N, 3) over about ``length`` [m] of the path (N, 3) around each point."""
    spacing = typical_spacing(points)
    reach = int(np.clip(round(length / 2 / spacing), 1, max((len(points) - 1) // 2, 1)))
    last = len(points) - 1
    index = np.arange(len(points))
    # As far back as ahead, so that a bend does not turn the tangent.
    near = np.minimum(reach, np.minimum(index, last - index))
    step = points[index + near] - points[index - near]
    if len(points) >= 3:  # at the ends a parabola takes the place of the missing side
        step[0] = 4 * points[reach] - 3 * points[0] - points[min(2 * reach, last)]
        step[-1] = 3 * points[-1] - 4 * points[last - reach] + points[max(last - 2 * reach, 0)]
    else:
        step[:] = points[-1] - points[0]
    # Where the path turns back on itself, or stands, the direction next to that counts.
    moving = np.flatnonzero(np.linalg.norm(step, axis=1) > 0)
    if len(moving):
        after = np.minimum(np.searchsorted(moving, index), len(moving) - 1)
        step = step[moving[after]]
    return _unit(step)


def typical_spacing(points: Array) -> float:
    """Distance between neighbours of a path (N, 3) [m]; never quite nothing."""
    return max(float(np.median(np.linalg.norm(np.diff(points, axis=0), axis=1))), 1e-6)


def masked_median(values: Array, mask: Flags) -> Array:
    """Median (N, ...) over the second axis of values (N, M, ...) where mask (N, M); NaN = none."""
    shown = mask.reshape(*mask.shape, *(1,) * (values.ndim - 2))
    ordered = np.sort(np.where(shown, values, np.inf), axis=1)
    count = mask.sum(axis=1)
    low, high = np.maximum(count - 1, 0) // 2, count // 2
    row = np.arange(len(values))
    middle = (ordered[row, low] + ordered[row, np.minimum(high, values.shape[1] - 1)]) / 2
    middle[count == 0] = np.nan
    return np.asarray(middle, np.float64)


def running_median(values: Array, window: int) -> Array:
    """Median of values (N, ...) over ``window`` neighbours; NaN takes the nearest known value."""
    columns = values.reshape(len(values), -1)
    result = np.empty_like(columns)
    index = np.arange(len(values))
    for number, column in enumerate(columns.T):
        known = np.flatnonzero(np.isfinite(column))
        if len(known) == 0:
            result[:, number] = np.nan
            continue
        filled = np.interp(index, known, column[known])
        result[:, number] = median_filter(filled, size=min(window, len(filled)), mode='nearest')
    return result.reshape(values.shape)


def _pixels(capture: Capture, foot: Array, lateral: Array, offset: Array,
            T_camera_base: Array) -> Array:
    """Pixels (N, M, 2) of the samples of sections."""
    origin, direction = transform(T_camera_base, foot), lateral @ T_camera_base[:3, :3].T
    return capture.camera.pixels(origin[:, None] + offset[:, None] * direction[:, None])


def _heights(capture: Capture, foot: Array, lateral: Array, offset: Array, normal: Array,
             T_base_camera: Array) -> tuple[Array, Array]:
    """Height above the section and place along it (N, M) of the cloud at its samples [m]."""
    T_camera_base = invert(T_base_camera)
    uv = _pixels(capture, foot, lateral, offset, T_camera_base)
    inside = capture.camera.contains(uv)
    u, v = np.moveaxis(np.rint(np.where(inside[..., None], uv, 0.0)).astype(np.intp), -1, 0)
    cloud = capture.cloud[v, u]
    rotation = T_camera_base[:3, :3]
    from_foot = cloud - transform(T_camera_base, foot)[:, None].astype(np.float32)
    height = from_foot @ (rotation @ normal).astype(np.float32)
    place = np.einsum('nmk,nk->nm', from_foot, (lateral @ rotation.T).astype(np.float32))
    height[~inside], place[~inside] = np.nan, np.nan
    return height.astype(np.float64), place.astype(np.float64)


def _raised(height: Array, offset: Array, pixel: float, beside: Flags) -> Flags:
    """Where (N,) the middle of a section stands above the bed by more than noise explains."""
    at_bed = height[beside & np.isfinite(height)]
    noise = 1.4826 * float(np.median(np.abs(at_bed - np.median(at_bed)))) if len(at_bed) else 0.0
    central = (np.abs(offset) <= 2 * pixel) & np.isfinite(height)
    return masked_median(height, central) > max(RAISED, 4 * noise)


def _territory(points: Array, lateral: Array, offset: Array,
               spacing: float) -> tuple[Flags, Array, Flags]:
    """What the path alone says of the samples; see Sections: beside, clearance, foreign."""
    coarse = offset[::4]
    places = points[:, None] + coarse[:, None] * lateral[:, None]
    thinned = np.arange(0, len(points), 2)
    distance, nearest = cKDTree(points[thinned]).query(places.reshape(-1, 3))
    shape = len(points), len(coarse)
    distance = distance.reshape(shape)
    along = np.abs(thinned[nearest].reshape(shape) - np.arange(len(points))[:, None]) * spacing
    # The foot of a place on its own pass is near in arc length, even within a bend.
    foreign = (along > np.pi * np.abs(coarse) + 4 * spacing) & (
        distance < np.abs(coarse) - spacing)
    beside = np.zeros(shape, bool)
    clearance = []
    for side in (coarse < 0, coarse > 0):
        clearance.append(distance[:, side].max(axis=1))
        # Close to other strands only half-way to them; in the open more of the bed, lest
        # something that lies there be taken for it.
        openness = clearance[-1] / offset[-1]
        nearest_bed = clearance[-1] * (0.85 - 0.35 * openness**2)
        beside[:, side] = distance[:, side] >= nearest_bed[:, None]

    def fine(flags: Flags) -> Flags:
        return np.repeat(flags, 4, axis=1)[:, :len(offset)]

    return fine(beside), np.stack(clearance), fine(foreign)


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, np.nan)
