"""Cp and Cpk by the example of the NIST/SEMATECH e-Handbook, their bounds by tables and chance."""

import numpy as np
import pytest

from bpc_perception.core.control.capability import capability, share_bounds


def spread(mean: float, sigma: float, count: int) -> np.ndarray:
    """Values of exactly this mean and standard deviation."""
    values = np.arange(count, dtype=float)
    return mean + sigma * (values - values.mean()) / values.std(ddof=1)


def test_indices_are_those_of_the_handbook() -> None:
    """[6.1.6: limits 8 and 20, mean 16, sigma 2]"""
    found = capability(spread(16.0, 2.0, 20), (8.0, 20.0))
    assert (found.cp, found.cpk) == (pytest.approx(1.0), pytest.approx(0.6667, abs=1e-4))
    assert (found.mean, found.sigma, found.count) == (pytest.approx(16), pytest.approx(2), 20)
    # Chi squared of 19 degrees of freedom: 8.907 and 32.852 at 2.5 and 97.5 %.
    assert found.cp_bounds == (pytest.approx(np.sqrt(8.907 / 19), abs=1e-4),
                               pytest.approx(np.sqrt(32.852 / 19), abs=1e-4))
    half = 1.96 * np.sqrt(1 / (9 * 20) + 0.6667**2 / (2 * 19))
    assert found.cpk_bounds == (pytest.approx(0.6667 - half, abs=1e-3),
                                pytest.approx(0.6667 + half, abs=1e-3))


def test_a_mean_outside_the_tolerance_has_a_negative_cpk() -> None:
    assert capability(spread(21.0, 1.0, 12), (8.0, 20.0)).cpk == pytest.approx(-1 / 3)


@pytest.mark.parametrize('count', [10, 30])
@pytest.mark.parametrize('cpk', [0.67, 1.33])
def test_bounds_hold_as_often_as_they_say(count: int, cpk: float) -> None:
    rng = np.random.default_rng(3)
    cp = cpk + 0.2
    found = [capability(values, (-3 * cpk, 6 * cp - 3 * cpk))
             for values in rng.normal(size=(2000, count))]
    for true, bounds in ((cpk, [each.cpk_bounds for each in found]),
                         (cp, [each.cp_bounds for each in found])):
        held = np.mean([low <= true <= high for low, high in bounds])
        assert held == pytest.approx(0.95, abs=0.02)


@pytest.mark.parametrize(('values', 'tolerance', 'reason'), [
    (spread(2.0, 0.1, 20), (np.nan, np.nan), 'no tolerance'),
    (spread(2.0, 0.1, 9), (1.0, 3.0), 'Cp needs 10 prints, there are 9'),
    (np.append(spread(2.0, 0.1, 9), np.nan), (1.0, 3.0), 'Cp needs 10 prints, there are 9'),
    (np.full(20, 2.0), (1.0, 3.0), 'all prints are the same')])
def test_what_cannot_be_told_has_a_reason(values: np.ndarray, tolerance: tuple[float, float],
                                          reason: str) -> None:
    found = capability(values, tolerance)
    assert np.isnan((found.cp, *found.cp_bounds, found.cpk, *found.cpk_bounds)).all()
    assert found.reason == reason


def test_bounds_of_a_share() -> None:
    """None bad of ten: the share of bad ones p has (1 - p)^10 = 0.025."""
    rest = 0.025**0.1
    assert share_bounds(10, 10) == (pytest.approx(rest), 1.0)
    assert share_bounds(0, 10) == (0.0, pytest.approx(1 - rest))
    assert np.isnan(share_bounds(0, 0)).all()
    low, high = share_bounds(5, 10)
    assert (low, high) == (pytest.approx(0.1871, abs=1e-4), pytest.approx(0.8129, abs=1e-4))
