"""The way of ink from the command to the bead: a first-order lag behind a dead time.

A compliant syringe delivers tau dq/dt + q = u [as in ``advice.delivery_filter``]. Its inverse,
with the command kept within limits, makes what arrives follow what is wanted.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.signal import lfilter

from bpc_perception.core.advice.delivery_filter import CORRELATION_LENGTH_M
from bpc_perception.core.arrays import Array
from bpc_perception.core.learning.layer_record import LayerRecord, TIME_STEP_S

LAGS_S = (0.02, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 4.5, 7.0, 10.0, 14.0)
DEAD_TIMES_S = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
LEAST_SHARE = 0.1  # of the command; where less arrives, it says nothing
EXCLUDED = 2.0  # logarithm of how much less likely: two standard deviations
LEAST_VARIANCE = 1e-4  # of the logarithm of w^2
LARGEST_RESIDUAL = 0.3  # of the logarithm; a larger one counts in proportion only [Huber]


@dataclass(frozen=True)
class Delay:
    """How late ink arrives.

    Attributes:
        lag: time constant [s].
        dead_time: before a command has any effect [s].
    """

    lag: float
    dead_time: float

    def arrived(self, command: Array) -> Array:
        """Return the flow (K,) that arrives of a command (K,), at times a step apart.

        Nothing was commanded before the first.
        """
        shift = min(round(self.dead_time / TIME_STEP_S), len(command))
        late = np.concatenate((np.zeros(shift), command[:len(command) - shift]))
        keep = np.exp(-TIME_STEP_S / self.lag)
        return np.asarray(lfilter([1 - keep], [1.0, -keep], late))

    def command_for(self, wanted: Array, least: Array, most: Array, early: int = 0) -> Array:
        """Return the command (K,) whose arrival is the wanted flow (K,), within limits (K,).

        The last dead time keeps its last command: nothing is known of what comes behind it.

        Args:
            wanted: flow that is to arrive.
            least: lower limits on the command, a dead time before it arrives.
            most: upper limits likewise.
            early: steps before the first for which the first limit is commanded.
        """
        keep = np.exp(-TIME_STEP_S / self.lag)
        flow = float(most[0]) * (1 - keep**early) if len(most) else 0.0
        ahead = np.empty(len(wanted))  # of the command, by the dead time
        for step, (goal, low, high) in enumerate(zip(
                wanted.tolist(), least.tolist(), most.tolist(), strict=True)):
            ahead[step] = min(max((goal - keep * flow) / (1 - keep), low), high)
            flow = keep * flow + (1 - keep) * ahead[step]
        shift = min(round(self.dead_time / TIME_STEP_S), len(wanted))
        return np.concatenate((ahead[shift:], np.full(shift, ahead[-1])))


def fit_delay(records: list[LayerRecord]) -> Delay:
    """Return the shortest lag that is not excluded by widths, and the dead time that fits to it.

    A lag that is assumed too long makes the command swing; one too short leaves an error. The
    gain is free, and may drift along each layer. Neighbouring widths are not independent: what
    fits counts per correlation length of their unevenness.
    """
    candidates = [Delay(*one) for one in product(LAGS_S, DEAD_TIMES_S)]
    cost = np.array([sum(_cost(record, delay) for record in records) for delay in candidates])
    count = sum(int(record.usable.sum()) for record in records)
    length = sum(float(record.place[-1] - record.place[0]) for record in records)
    independent = max(length / (2 * CORRELATION_LENGTH_M), 1.0)
    variance = max(2 * cost.min() / count, LEAST_VARIANCE)
    unlikely = cost / variance * independent / count
    best = int(np.argmin(unlikely))
    likely = np.flatnonzero(unlikely <= unlikely[best] + EXCLUDED)
    shortest = min(candidates[one].lag for one in likely)
    return candidates[min((one for one in likely if candidates[one].lag == shortest),
                          key=lambda one: unlikely[one])]


def needed(record: LayerRecord, delay: Delay) -> Array:
    """Return the logarithm (N,) of the volume that has to arrive per w^2; NaN = not known.

    The volume is per length of path, and w the width that it makes.
    """
    flow = np.interp(record.time, record.clock, delay.arrived(record.command))
    known = record.usable & (flow > LEAST_SHARE * record.rate) & (record.speed > 0)
    result = np.full(len(record), np.nan)
    result[known] = (np.log(flow[known] / record.speed[known])
                     - 2 * np.log(record.width[known]))
    return result


def _cost(record: LayerRecord, delay: Delay) -> float:
    """Return how badly a delay explains the widths of a layer."""
    value = needed(record, delay)
    if not np.isfinite(value).any():
        return float(record.usable.sum())  # it denies all that is seen
    # All delays are judged by the same points: one that denies some must not win by that.
    denied = record.usable & np.isnan(value)
    value = np.where(denied, np.nanmedian(value) - 1.0, value)
    known = np.isfinite(value)
    if known.sum() < 2:
        return float(record.usable.sum())
    place, value = record.place[known], value[known]
    trend = np.column_stack((np.ones(len(place)), place - place.mean()))
    weight = np.ones(len(place))
    for _ in range(3):
        root = np.sqrt(weight)
        found = np.linalg.lstsq(trend * root[:, None], value * root, rcond=None)[0]
        off = np.abs(value - trend @ found)
        weight = np.minimum(1.0, LARGEST_RESIDUAL / np.maximum(off, 1e-9))
    return float(np.where(off < LARGEST_RESIDUAL, off**2 / 2,
                          LARGEST_RESIDUAL * (off - LARGEST_RESIDUAL / 2)).sum())
