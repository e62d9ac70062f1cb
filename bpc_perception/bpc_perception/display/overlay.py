"""The camera's image with what was measured drawn over it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.profile import Status
from bpc_perception.core.result import Result
from bpc_perception.display.layers import in_layer, NEWEST
from bpc_perception.display.legend import (
    as_shown,
    LEFT_COLOUR,
    rgb,
    RIGHT_COLOUR,
    STATUS_COLOURS,
    TARGET_COLOUR,
)
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.wording import advice_in_words, label

LEAST_WIDTH_PX = 900  # smaller images are enlarged
SUBPIXEL_BITS = 4  # OpenCV draws to 1/16 of a pixel
DOT_RADIUS_PX = 2
SCALE_BAR_LENGTHS_M = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
SCALE_BAR_SHARE = 0.2  # of the image's width, at most
FONT, FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.6
MARGIN_PX, LINE_HEIGHT_PX = 12, 22
PAPER_RGB = (255, 255, 255)


def draw_overlay(result: Result, layer: int = NEWEST) -> NDArray[np.uint8]:
    """Draw side points, statuses, words and a scale bar over the image of a measured capture.

    Args:
        result: of the capture.
        layer: which is shown.

    Returns:
        RGB (H, W, 3), enlarged by a whole number if the image is small.

    Raises:
        ValueError: nothing was measured in the capture.
    """
    profile = result.profile
    if profile is None or result.advice is None:
        raise ValueError(f'overlay: expected a measured capture, found: {result.refusal}')
    image = result.capture.image
    scale = max(1, -(-LEAST_WIDTH_PX // image.shape[1]))
    picture = np.ascontiguousarray(np.repeat(np.repeat(image, scale, axis=0), scale, axis=1))
    draw_samples(picture, result, layer)
    _draw_scale_bar(picture, result, scale)
    summary, shown = profile.summary, as_shown(profile).status[in_layer(profile, layer)]
    newest = int(profile.layer.max(initial=0))
    lines = [
        (f'capture {profile.capture}: {MM_PER_M * summary.thickness_mean:.3f} mm, '
         f'{summary.coverage:.0%} known', TARGET_COLOUR),
        (advice_in_words(result.advice), TARGET_COLOUR),
        *([(f'layer {newest if layer == NEWEST else layer}', TARGET_COLOUR)] if newest else []),
        ('left side', LEFT_COLOUR), ('right side', RIGHT_COLOUR),
        *((label(status), STATUS_COLOURS[status]) for status in Status
          if status != Status.MEASURED and (shown == status).any())]
    for number, (text, colour) in enumerate(lines, 1):
        _write(picture, text, (MARGIN_PX, LINE_HEIGHT_PX * number), colour)
    return picture


def draw_samples(picture: NDArray[np.uint8], result: Result, layer: int = NEWEST) -> None:
    """Draw what came of each sample of a layer into a picture of the capture.

    Args:
        picture: RGB (H, W, 3), a copy of the capture's image of any size; changed in place.
        result: of a measured capture.
        layer: which is shown.
    """
    profile = result.profile
    assert profile is not None
    profile, shown = as_shown(profile), in_layer(profile, layer)
    measured = shown & (profile.status == Status.MEASURED)
    for status in set(Status) - {Status.MEASURED}:
        _draw_dots(picture, result, profile.feet[shown & (profile.status == status)],
                   STATUS_COLOURS[status])
    _draw_dots(picture, result, profile.left_points[measured], LEFT_COLOUR)
    _draw_dots(picture, result, profile.right_points[measured], RIGHT_COLOUR)


def path_pixels(result: Result, points: Array) -> Array:
    """Return where points (N, 3) of the base frame [m] lie in the image.

    Returns:
        (N, 2) pixels; NaN = outside the image.
    """
    assert result.T_base_camera is not None
    camera = result.capture.camera
    uv = camera.pixels(transform(invert(result.T_base_camera), points))
    return np.where(camera.contains(uv)[:, None], uv, np.nan)


def pixel_size(result: Result) -> float:
    """Return the length of a pixel of the image in the middle of the path [m]."""
    assert result.profile is not None
    assert result.T_base_camera is not None
    depth = np.median(transform(invert(result.T_base_camera), result.profile.points)[:, 2])
    return float(depth) / result.capture.camera.focal_length


def scale_bar_length(longest: float) -> float:
    """Return the largest round length for a scale bar up to this length [m]; the least if none."""
    return max((length for length in SCALE_BAR_LENGTHS_M if length <= longest),
               default=SCALE_BAR_LENGTHS_M[0])


def _draw_dots(picture: NDArray[np.uint8], result: Result, points: Array, colour: str) -> None:
    """Draw the points (N, 3) that are in the image, one for each pixel."""
    scale = picture.shape[1] / result.capture.camera.width
    uv = (path_pixels(result, points) + 0.5) * scale - 0.5
    uv = uv[np.isfinite(uv).all(axis=1)]
    pixel_numbers = np.rint(uv) @ (1, picture.shape[1])
    first_of_each = np.unique(pixel_numbers, return_index=True)[1]
    for u, v in np.rint(uv[first_of_each] * 2**SUBPIXEL_BITS).astype(int).tolist():
        cv2.circle(picture, (u, v), DOT_RADIUS_PX << SUBPIXEL_BITS, rgb(colour), -1, cv2.LINE_AA,
                   SUBPIXEL_BITS)


def _draw_scale_bar(picture: NDArray[np.uint8], result: Result, scale: int) -> None:
    """Draw a length as it appears in the middle of the path, at the bottom of the picture."""
    pixel = pixel_size(result) / scale
    if not pixel > 0:  # the path is not in front of the camera
        return
    height, width = picture.shape[:2]
    length = scale_bar_length(SCALE_BAR_SHARE * width * pixel)
    bottom, right = height - MARGIN_PX, MARGIN_PX + round(length / pixel)
    cv2.rectangle(picture, (MARGIN_PX - 2, bottom - 3), (right + 2, bottom + 3), PAPER_RGB,
                  cv2.FILLED)
    cv2.rectangle(picture, (MARGIN_PX, bottom - 1), (right, bottom + 1), rgb(TARGET_COLOUR),
                  cv2.FILLED)
    _write(picture, f'{MM_PER_M * length:g} mm', (MARGIN_PX, bottom - 10), TARGET_COLOUR)


def _write(picture: NDArray[np.uint8], text: str, place: tuple[int, int], colour: str) -> None:
    """Write on any ground: with a border in the colour of paper."""
    for ink, thickness in ((PAPER_RGB, 5), (rgb(colour), 1)):
        cv2.putText(picture, text, place, FONT, FONT_SCALE, ink, thickness, cv2.LINE_AA)
