"""Lines on the surface across the path, and what camera and cloud show along them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bpc_perception.core.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Array, invert, Plane, transform
from bpc_perception.core.territory import find_territory

Floats = NDArray[np.float32]
Flags = NDArray[np.bool_]
Index = NDArray[np.intp]

STEP = 0.5  # between samples of a section [pixels]
COARSE = 4  # what varies slowly across is looked at in every so manieth sample
TYPICAL = 1000  # points of a path tell what is typical of it
KNOT = 8  # and projected to the image in every so manieth
ASKED = 10  # sections within a window that tell what is steady there
NOZZLE_ASKED = 4  # the height of the nozzle only at every so manieth of them
SHORT = 19  # a window for which sorting is quicker than a filter [values]
LARGEST_SIDE = 30000  # of an image made by OpenCV [pixels]
RAISED = 0.0004  # what stands this far above the bed is no bed [m]
WINDOW = 0.008  # length of path over which surface and light are taken as steady [m]


@dataclass(frozen=True)
class Sections:
    """Lines across N path points, M samples each, from right to left of the direction of travel.

    Attributes:
        index: (N,) of the path points.
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

    index: Index
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

    def every(self, step: int) -> Sections:
        """Only every so manieth of the sections."""
        chosen = slice(None, None, step)
        return Sections(
            self.index[chosen], self.foot[chosen], self.lateral[chosen], self.lean[chosen],
            self.offset, self.pixel, self.spacing * step, self.inside[chosen],
            self.hidden[chosen], self.depth[chosen], self.raised[chosen], self.beside[chosen],
            self.clearance[:, chosen], self.foreign[chosen], self.colour[chosen])

    @property
    def visible(self) -> Flags:
        """Where (N, M) the surface is seen."""
        return self.inside & ~self.hidden

    def steady(self, values: Array) -> Array:
        """Running median (N, ...) along the path of values (N, ...) with NaN = unknown.

        Unknown stretches take what is known nearest by; all NaN where nothing is.
        """
        return running_median(values, 2 * round(WINDOW / 2 / self.spacing) + 1)


def lay_sections(capture: Capture, points: Array, index: Index, T_base_camera: Array,
                 bed: Plane, config: ThicknessConfig) -> Sections:
    """Lines across the path (P, 3) at points of an index (N,), following the bending surface."""
    T_camera_base = invert(T_base_camera)
    tangent = smoothed_tangents(points, index, config.cross_section.tangent_length)
    lateral = _unit(np.cross(bed.normal, tangent))
    spacing = typical_spacing(points)
    pixel = pixel_size(capture, points, T_base_camera)
    count = int(np.ceil(config.cross_section.reach / (STEP * pixel)))
    offset = np.linspace(-count, count, 2 * count + 1) * (STEP * pixel)
    territory = find_territory(bed.coordinates(points), index, bed.coordinates(lateral),
                               offset[::COARSE], spacing)
    foot, lateral = _follow_surface(capture, points[index], lateral, offset[::COARSE], spacing,
                                    territory.beside, T_base_camera, bed.normal, config)

    uv = project(capture, foot, lateral, offset, T_camera_base)
    height = _heights(_look_up(capture.cloud, uv), foot, bed.normal, T_camera_base)
    margin = 2 * round(config.obstacle_margin / STEP) + 1
    along = 2 * round(config.obstacle_margin * pixel / spacing) + 1
    high = (height > config.obstacle_height).view(np.uint8)
    hidden = cv2.dilate(high, np.ones((along, margin), np.uint8))
    known = np.isfinite(height)
    central = np.abs(offset) <= pixel
    ridge = running_median(masked_median(height[:, central], known[:, central]),
                           2 * round(WINDOW / 2 / spacing) + 1)
    to_camera = T_base_camera[:3, 3] - foot
    lean = -ridge * np.einsum('nk,nk->n', to_camera, tangent) / (to_camera @ bed.normal)
    return Sections(
        index, foot, lateral, np.where(np.isfinite(lean), lean, 0.0), offset, pixel, spacing,
        capture.camera.contains(np.moveaxis(uv, 0, -1)), np.asarray(hidden).view(bool),
        np.count_nonzero(known, axis=1) > 0.1 * len(offset),
        _raised(height, offset, pixel, territory.beside), _fine(territory.beside, offset),
        territory.clearance, _fine(territory.foreign, offset), sample_image(capture.image, uv))


