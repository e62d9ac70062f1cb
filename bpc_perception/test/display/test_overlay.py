"""Where points of the base frame lie in the image."""

import numpy as np
from report_prints import strand_result

from bpc_perception.display.overlay import path_pixels


def test_points_outside_the_image_are_not_drawn():
    outside = path_pixels(strand_result(), np.array(((0.0, 0.0, 0.1), (0.1, 0.0, 0.1))))
    np.testing.assert_allclose(outside, ((5, 12), (np.nan, np.nan)))
