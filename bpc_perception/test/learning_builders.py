"""Layers whose widths follow from a known lag, a known gain and a known command."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.learning.delay import Delay
from bpc_perception.core.learning.layer_record import LayerRecord, TIME_STEP_S

SPEED = 3e-3
LENGTH_M = 0.24
WIDTH = 2e-3
NOMINAL = 4e-6  # volume per length that makes the width at a gain of 1: w^2


def layer_of(delay: Delay, factor: Array, gain: Array | float = 1.0, noise: float = 0.0,
             seed: int = 0, number: int = 0, offset: tuple[float, float] = (0.0, 0.0),
             ) -> LayerRecord:
    """Return a straight layer of N points; ``factor`` (N,) is on the nominal flow."""
    count = len(factor)
    place = np.linspace(0, LENGTH_M, count)
    time = place / SPEED
    rate = NOMINAL * SPEED * factor
    clock = np.arange(0, time[-1] + TIME_STEP_S, TIME_STEP_S)
    step = np.clip(np.searchsorted(time, clock, side='right') - 1, 0, count - 1)
    flow = np.interp(time, clock, delay.arrived(rate[step]))
    uneven = 1 + noise * np.random.default_rng(seed).standard_normal(count)
    width = np.sqrt(gain * flow / SPEED) * uneven
    points = np.column_stack((place + offset[0], np.full(count, offset[1]),
                              np.full(count, 1e-3 * number)))
    nothing = np.zeros(count, bool)
    return LayerRecord('print', number, time, place, points, rate, np.full(count, WIDTH),
                       np.where(width > 2e-4, width, 0.0), nothing)
