"""The extruder with faults: volumes by hand, lag by its equation."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_sim.ink.extrusion import ExtruderBehaviour, Extrusion

SPEED, WIDTH, LENGTH = 3e-3, 2e-3, 0.3  # of the print [m/s], [m], [m]


def printed(behaviour: ExtruderBehaviour, step: float = 0.01) -> Extrusion:
    """Print a line at constant speed and command."""
    extrusion = Extrusion(behaviour, LENGTH)
    flow = behaviour.flow_for(WIDTH, SPEED)
    for time in np.arange(0, LENGTH / SPEED, step):
        extrusion.advance(float(time), SPEED * float(time), flow)
    return extrusion


def test_a_round_bead_holds_the_flow() -> None:
    behaviour = ExtruderBehaviour(lag=0.01, dead_time=0.0, noise=0.0, spreading=1.0)
    assert behaviour.flow_for(WIDTH, SPEED) == pytest.approx(np.pi / 4 * WIDTH**2 * SPEED)
    width = printed(behaviour).width(np.array((0.1, 0.2)))
    assert width == pytest.approx(WIDTH, rel=1e-6)


def test_a_flat_bead_holds_the_flow_too() -> None:
    behaviour = ExtruderBehaviour()
    height = behaviour.height_ratio * WIDTH
    # A parabola over the width has two thirds of the area of its rectangle.
    assert 2 / 3 * height * WIDTH * SPEED == pytest.approx(behaviour.flow_for(WIDTH, SPEED))


@pytest.mark.parametrize(('lag', 'dead'), [(1.0, 0.0), (5.0, 0.5)])
def test_the_flow_follows_by_its_lag_after_its_dead_time(lag: float, dead: float) -> None:
    extrusion = printed(ExtruderBehaviour(lag=lag, dead_time=dead, noise=0.0))
    time = np.array((dead + lag, dead + 3 * lag))
    arrived = (extrusion.width(SPEED * time) / WIDTH)**2
    assert arrived == pytest.approx(1 - np.exp((-1, -3)), abs=0.01)


def test_a_share_that_arrives_a_bubble_and_a_corner() -> None:
    extrusion = printed(ExtruderBehaviour(
        lag=0.05, noise=0.0, delivery=lambda s: np.where(s < 0.1, 1.0, 0.49),
        bubbles=np.array(((0.2, 0.21),)), corners=np.array((0.25,)), drag=0.2))
    assert extrusion.width(np.array((0.05, 0.15, 0.205, 0.25, 0.2499))) / WIDTH == pytest.approx(
        (1, 0.7, 0, 0.8 * 0.7, 0.7), rel=1e-3)
    assert extrusion.width(np.array((0.31,))) == 0


@pytest.mark.parametrize('variation', [0.07, 0.23])
def test_the_noise_is_as_large_and_as_correlated_as_said(variation: float) -> None:
    s = np.arange(0.02, 0.28, 1e-3)
    behaviours = [ExtruderBehaviour(lag=0.05, noise=variation, seed=seed) for seed in range(20)]
    widths = np.array([printed(behaviour, 0.05).width(s) for behaviour in behaviours]) / WIDTH - 1
    assert widths.std() == pytest.approx(variation, rel=0.1)
    neighbours = np.corrcoef(widths[:, 1:].ravel(), widths[:, :-1].ravel())[0, 1]
    assert neighbours == pytest.approx(0.82, abs=0.05)
    np.testing.assert_array_equal(
        printed(ExtruderBehaviour(seed=3)).width(s), printed(ExtruderBehaviour(seed=3)).width(s))
