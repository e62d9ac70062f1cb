"""A plain P-type learning law, which learning from layer to layer is compared with."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from bpc_perception.core.arrays import Array
from bpc_perception.core.learning.layer_record import LayerRecord
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_sim.closed_loop.controllers import SCALE_LIMITS

STEP_M = 5e-4  # between the places of the factors


class PTypeLearner:
    """Adds a share of the last layer's error to the logarithm of the factors [Arimoto 1984].

    u_next(s) = Q (u(s) + gain e(s + lead)), with e the logarithm of the area wanted over that
    found and Q a Gaussian window. The constants are in the middle of those that
    ``bpc_sim.studies.closed_loop.tuning`` can compare; they are not tuned.

    Args:
        gain: share of the error that is added.
        lead: of the command before the place of the error [m].
        window: standard deviation of the window [m].
    """

    def __init__(self, gain: float = 0.7, lead: float = 1e-3, window: float = 3e-3) -> None:
        self._gain, self._lead, self._window = gain, lead, window
        self._place: Array = np.empty(0)
        self._log_factor: Array = np.empty(0)

    def take(self, record: LayerRecord, followed: RateSchedule | None = None) -> bool:
        """Learn from a layer."""
        del followed
        if not len(self._place):
            self._place = np.arange(0.0, record.place[-1] + STEP_M, STEP_M)
            self._log_factor = np.zeros(len(self._place))
        known = record.usable
        if not known.any():
            return False
        error = 2 * np.log(record.wanted[known] / record.width[known])
        ahead = np.interp(self._place + self._lead, record.place[known], error)
        least, most = np.log(SCALE_LIMITS)
        self._log_factor = np.clip(gaussian_filter1d(
            self._log_factor + self._gain * ahead, self._window / STEP_M, mode='nearest'),
            least, most)
        return True

    def schedule(self) -> RateSchedule:
        """Return the factors for the next layer."""
        factor = np.exp(self._log_factor)
        return RateSchedule(self._place, factor, np.nan, np.nan, np.full(len(factor), np.nan),
                            np.nan, 0.0, 0.0, 1)
