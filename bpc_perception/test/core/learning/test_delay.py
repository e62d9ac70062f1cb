"""Lag and dead time: forwards, backwards, and found from widths."""

from __future__ import annotations

from learning_builders import layer_of, LENGTH_M, SPEED
import numpy as np
import pytest

from bpc_perception.core.learning.delay import Delay, fit_delay
from bpc_perception.core.learning.layer_record import TIME_STEP_S

TIME = TIME_STEP_S * np.arange(1000)


def test_a_step_arrives_as_an_exponential_behind_the_dead_time() -> None:
    arrived = Delay(lag=2.0, dead_time=0.4).arrived(np.ones(1000))
    assert np.all(arrived[TIME < 0.4] == 0)
    expected = 1 - np.exp(-(TIME - 0.4) / 2.0)
    late = TIME > 0.4
    np.testing.assert_allclose(arrived[late], expected[late], atol=TIME_STEP_S / 2.0)


def test_the_inverse_makes_the_wanted_arrive() -> None:
    delay = Delay(lag=0.8, dead_time=0.2)
    wanted = 1 + 0.2 * np.sin(2 * np.pi * TIME / 5)
    arrived = delay.arrived(delay.command_for(wanted, np.zeros(1000), np.full(1000, 50.0)))
    # What was to be commanded before the first is missing; that fades with the lag.
    late = (15 * delay.lag < TIME) & (TIME[-1] - delay.dead_time > TIME)
    np.testing.assert_allclose(arrived[late], wanted[late], rtol=1e-5)


def test_limits_hold() -> None:
    command = Delay(lag=5.0, dead_time=0.0).command_for(
        1 + (TIME > 5), np.full(1000, 0.5), np.full(1000, 2.0))
    assert command.min() >= 0.5
    assert command.max() <= 2.0
    assert command[0] == 2.0  # nothing has arrived yet


@pytest.mark.parametrize(('lag', 'dead_time'), [(0.5, 0.2), (2.0, 0.4), (7.0, 0.1)])
def test_they_are_found_from_widths(lag: float, dead_time: float) -> None:
    time = np.arange(0, LENGTH_M / SPEED, 0.05)
    record = layer_of(Delay(lag, dead_time), 1 + 0.3 * (np.floor(time / 6) % 2))
    found = fit_delay([record])
    assert found.lag == pytest.approx(lag, rel=0.35)
    # A lag that is a little short is made up for by the dead time.
    assert found.dead_time == pytest.approx(dead_time, abs=0.2 + 0.1 * lag)


def test_noise_alone_shows_no_long_lag() -> None:
    time = np.arange(0, LENGTH_M / SPEED, 0.05)
    record = layer_of(Delay(0.02, 0.0), np.ones(len(time)), noise=0.2)
    assert fit_delay([record]).lag <= 0.1
