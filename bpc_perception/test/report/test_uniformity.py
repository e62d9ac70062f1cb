"""Uniformity of prints that can be counted by hand."""

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.profile import Status
from bpc_perception.core.targets import WidthTargets
from bpc_perception.report.uniformity import uniformity

MM = 1e-3


def test_share_within_a_tenth_of_the_target():
    # 1.81 and 2.19 are just within; 2.3 and the gap are not; the last is not known.
    profile = profile_of([1.81 * MM, 2.19 * MM, 2.3 * MM, 0.0, np.nan], [
        Status.MEASURED, Status.MEASURED, Status.MEASURED, Status.GAP, Status.NO_DATA])
    found = uniformity(profile, WidthTargets.constant(2 * MM))
    assert found.within == pytest.approx(2 / 4)
    widths = np.array((1.81, 2.19, 2.3))
    assert found.variation == pytest.approx(
        np.sqrt(((widths - 2.1) ** 2).sum() / 3) / 2.1)


def test_without_a_target_the_median_is_the_reference():
    profile = profile_of([1 * MM, 1.05 * MM, 3 * MM])
    assert uniformity(profile, None).within == pytest.approx(2 / 3)


def test_a_graded_target_is_looked_up_along_the_path():
    profile = profile_of([1 * MM, 2 * MM, 3 * MM])  # a sample each millimetre
    graded = WidthTargets(np.array((0.0, 2 * MM)), np.array((1 * MM, 3 * MM)))
    assert uniformity(profile, graded).within == 1.0


def test_nothing_measured_is_no_number():
    assert np.isnan(uniformity(profile_of([np.nan], [Status.NO_DATA]), None)).all()
