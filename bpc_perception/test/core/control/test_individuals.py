"""Control limits of individual values, by the example of the NIST/SEMATECH e-Handbook."""

import numpy as np
import pytest

from bpc_perception.core.control.individuals import control_limits

# [6.3.2.2: flowrate of ten batches; its moving ranges have the mean 1.8778]
FLOWRATE = np.array((49.6, 47.6, 49.9, 51.3, 47.8, 51.2, 52.6, 52.4, 53.6, 52.1))


def test_limits_are_those_of_the_handbook() -> None:
    limits = control_limits(FLOWRATE)
    assert (limits.centre, limits.count, limits.reason) == (pytest.approx(50.81), 10, '')
    assert limits.upper == pytest.approx(55.8041, abs=1e-4)
    assert limits.lower == pytest.approx(45.8159, abs=1e-4)


def test_only_the_baseline_sets_the_limits() -> None:
    assert control_limits(np.append(FLOWRATE, (99.0, 99.0)), 10) == control_limits(FLOWRATE)


def test_what_is_not_known_does_not_count() -> None:
    with_holes = np.insert(FLOWRATE, (0, 5, 10), np.nan)
    assert control_limits(with_holes) == control_limits(FLOWRATE)


def test_few_prints_have_no_limits_but_a_reason() -> None:
    limits = control_limits(FLOWRATE[:9])
    assert np.isnan((limits.centre, limits.sigma, limits.lower, limits.upper)).all()
    assert limits.reason == 'limits need 10 prints, the baseline has 9'


def test_prints_that_are_the_same_have_no_limits_but_a_reason() -> None:
    limits = control_limits(np.full(12, 2.0))
    assert np.isnan(limits.sigma)
    assert limits.reason == 'all prints of the baseline are the same'


def test_a_drift_hardly_widens_the_limits() -> None:
    """Each difference of neighbours is 0.1, so sigma is; the values spread over 30 times that."""
    limits = control_limits(0.1 * np.arange(100))
    assert limits.sigma == pytest.approx(0.1 / 1.128)
