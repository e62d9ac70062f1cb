"""How much of the commanded ink arrives in the bead, and how late, from measured widths.

A bead of width w holds w^2 of ink per length, up to a constant: the flow over the speed of the
nozzle. What arrives is a gain times the command behind a first-order lag, since a syringe and its
ink are compliant. Lag, unevenness of the bead and drift of the gain are not known. So several
models, one of each combination, are followed side by side, each by a Kalman filter on the
logarithm of the gain, and weighted by how well they foretold the widths (multiple-model adaptive
estimation: Magill, IEEE Trans. Automatic Control 10(4), 1965). What they say together has the
uncertainty of each and of their disagreement.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array

# There is a model for each combination of these.
LAGS_S = (0.0, 0.25, 0.5, 0.7, 1.0, 1.5, 2.2, 3.3, 5.0, 7.5, 11.0, 16.0)
# Of the bead, as standard deviation of the logarithm of w^2, which is twice that of the width.
UNEVENNESS = (0.03, 0.07, 0.15, 0.3, 0.5)
DRIFTS = (0.05, 0.4)  # of the logarithm of the gain [m^-1/2]

DEAD_TIME_S, DEAD_TIME_SIGMA_S = 0.2, 0.1  # before a command has any effect
LAG_SIGMA = 0.02  # relative, between the lags above
# Least and most that may be commanded for a while to reach the target, over what holds it.
LEAD = (0.6, 1.6)
CORRELATION_LENGTH_M = 5e-3  # of the unevenness: 0.82 of it is left after a millimetre
MEMORY_M = 0.5  # length of path over which the record of a model fades
PRIOR_SIGMA = 0.3  # of the logarithm of the gain, around what the print was set up for
OUTLIER_SIGMAS = 3.0  # a larger deviation counts as this many standard deviations


@dataclass(frozen=True)
class Delivery:
    """What is known of the delivery at the newest place measured.

    Attributes:
        gain: logarithm of w^2 over the commanded volume per length, in steady state.
        gain_sigma: its standard deviation.
        lag: time constant [s].
        lag_sigma: its standard deviation [s].
    """

    gain: float
    gain_sigma: float
    lag: float
    lag_sigma: float


class DeliveryFilter:
    """The models and what they know.

    Args:
        prior: logarithm of the gain for which the print was set up.
        prior_sigma: its standard deviation.
    """

    def __init__(self, prior: float, prior_sigma: float = PRIOR_SIGMA) -> None:
        lag, uneven, drift = np.meshgrid(np.arange(len(LAGS_S)), UNEVENNESS, DRIFTS, indexing='ij')
        self._lag: NDArray[np.intp] = lag.ravel()
        self._uneven: Array = uneven.ravel()**2
        self._drift: Array = drift.ravel()**2
        count = len(self._lag)
        # The state of each model: the gain, and the present deviation of the uneven bead.
        self._gain = np.full(count, prior)
        self._deviation = np.zeros(count)
        self._p_gain = np.full(count, prior_sigma**2)
        self._p_both = np.zeros(count)
        self._p_deviation = self._uneven.copy()
        self._odds = np.zeros(count)

    def move(self, length: float) -> None:
        """Move on along the path by a length [m]."""
        keep = np.exp(-length / CORRELATION_LENGTH_M)
        fade = np.exp(-length / MEMORY_M)
        self._p_gain = self._p_gain + self._drift * length
        self._deviation = keep * self._deviation
        self._p_both = keep * self._p_both
        self._p_deviation = keep**2 * self._p_deviation + (1 - keep**2) * self._uneven
        self._odds = fade * self._odds  # towards equal odds

    def expect(self, flow: Array, spread: Array) -> tuple[float, float]:
        """Return mean and standard deviation of log w^2 that the models foretell.

        Args:
            flow: (L,) logarithm of the ink per length behind each lag.
            spread: (L,) additional variance for each lag.
        """
        weight = self._weights
        mean = flow[self._lag] + self._gain + self._deviation
        together = float(weight @ mean)
        variance = (self._p_gain + 2 * self._p_both + self._p_deviation + spread[self._lag]
                    + (mean - together)**2)
        return together, float(np.sqrt(weight @ variance))

    def update(self, observed: float, flow: Array, spread: Array) -> None:
        """Learn from a measured log w^2; arguments as for ``expect``."""
        variance = self._p_gain + 2 * self._p_both + self._p_deviation + spread[self._lag]
        sigma = np.sqrt(variance)
        surprise = observed - flow[self._lag] - self._gain - self._deviation
        surprise = np.clip(surprise, -OUTLIER_SIGMAS * sigma, OUTLIER_SIGMAS * sigma)
        self._odds = self._odds - np.log(sigma) - surprise**2 / (2 * variance)
        self._odds -= self._odds.max()
        share_gain = (self._p_gain + self._p_both) / variance
        share_deviation = (self._p_both + self._p_deviation) / variance
        self._gain = self._gain + share_gain * surprise
        self._deviation = self._deviation + share_deviation * surprise
        self._p_gain, self._p_both, self._p_deviation = (
            self._p_gain - share_gain**2 * variance,
            self._p_both - share_gain * share_deviation * variance,
            self._p_deviation - share_deviation**2 * variance)

    def estimate(self) -> Delivery:
        """Return what the models say together."""
        weight = self._weights
        gain = float(weight @ self._gain)
        lags = np.array(LAGS_S)[self._lag]
        lag = float(weight @ lags)
        return Delivery(gain, self.gain_sigma, lag, float(weight @ (lags - lag)**2)**0.5)

    def after(self, command: float, flow: Array, horizon: float) -> float:
        """Return the logarithm of what arrives at the horizon if the command stays as it is.

        Args:
            command: in force.
            flow: (L,) behind each lag now.
            horizon: time from now [s].
        """
        return float(self._weights @ (
            self._gain + np.log(lagged(flow, command, horizon))[self._lag]))

    def rate_for(self, wanted: float, flow: Array, horizon: float) -> float:
        """Return the logarithm of the command that makes what arrives the wanted at the horizon.

        Behind a long lag that is more, for a while, than what holds it there.

        Args:
            wanted: logarithm of what is to arrive.
            flow: (L,) behind each lag now.
            horizon: time from now [s].
        """
        left = lagged(np.ones(len(LAGS_S)), 0.0, horizon)[self._lag]
        present = np.exp(self._gain - wanted) * flow[self._lag]
        share = np.clip((1 - left * present) / (1 - left), *LEAD)
        return float(self._weights @ (wanted - self._gain + np.log(share)))

    @property
    def gain_sigma(self) -> float:
        """The standard deviation of the logarithm of the gain."""
        weight = self._weights
        gain = weight @ self._gain
        return float(np.sqrt(weight @ (self._p_gain + (self._gain - gain)**2)))

    def branch(self) -> DeliveryFilter:
        """Return a filter that goes on from here; this one stays as it is."""
        return copy(self)

    @property
    def _weights(self) -> Array:
        odds = np.exp(self._odds - self._odds.max())
        return np.asarray(odds / odds.sum())


def lagged(delivered: Array, command: float, elapsed: float) -> Array:
    """Return the flow behind each lag (L,) after the command has stood for a time [s].

    Args:
        delivered: (L,) flow before.
        command: in force.
        elapsed: for how long [s].
    """
    return np.asarray(command + kept_after(elapsed) * (delivered - command))


def kept_after(elapsed: Array | float) -> Array:
    """Return which share (..., L) of a change is still to come behind each lag after times [s]."""
    lags = np.array(LAGS_S)
    with np.errstate(divide='ignore'):
        return np.where(lags > 0, np.exp(-np.asarray(elapsed)[..., None] / lags), 0.0)


def transient_variance(delivered: Array, command: float) -> Array:
    """Return the variance (L,) of the logarithm of a flow that is still on its way.

    Dead time and lag are not known exactly. That counts the more, the farther the flow still has
    to go.
    """
    lags = np.array(LAGS_S)
    shift = LAG_SIGMA + DEAD_TIME_SIGMA_S / np.maximum(lags, 0.1)
    return np.asarray((shift * (command / delivered - 1))**2)
