"""What camera and cloud show along straight lines across the path."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.capture.colour_space import LIGHT, LINEAR
from bpc_perception.core.geometry import transform
from bpc_perception.core.measurement.view import View

KNOT_STEP = 8  # every n-th sample is projected; between them the line is straight in the image
LONGEST_SIDE_PX = 30_000  # of an image that OpenCV can make


@dataclass(frozen=True)
class Lines:
    """N lines, each with M samples.

    Attributes:
        foot: (N, 3) where each meets the path, in the base frame [m].
        lateral: (N, 3) unit vectors along them, to the left of the direction of travel.
        offset: (M,) distances of the samples from the feet, positive left, evenly spaced [m].
    """

    foot: Array
    lateral: Array
    offset: Array

    def of(self, index: Index) -> Lines:
        """Return the lines of an index (K,)."""
        return Lines(self.foot[index], self.lateral[index], self.offset)


def pixels_along(view: View, lines: Lines) -> Floats:
    """Return the pixels (2, N, M) of the samples of lines; NaN = not in front of the camera."""
    origin = transform(view.T_camera_base, lines.foot)
    direction = lines.lateral @ view.T_camera_base[:3, :3].T
    count, step = len(lines.offset), lines.offset[1] - lines.offset[0]
    knots = lines.offset[0] + np.arange(count // KNOT_STEP + 2) * KNOT_STEP * step
    points = np.stack([start[:, None] + knots * towards[:, None]
                       for start, towards in zip(origin.T, direction.T, strict=True)], axis=-1)
    start = np.moveaxis(view.capture.camera.pixels(points), -1, 0).astype(np.float32)
    start, onward = start[..., :-1], np.diff(start, axis=2)
    between = np.empty((*onward.shape, KNOT_STEP), np.float32)
    for number in range(KNOT_STEP):
        between[..., number] = start + np.float32(number / KNOT_STEP) * onward
    return between.reshape(2, len(lines.foot), -1)[..., :count]


def colours_at(view: View, uv: Floats) -> Floats:
    """Return RGB (N, M, 3) of the image at pixels (2, N, M), bilinear between its own.

    It is in proportion to the light, up to 255. What lies outside the image gets the colour of its
    border.
    """
    image = view.capture.image
    # Only the part of the image that the pixels are in is made floating point.
    last = np.array(image.shape[1::-1]) - 1
    u0, v0 = np.clip(np.nan_to_num(np.fmin.reduce(uv, axis=(1, 2))), 0, last).astype(int)
    u1, v1 = np.clip(np.nan_to_num(np.fmax.reduce(uv, axis=(1, 2))), 0, last).astype(int)
    levels = image[v0:v1 + 2, u0:u1 + 2]
    region = (levels.astype(np.float32) if view.colour_space == LINEAR
              else np.asarray(cv2.LUT(levels, LIGHT[view.colour_space]), np.float32))
    return _remap(region, uv - np.array((u0, v0), np.float32)[:, None, None], cv2.INTER_LINEAR,
                  cv2.BORDER_REPLICATE)


def points_at(cloud: Floats, uv: Floats) -> Floats:
    """Return points (N, M, 3) of a cloud (H, W, 3) at the nearest pixels (2, N, M); NaN = none."""
    if cloud.flags.c_contiguous:
        return _remap(cloud, uv, cv2.INTER_NEAREST, cv2.BORDER_CONSTANT)
    # Of a view into a message, with more than a point in each step, OpenCV would copy everything.
    nearest = np.rint(uv)
    inside: Flags = (nearest[0] >= 0) & (nearest[0] < cloud.shape[1]) & (
        nearest[1] >= 0) & (nearest[1] < cloud.shape[0])
    column, row = np.where(inside, nearest, 0).astype(np.intp)
    points = cloud if cloud.strides[2] == cloud.itemsize else np.ascontiguousarray(cloud)
    whole = points.view(np.dtype((np.void, 3 * cloud.itemsize)))[..., 0]  # each point as one item
    result: Floats = whole[row, column].view(cloud.dtype).reshape(*inside.shape, 3)
    result[~inside] = np.nan
    return result


def heights(view: View, points: Floats, lines: Lines, normal: Array) -> Floats:
    """Return how high (N, M) points (N, M, 3) of the camera's frame lie above the feet [m].

    That is along a normal (3,), or along one for each line (N, 3).
    """
    axis = normal @ view.T_camera_base[:3, :3].T
    foot = transform(view.T_camera_base, lines.foot)
    if axis.ndim == 1:
        below = (foot @ axis).astype(np.float32)
        return np.asarray(cv2.transform(points, axis[None]), np.float32) - below[:, None]
    above = less_each(points, foot)
    return np.asarray(np.matmul(above, axis.astype(np.float32)[:, :, None])[..., 0], np.float32)


def distances_along(view: View, points: Floats, lines: Lines) -> Floats:
    """Return how far along their lines (N, M) points (N, M, 3) of the camera's frame lie [m]."""
    from_foot = less_each(points, transform(view.T_camera_base, lines.foot))
    across = (lines.lateral @ view.T_camera_base[:3, :3].T).astype(np.float32)
    return np.asarray(np.matmul(from_foot, across[:, :, None])[..., 0], np.float32)


def less_each(values: Floats, origin: Array) -> Floats:
    """Return values (N, M, 3) less those (N, 3) of their rows.

    It is done column by column: NumPy is slow where its innermost loop takes three steps.
    """
    result = np.empty_like(values)
    for column, less in enumerate(origin.astype(np.float32).T):
        np.subtract(values[..., column], less[:, None], out=result[..., column])
    return result


def _remap(values: Floats, uv: Floats, interpolation: int, border: int) -> Floats:
    """Return values (N, M, 3) of an image (H, W, 3) at pixels (2, N, M)."""
    rows = uv.shape[1]
    blocks = [slice(start, start + LONGEST_SIDE_PX) for start in range(0, rows, LONGEST_SIDE_PX)]
    parts = [np.asarray(cv2.remap(values, uv[0, block], uv[1, block], interpolation,
                                  borderMode=border, borderValue=(np.nan,) * 3), np.float32)
             for block in blocks]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)
