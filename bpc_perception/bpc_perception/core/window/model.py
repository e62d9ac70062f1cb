"""Width, height or area as a law of flow or pressure, speed and temperature.

The logarithm is a sum of terms, with weights by the uncertainty of each line and the scatter from
line to line. Which terms the lines support, Akaike's criterion for few data (AICc) says
[Burnham and Anderson 2002, 2.4].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from scipy.stats import t as student_t
from statsmodels.regression.linear_model import WLS
from statsmodels.tools.eval_measures import aicc

from bpc_perception.core.arrays import Array
from bpc_perception.core.window.scatter import log_likelihood, scatter_of
from bpc_perception.core.window.sweep import column, Drive, SweepLine
from bpc_perception.core.window.terms import candidates, Scale

LEAST_FREE = 4  # degrees of freedom beside the terms
LEVEL = 0.95  # of intervals


@dataclass(frozen=True)
class Prediction:
    """What a model expects at settings (N,).

    Attributes:
        value: expected, median of lines [m or m^2].
        mean_sigma: 1-sigma uncertainty of ``value``, as a share of it.
        spread: standard deviation of a new line about ``value``, as a share of it.
        free: degrees of freedom of both.
    """

    value: Array
    mean_sigma: Array
    spread: Array
    free: int

    @property
    def interval(self) -> Array:
        """Between which values (N, 2) a new line is with LEVEL [m or m^2]."""
        return self._within(self.spread)

    @property
    def mean_interval(self) -> Array:
        """Between which values (N, 2) the mean of many lines is with LEVEL [m or m^2]."""
        return self._within(self.mean_sigma)

    def chance(self, low: float, high: float) -> Array:
        """Return the chance (N,) that a new line is between two values [m or m^2]."""
        law = student_t(self.free)
        above, below = (np.log(limit / self.value) / self.spread for limit in (high, low))
        return np.asarray(law.cdf(above) - law.cdf(below))

    def _within(self, sigma: Array) -> Array:
        reach = float(student_t.ppf(0.5 + LEVEL / 2, self.free)) * sigma
        return np.stack((self.value * np.exp(-reach), self.value * np.exp(reach)), axis=-1)


@dataclass(frozen=True, eq=False)
class Model:
    """A law that was fitted to lines.

    Attributes:
        of: what it tells, an attribute of SweepLine.
        candidate: name of the terms that were chosen.
        names: of the terms beside constant and temperature.
        scale: where they are nought.
        drive: what pushes the ink out.
        scatter: standard deviation from line to line, as a share.
        lines: those that it is fitted to.
        fit: of statsmodels.
    """

    of: str
    candidate: str
    names: tuple[str, ...]
    scale: Scale
    drive: Drive
    scatter: float
    lines: tuple[SweepLine, ...]
    fit: Any

    def predict(self, drive: Array, speed: Array, temperature: float) -> Prediction:
        """Return what is expected at settings (N,) [m^3/s or Pa, m/s] and a temperature [K]."""
        terms = self.scale.terms(self.names, drive, speed, np.full(len(drive), temperature))
        # A new line has the scatter, and no uncertainty of a measurement.
        found = self.fit.get_prediction(terms, weights=self.scatter**-2, transform=False)
        return Prediction(np.exp(np.asarray(found.predicted_mean)), np.asarray(found.se_mean),
                          np.asarray(found.se_obs), int(self.fit.df_resid))

    @property
    def coefficients(self) -> dict[str, tuple[float, float]]:
        """Value and 1-sigma uncertainty of each term's coefficient; of ``1``, ln of SI units."""
        names = ['1', *self.names, *(['1000/T'] if math.isfinite(self.scale.temperature) else [])]
        pairs = zip(self.fit.params.tolist(), self.fit.bse.tolist(), strict=True)
        return dict(zip(names, pairs, strict=True))


def fit_model(lines: Sequence[SweepLine], of: str, drive: Drive, by_temperature: bool) -> Model:
    """Fit the candidate that the lines support best, to those of which the value is known.

    Args:
        lines: of a sweep, of which enough are known.
        of: what it tells: ``width``, ``height`` or ``area``.
        drive: what pushes the ink out.
        by_temperature: whether the temperature counts.
    """
    known = [line for line in lines if math.isfinite(getattr(line, of))]
    values = np.log(column(known, of))
    sigma = relative_sigma(known, of)
    pushed, speed = column(known, drive.value), column(known, 'speed')
    temperature = column(known, 'temperature')
    scale = Scale(_middle(pushed), _middle(speed),
                  float(temperature.mean()) if by_temperature else math.nan)

    def criterion(names: tuple[str, ...]) -> float:
        terms = scale.terms(names, pushed, speed, temperature)
        likelihood = log_likelihood(values, terms, sigma)
        return float(aicc(likelihood, len(values), terms.shape[1] + 1))

    fitting = {name: terms for name, terms in candidates(drive).items()
               if len(values) - len(terms) - 1 - by_temperature >= LEAST_FREE}
    chosen = min(fitting, key=lambda name: criterion(fitting[name]))
    terms = scale.terms(fitting[chosen], pushed, speed, temperature)
    scatter = scatter_of(values, terms, sigma)
    fit = WLS(values, terms, weights=1 / (sigma**2 + scatter**2)).fit(cov_type='fixed scale')
    return Model(of, chosen, fitting[chosen], scale, drive, scatter, tuple(known), fit)


def relative_sigma(lines: Sequence[SweepLine], of: str) -> Array:
    """Return the uncertainty (N,) of a value of each line, as a share of it.

    Where it is not told it is that of the others in the median; with none told it is nought, and
    all is scatter from line to line.
    """
    sigma = column(lines, f'{of}_sigma') / column(lines, of)
    told = np.isfinite(sigma)
    return np.where(told, sigma, np.median(sigma[told]) if told.any() else 0.0)


def _middle(values: Array) -> float:
    return float(np.exp(np.log(values).mean()))
