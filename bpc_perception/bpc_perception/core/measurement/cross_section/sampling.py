"""Sections laid across the path, and what camera and cloud show along them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.filters import masked_median, running_median
from bpc_perception.core.geometry import invert, Plane, transform, unit_vectors
from bpc_perception.core.measurement.cross_section.passes import find_territory
from bpc_perception.core.measurement.cross_section.sections import Sections, STEP
from bpc_perception.core.measurement.scale import pixel_size, step_within_window, WINDOW
from bpc_perception.core.path.tangents import smoothed_tangents, typical_spacing

COARSE = 4  # what varies slowly across is looked at in every so manieth sample
KNOT = 8  # and projected to the image in every so manieth
NOZZLE_ASKED = 4  # the height of the nozzle only at every so manieth of them
LARGEST_SIDE = 30000  # of an image made by OpenCV [pixels]
RAISED = 0.0004  # what stands this far above the bed is no bed [m]


def lay_sections(capture: Capture, points: Array, index: Index, T_base_camera: Array,
                 bed: Plane, config: ThicknessConfig) -> Sections:
    """Lines across the path (P, 3) at points of an index (N,), following the bending surface."""
    T_camera_base = invert(T_base_camera)
    tangent = smoothed_tangents(points, index, config.cross_section.tangent_length)
    lateral = unit_vectors(np.cross(bed.normal, tangent))
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


def sample_image(image: NDArray[np.uint8], uv: Floats) -> Floats:
    """RGB (N, M, 3) between the pixels of an image (H, W, 3), bilinear at uv (2, N, M)."""
    # What lies outside shows the image's border, so that has to be cut out with the rest.
    last = np.array(image.shape[1::-1]) - 1
    u0, v0 = np.clip(np.nan_to_num(np.fmin.reduce(uv, axis=(1, 2))), 0, last).astype(int)
    u1, v1 = np.clip(np.nan_to_num(np.fmax.reduce(uv, axis=(1, 2))), 0, last).astype(int)
    region = image[v0:v1 + 2, u0:u1 + 2].astype(np.float32)
    return _remap(region, uv - np.array((u0, v0), np.float32)[:, None, None], cv2.INTER_LINEAR,
                  cv2.BORDER_REPLICATE)


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
    return points + level[:, None] * normal, unit_vectors(lateral + slope[:, None] * normal)


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