def pixel_size(capture: Capture, points: Array, T_base_camera: Array) -> float:
    """Length of a pixel's side about where the path (N, 3) is [m]."""
    some = points[::1 + len(points) // TYPICAL]
    distance = float(np.median(transform(invert(T_base_camera), some)[:, 2]))
    return distance / capture.camera.focal_length


def step_within_window(spacing: float) -> int:
    """From one path point to the next that is asked of what is steady within a window."""
    return max(1, round(WINDOW / ASKED / spacing))


def sample_image(image: NDArray[np.uint8], uv: Floats) -> Floats:
    """RGB (N, M, 3) between the pixels of an image (H, W, 3), bilinear at uv (2, N, M)."""
    # What lies outside shows the image's border, so that has to be cut out with the rest.
    last = np.array(image.shape[1::-1]) - 1
    u0, v0 = np.clip(np.nan_to_num(np.fmin.reduce(uv, axis=(1, 2))), 0, last).astype(int)
    u1, v1 = np.clip(np.nan_to_num(np.fmax.reduce(uv, axis=(1, 2))), 0, last).astype(int)
    region = image[v0:v1 + 2, u0:u1 + 2].astype(np.float32)
    return _remap(region, uv - np.array((u0, v0), np.float32)[:, None, None], cv2.INTER_LINEAR,
                  cv2.BORDER_REPLICATE)


def smoothed_tangents(points: Array, index: Index, length: float) -> Array:
    """Unit tangents (N, 3) over a ``length`` [m] of the path (P, 3) around points (N,) of it."""
    spacing = typical_spacing(points)
    reach = int(np.clip(round(length / 2 / spacing), 1, max((len(points) - 1) // 2, 1)))
    # Which way it went across a hole, where poses are missing or the nozzle was lifted, is not
    # known: each piece between holes has directions of its own.
    away = np.linalg.norm(np.diff(points, axis=0), axis=1)
    holes = np.flatnonzero(away > max(length, 2 * spacing))
    piece = np.searchsorted(holes, index)
    first, last = np.append(0, holes + 1)[piece], np.append(holes, len(points) - 1)[piece]
    # As far back as ahead, so that a bend does not turn the tangent.
    near = np.minimum(reach, np.minimum(index - first, last - index))
    step = points[index + near] - points[index - near]
    # At the ends a parabola takes the place of the missing side.
    for ends, way in ((index == last, -1), (index == first, 1)):
        here, room = index[ends], (last - first)[ends]
        by = np.clip(room // 2, 1, reach)
        one, two = (points[here + way * np.minimum(far, room)] for far in (by, 2 * by))
        step[ends] = way * (4 * one - 3 * points[here] - two)
    # Where the path turns back on itself, or stands, the direction next to that counts.
    moving = np.flatnonzero(np.linalg.norm(step, axis=1) > 0)
    if len(moving):
        after = np.minimum(np.searchsorted(moving, np.arange(len(index))), len(moving) - 1)
        step = step[moving[after]]
    return _unit(step)


def typical_spacing(points: Array) -> float:
    """Distance between neighbours of a path (N, 3) [m]; never quite nothing."""
    start = np.arange(0, len(points) - 1, 1 + len(points) // TYPICAL)
    return max(float(np.median(np.linalg.norm(points[start + 1] - points[start], axis=1))), 1e-6)


def masked_median(values: NDArray[np.floating[Any]], mask: Flags) -> Array:
    """Median (N, ...) over the second axis of values (N, M, ...) where mask (N, M); NaN = none."""
    # What is compared lies side by side in memory, which sorting needs to be fast.
    ordered = np.moveaxis(values, 1, -1).copy()
    shown = mask.reshape(len(mask), *(1,) * (values.ndim - 2), -1)
    np.copyto(ordered, np.inf, where=~shown)
    ordered.sort(axis=-1)
    count = np.count_nonzero(mask, axis=1)
    low, high = np.maximum(count - 1, 0) // 2, np.minimum(count // 2, values.shape[1] - 1)
    row = np.arange(len(values))
    middle = (ordered[row, ..., low] + ordered[row, ..., high]) / 2
    middle[count == 0] = np.nan
    return np.asarray(middle, np.float64)


def running_median(values: Array, window: int) -> Array:
    """Median of values (N, ...) over ``window`` neighbours; NaN takes the nearest known value."""
    columns = values.reshape(len(values), -1)
    result = np.empty_like(columns)
    index = np.arange(len(values))
    window = min(window, len(values))
    for number, column in enumerate(columns.T):
        known = np.flatnonzero(np.isfinite(column))
        if len(known) == 0:
            result[:, number] = np.nan
            continue
        filled = column if len(known) == len(column) else np.interp(index, known, column[known])
        result[:, number] = _filtered(filled, window)
    return result.reshape(values.shape)


def _filtered(values: Array, window: int) -> Array:
    """Running median of values (N,); the first and the last go on beyond the ends."""
    if window % 2 == 0 or window > SHORT:
        return np.asarray(median_filter(values, size=window, mode='nearest'))
    half = window // 2
    padded = np.concatenate((np.full(half, values[0]), values, np.full(half, values[-1])))
    windows = sliding_window_view(padded, window)
    return np.asarray(np.partition(windows, half, axis=1)[:, half])


def _follow_surface(capture: Capture, points: Array, lateral: Array, offset: Array,
                    spacing: float, beside: Flags, T_base_camera: Array, normal: Array,
                    config: ThicknessConfig) -> tuple[Array, Array]:
    """Feet (N, 3) of path points (N, 3) on the surface, and laterals (N, 3) turned to follow it.

    From what the cloud shows of the bed at some ``offset`` (M,), where ``beside`` (N, M). The
    surface bends slowly: not every section is asked.
    """
    T_camera_base = invert(T_base_camera)
    chosen = np.arange(0, len(points), 2 * step_within_window(spacing))
    foot, across, bare = points[chosen], lateral[chosen], beside[chosen]

    def cloud(some: slice) -> Floats:
        return _look_up(capture.cloud,
                        project(capture, foot[some], across[some], offset, T_camera_base))

    # The nozzle keeps about the same height above the surface all along.
    few = slice(None, None, NOZZLE_ASKED)
    height = _heights(cloud(few), foot[few], normal, T_camera_base)
    gap = height[bare[few] & np.isfinite(height)]
    nozzle = float(np.median(gap)) if len(gap) else 0.0
    foot = foot + nozzle * normal
    shown = cloud(slice(None))
    height = _heights(shown, foot, normal, T_camera_base)
    place = _places(shown, foot, across, T_camera_base)
    side_height, side_place = [], []
    for side in (place < 0, place > 0):
        mask = side & bare & (np.abs(height) < config.obstacle_height)
        side_height.append(masked_median(height, mask))
        side_place.append(masked_median(place, mask))
    window = 2 * round(WINDOW / 2 / (spacing * (chosen[1] if len(chosen) > 1 else 1))) + 1
    right, left = (running_median(value, window) for value in side_height)
    width = side_place[1] - side_place[0]
    slope = running_median((left - right) / width, window)
    slope = np.where(np.isfinite(slope), slope, 0.0)
    right, left = right - slope * side_place[0], left - slope * side_place[1]
    level = running_median(np.where(np.isfinite(right + left), (right + left) / 2,
                                    np.where(np.isfinite(right), right, left)), window)
    level = nozzle + np.where(np.isfinite(level), level, 0.0)
    level, slope = (np.interp(np.arange(len(points)), chosen, values)
                    for values in (level, slope))
    return points + level[:, None] * normal, _unit(lateral + slope[:, None] * normal)


def project(capture: Capture, foot: Array, lateral: Array, offset: Array,
            T_camera_base: Array) -> Floats:
    """Pixels (2, N, M) of the samples of sections; straight between every eighth of them."""
    origin, direction = transform(T_camera_base, foot), lateral @ T_camera_base[:3, :3].T
    knots = offset[0] + np.arange(len(offset) // KNOT + 2) * KNOT * (offset[1] - offset[0])
    uv = capture.camera.pixels(origin[:, None] + knots[:, None] * direction[:, None])
    start = np.moveaxis(uv, -1, 0).astype(np.float32)[..., None]
    share = np.arange(KNOT, dtype=np.float32) / KNOT
    between = start[:, :, :-1] + share * np.diff(start, axis=2)
    return np.ascontiguousarray(between.reshape(2, len(foot), -1)[..., :len(offset)])


def _look_up(cloud: Floats, uv: Floats) -> Floats:
    """Points (N, M, 3) of a cloud (H, W, 3) at the nearest of pixels uv (2, N, M); NaN = none."""
    return _remap(cloud, uv, cv2.INTER_NEAREST, cv2.BORDER_CONSTANT)


def _remap(values: Floats, uv: Floats, interpolation: int, border: int) -> Floats:
    """Values (N, M, 3) of an image (H, W, 3) at pixels uv (2, N, M)."""
    rows = uv.shape[1]
    blocks = [slice(start, start + LARGEST_SIDE) for start in range(0, rows, LARGEST_SIDE)]
    return np.concatenate([
        np.asarray(cv2.remap(values, uv[0, block], uv[1, block], interpolation,
                             borderMode=border, borderValue=(np.nan,) * 3), np.float32)
        for block in blocks])


def _heights(cloud: Floats, foot: Array, normal: Array, T_camera_base: Array) -> Floats:
    """Height (N, M) of points (N, M, 3) of the camera frame above sections' feet (N, 3) [m]."""
    axis = T_camera_base[:3, :3] @ normal
    below = (transform(T_camera_base, foot) @ axis).astype(np.float32)
    return np.asarray(cv2.transform(cloud, axis[None]), np.float32) - below[:, None]


def _places(cloud: Floats, foot: Array, lateral: Array, T_camera_base: Array) -> Floats:
    """How far along their sections (N, M) points (N, M, 3) of the camera frame lie [m]."""
    from_foot = cloud - transform(T_camera_base, foot)[:, None].astype(np.float32)
    across = (lateral @ T_camera_base[:3, :3].T).astype(np.float32)
    return np.asarray(np.matmul(from_foot, across[:, :, None])[..., 0], np.float32)


def _raised(height: Floats, offset: Array, pixel: float, beside: Flags) -> Flags:
    """Where (N,) the middle of a section stands above the bed by more than noise explains."""
    coarse = height[:, ::COARSE]
    at_bed = coarse[beside & np.isfinite(coarse)]
    noise = 1.4826 * float(np.median(np.abs(at_bed - np.median(at_bed)))) if len(at_bed) else 0.0
    middle = height[:, np.abs(offset) <= 2 * pixel]
    return masked_median(middle, np.isfinite(middle)) > max(RAISED, 4 * noise)


def _fine(flags: Flags, offset: Array) -> Flags:
    """Flags (N, M) at every offset from those at every COARSE-th."""
    return np.repeat(flags, COARSE, axis=1)[:, :len(offset)]


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, np.nan)
