"""A region of a capture: what is cut away is neither sent nor looked at."""

from __future__ import annotations

from dataclasses import replace

from bpc_perception.core.capture.capture import Capture

Region = tuple[int, int, int, int]  # x, y of the upper left pixel, width, height [pixels]


def crop(capture: Capture, region: Region) -> Capture:
    """Return the part of a capture in a region, without a copy; the whole for an empty region.

    Points and intrinsics keep the optical frame: only the principal point is counted from
    another pixel.

    Raises ValueError if the region is not within the image.
    """
    x, y, width, height = region
    if width == 0 or height == 0:
        return capture
    camera = capture.camera
    if x + width > camera.width or y + height > camera.height:
        raise ValueError(f'region: expected it within {camera.width} x {camera.height} pixels, '
                         f'found {width} x {height} at ({x}, {y})')
    K = camera.K.copy()
    K[:2, 2] -= x, y
    rows, columns = slice(y, y + height), slice(x, x + width)
    snr = None if capture.snr is None else capture.snr[rows, columns]
    return replace(capture, image=capture.image[rows, columns], cloud=capture.cloud[rows, columns],
                   camera=replace(camera, K=K, width=width, height=height), snr=snr)
