"""What repeats is told from what is chance."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.learning.repeating import repeating, STEP_M

COUNT = 480
PLACE = STEP_M * np.arange(COUNT)
KEEP = np.exp(-STEP_M / 5e-3)


def noise(seed: int, sigma: float) -> Array:
    """Return unevenness with a correlation length of 5 mm."""
    rng = np.random.default_rng(seed)
    value = np.empty(COUNT)
    value[0] = rng.standard_normal()
    for index in range(1, COUNT):
        value[index] = KEEP * value[index - 1] + (1 - KEEP**2)**0.5 * rng.standard_normal()
    return sigma * value


def test_a_level_is_found() -> None:
    found = repeating(np.array([0.4 + noise(1, 0.04)]), prior=0.0)
    assert abs(found.value.mean() - 0.4) < 0.03
    assert found.share == 0


def test_of_chance_little_is_believed() -> None:
    for layers in (1, 2, 3):
        spread, size = [], []
        for seed in range(20):
            curves = np.array([noise(100 * seed + layer, 0.4) for layer in range(layers)])
            spread.append(np.mean(repeating(curves, prior=0.0).value**2))
            size.append(np.mean(curves**2))
        assert np.mean(spread) < 0.03 * np.mean(size)


def test_what_repeats_is_believed_from_the_second_layer_on() -> None:
    own = noise(1, 0.1)
    curves = np.array([own + noise(10 + layer, 0.01) for layer in range(3)])
    errors = [np.std(repeating(curves[:count], prior=0.0).value - own) for count in (1, 2, 3)]
    assert errors[0] > 0.7 * np.std(own)
    assert errors[1] < 0.5 * np.std(own)
    assert errors[2] < 0.5 * np.std(own)


def test_a_drift_is_believed_from_the_first_layer_on() -> None:
    drift = np.linspace(-0.3, 0.3, COUNT)
    found = repeating(np.array([drift + noise(1, 0.04)]), prior=0.0)
    middle = slice(60, -60)  # a window at an end sees but one side
    assert np.std(found.value[middle] - drift[middle]) < 0.04


def test_places_that_were_not_seen_are_bridged() -> None:
    curve = 0.3 + noise(1, 0.02)
    curve[100:140] = np.nan
    found = repeating(np.array([curve]), prior=0.0)
    assert np.isfinite(found.value).all()
    assert np.abs(found.value[100:140] - 0.3).max() < 0.06
