"""How a picture is exposed, as a whole and around a path."""

from __future__ import annotations

import numpy as np
from perception_builders import bed, capture_of
import pytest

from bpc_perception.core.capture.exposure import around, Exposure


def test_a_pixel_is_clipped_if_one_channel_is() -> None:
    pixels = np.full((10, 10, 3), 100, np.uint8)
    pixels[:3, :, 1] = 255
    found = Exposure.of(pixels)
    assert found.clipped == pytest.approx(0.3)
    assert found.bright == pytest.approx(455 / 3)


def test_of_no_pixels_nothing_is_known() -> None:
    assert np.isnan(Exposure.of(np.empty((0, 3), np.uint8)).clipped)


def test_only_what_is_near_a_path_counts() -> None:
    image = bed()
    image[:, 100:] = 255
    capture = capture_of(image)
    left, right = (np.column_stack((np.full(5, u), np.arange(40, 80, 8))) for u in (20.0, 140.0))
    assert Exposure.of(around(capture, left)).clipped == 0
    assert Exposure.of(around(capture, right)).clipped == 1
    assert len(around(capture, np.full((4, 2), np.nan))) == 0
