"""The camera's image with what was measured drawn over it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.profile import Status
from bpc_perception.core.session import Result
from bpc_perception.display.legend import COLOURS, LEFT, rgb, RIGHT, TARGET
from bpc_perception.display.wording import advice_in_words, label

LEAST_WIDTH = 900  # smaller images are enlarged [pixels]
SHIFT = 4  # OpenCV draws to 1/16 of a pixel
LENGTHS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)  # of the scale bar [m]
BAR = 0.2  # of the image's width it takes at most
FONT, MARGIN, LINE = cv2.FONT_HERSHEY_SIMPLEX, 12, 22
PAPER = (255, 255, 255)


def draw_overlay(result: Result) -> NDArray[np.uint8]:
    """A measured capture's image, RGB (H, W, 3), with side points, statuses and a scale bar.

    Enlarged by a whole number if it is small.

    Raises:
        ValueError: nothing was measured in the capture.
    """
    profile = result.profile
    if profile is None or result.advice is None:
        raise ValueError(f'overlay: expected a measured capture, found: {result.refusal}')
    image = result.capture.image
    scale = max(1, -(-LEAST_WIDTH // image.shape[1]))
    picture = np.ascontiguousarray(np.repeat(np.repeat(image, scale, axis=0), scale, axis=1))
    draw_samples(picture, result)
    _scale_bar(picture, result, scale)
    summary = profile.summary
    words = [(f'capture {profile.capture}: {1e3 * summary.thickness_mean:.3f} mm, '
              f'{summary.coverage:.0%} known', TARGET),
             (advice_in_words(result.advice), TARGET), ('left side', LEFT), ('right side', RIGHT),
             *((label(status), COLOURS[status]) for status in Status
               if status != Status.MEASURED and (profile.status == status).any())]
    for number, (text, colour) in enumerate(words):
        _write(picture, text, (MARGIN, LINE * (number + 1)), colour)
    return picture


def draw_samples(picture: NDArray[np.uint8], result: Result) -> None:
    """Draw what came of each sample into a picture of the capture, of whatever size."""
    profile = result.profile
    assert profile is not None
    scale = picture.shape[1] / result.capture.camera.width
    measured = profile.status == Status.MEASURED
    for status in set(Status) - {Status.MEASURED}:
        _dots(picture, result, profile.points[profile.status == status], COLOURS[status], scale)
    _dots(picture, result, profile.left_points[measured], LEFT, scale)
    _dots(picture, result, profile.right_points[measured], RIGHT, scale)


def path_pixels(result: Result, points: Array) -> Array:
    """Where points (N, 3) of the base frame lie in the image, as (N, 2); NaN = outside."""
    assert result.T_base_camera is not None
    camera = result.capture.camera
    uv = camera.pixels(transform(invert(result.T_base_camera), points))
    return np.where(camera.contains(uv)[:, None], uv, np.nan)


def _dots(picture: NDArray[np.uint8], result: Result, points: Array, colour: str,
          scale: float) -> None:
    """Draw points (N, 3) as far as they are in the image; one for each pixel, that is enough."""
    uv = (path_pixels(result, points) + 0.5) * scale - 0.5
    uv = uv[np.isfinite(uv).all(axis=1)]
    places = np.rint(uv) @ (1, picture.shape[1])
    ink = rgb(colour)
    for u, v in np.rint(uv[np.unique(places, return_index=True)[1]] * 2**SHIFT).astype(
            int).tolist():
        cv2.circle(picture, (u, v), 2 << SHIFT, ink, -1, cv2.LINE_AA, SHIFT)


def pixel_size(result: Result) -> float:
    """What a pixel of the image is long in the middle of the path [m]."""
    assert result.profile is not None
    assert result.T_base_camera is not None
    depth = np.median(transform(invert(result.T_base_camera), result.profile.points)[:, 2])
    return float(depth) / result.capture.camera.focal_length


def _scale_bar(picture: NDArray[np.uint8], result: Result, scale: int) -> None:
    """Draw a length at the bottom, as it is in the middle of the path."""
    pixel = pixel_size(result) / scale
    if not pixel > 0:  # the path is not in front of the camera
        return
    height, width = picture.shape[:2]
    length = max((length for length in LENGTHS if length <= BAR * width * pixel),
                 default=LENGTHS[0])
    bottom, right = height - MARGIN, MARGIN + round(length / pixel)
    cv2.rectangle(picture, (MARGIN - 2, bottom - 3), (right + 2, bottom + 3), PAPER, cv2.FILLED)
    cv2.rectangle(picture, (MARGIN, bottom - 1), (right, bottom + 1), rgb(TARGET), cv2.FILLED)
    _write(picture, f'{1e3 * length:g} mm', (MARGIN, height - MARGIN - 10), TARGET)


def _write(picture: NDArray[np.uint8], text: str, place: tuple[int, int], colour: str) -> None:
    """Write on any ground: with a border in the colour of paper."""
    for ink, width in ((PAPER, 5), (rgb(colour), 1)):
        cv2.putText(picture, text, place, FONT, 0.6, ink, width, cv2.LINE_AA)
