"""A part of a capture measures as the whole does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import band_image, capture_of, DOWN, pixel_path, SECOND, START_NS
import pytest

from bpc_perception.core.capture.region import crop
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.parameter import parameters_of
from bpc_perception.core.profile import Status

METHODS = parameters_of(ThicknessConfig)['method'][0].choices


@pytest.mark.parametrize('method', METHODS)
def test_a_region_measures_as_the_whole(method: str) -> None:
    config = ThicknessConfig(method=method)
    path = pixel_path((40, 55), (120, 55), 81)
    whole = capture_of(band_image(), START_NS + 10 * SECOND)
    part = crop(whole, (21, 25, 120, 61))
    assert part.image.shape == (61, 120, 3)
    expected, found = (measure(each, path, DOWN, config) for each in (whole, part))
    assert set(expected.status) == {Status.MEASURED}
    np.testing.assert_array_equal(found.status, expected.status)
    for name in ('thickness', 'sigma', 'left_points', 'right_points'):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-9)


def test_what_comes_with_each_pixel_is_cut_as_well() -> None:
    whole = capture_of(band_image())
    snr = np.arange(whole.image[..., 0].size, dtype=np.float32).reshape(whole.image.shape[:2])
    np.testing.assert_array_equal(crop(replace(whole, snr=snr), (5, 6, 7, 8)).snr,
                                  snr[6:14, 5:12])


@pytest.mark.parametrize('region', [(0, 0, 0, 0), (5, 6, 0, 7), (5, 6, 7, 0)])
def test_an_empty_region_is_the_whole(region: tuple[int, int, int, int]) -> None:
    whole = capture_of(band_image())
    assert crop(whole, region) is whole


@pytest.mark.parametrize('region', [(0, 0, 161, 120), (0, 0, 160, 121), (100, 0, 61, 10)])
def test_a_region_beyond_the_image_is_refused(region: tuple[int, int, int, int]) -> None:
    with pytest.raises(ValueError, match='region: expected it within 160 x 120 pixels, found'):
        crop(capture_of(band_image()), region)
