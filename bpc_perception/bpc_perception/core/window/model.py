"""Width, height or area as a law of flow or pressure, speed and temperature.

The logarithm is a sum of terms, with weights by the uncertainty of each line and the scatter from
line to line. How well the lines support which terms, Akaike's criterion for few data (AICc) says.
Predictions are means of all candidates, with weights by it, so that a bend that few lines show
counts in part, and what is not sure of the terms is in the uncertainty
[Burnham and Anderson 2002, ch. 2 and 4; Buckland et al. 1997].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from scipy.stats import norm
from statsmodels.regression.linear_model import WLS
from statsmodels.tools.eval_measures import aicc

from bpc_perception.core.arrays import Array
from bpc_perception.core.window.scatter import log_likelihood, scatter_of
from bpc_perception.core.window.sweep import column, Drive, SweepLine
from bpc_perception.core.window.terms import candidates, Scale

LEAST_FREE = 4  # degrees of freedom beside the terms
LEVEL = 0.95  # of intervals
LEAST_WEIGHT = 1e-3  # of a candidate that counts


@dataclass(frozen=True)
class Prediction:
    """What a model expects at settings (N,).

    Attributes:
        value: expected, median of lines [m or m^2].
        mean_sigma: 1-sigma uncertainty of ``value``, as a share of it.
        spread: standard deviation of a new line about ``value``, as a share of it.
    """

    value: Array
    mean_sigma: Array
    spread: Array

    @property
    def interval(self) -> Array:
        """Between which values (N, 2) a new line is with LEVEL [m or m^2]."""
        return self._within(self.spread)

    @property
    def mean_interval(self) -> Array:
        """Between which values (N, 2) the median of many lines is with LEVEL [m or m^2]."""
        return self._within(self.mean_sigma)

    def chance(self, low: float, high: float) -> Array:
        """Return the chance (N,) that a new line is between two values [m or m^2]."""
        above, below = (np.log(limit / self.value) / self.spread for limit in (high, low))
        return np.asarray(norm.cdf(above) - norm.cdf(below))

    def _within(self, sigma: Array) -> Array:
        reach = float(norm.ppf(0.5 + LEVEL / 2)) * sigma
        return np.stack((self.value * np.exp(-reach), self.value * np.exp(reach)), axis=-1)


@dataclass(frozen=True, eq=False)
class Candidate:
    """Terms that were fitted to lines.

    Attributes:
        name: of the terms.
        names: of each term beside constant and temperature.
        weight: how well the lines support it; those of all make 1.
        scatter: standard deviation from line to line beyond what the uncertainties of the widths
            tell, as a share; weights are made with it.
        seen: standard deviation of the widths as they were measured, as a share. That of a new
            line is taken to be as large: uncertainties that are too large, or alike for all
            lines, must not make it smaller.
        fit: of statsmodels.
    """

    name: str
    names: tuple[str, ...]
    weight: float
    scatter: float
    seen: float
    fit: Any


@dataclass(frozen=True, eq=False)
class Model:
    """A law that was fitted to lines.

    Attributes:
        of: what it tells, an attribute of SweepLine.
        scale: where terms are nought.
        drive: what pushes the ink out.
        lines: those that it is fitted to.
        candidates: terms that count, the best first.
    """

    of: str
    scale: Scale
    drive: Drive
    lines: tuple[SweepLine, ...]
    candidates: tuple[Candidate, ...]

    @property
    def best(self) -> Candidate:
        """The candidate that the lines support best."""
        return self.candidates[0]

    @property
    def scatter(self) -> float:
        """Standard deviation from line to line as measured, as a share."""
        return math.sqrt(sum(each.weight * each.seen**2 for each in self.candidates))

    def predict(self, drive: Array, speed: Array, temperature: float) -> Prediction:
        """Return what is expected at settings (N,) [m^3/s or Pa, m/s] and a temperature [K]."""
        degrees = np.full(len(drive), temperature)
        found = []
        for each in self.candidates:
            terms = self.scale.terms(each.names, drive, speed, degrees)
            told = each.fit.get_prediction(terms, weights=each.seen**-2, transform=False)
            found.append((told.predicted_mean, told.var_pred_mean, np.square(told.se_obs)))
        value, mean, line = np.moveaxis(np.array(found), 1, 0)  # each (C, N)
        weights = np.array([each.weight for each in self.candidates])
        expected = weights @ value
        apart = (value - expected)**2
        return Prediction(np.exp(expected), np.sqrt(weights @ (mean + apart)),
                          np.sqrt(weights @ (line + apart)))

    @property
    def coefficients(self) -> dict[str, tuple[float, float]]:
        """Value and 1-sigma uncertainty of the best terms' coefficients; ``1``: ln of SI units."""
        names = ['1', *self.best.names,
                 *(['1000/T'] if math.isfinite(self.scale.temperature) else [])]
        fit = self.best.fit
        pairs = zip(fit.params.tolist(), fit.bse.tolist(), strict=True)
        return dict(zip(names, pairs, strict=True))


def fit_model(lines: Sequence[SweepLine], of: str, drive: Drive, by_temperature: bool) -> Model:
    """Fit all candidates that lines are enough for, to those of which the value is known.

    Args:
        lines: of a sweep, of which enough are known.
        of: what it tells: ``width``, ``height`` or ``area``.
        drive: what pushes the ink out.
        by_temperature: whether the temperature counts.
    """
    known = [line for line in lines if math.isfinite(getattr(line, of))]
    values, sigma = np.log(column(known, of)), relative_sigma(known, of)
    pushed, speed = column(known, drive.value), column(known, 'speed')
    temperature = column(known, 'temperature')
    scale = Scale(_middle(pushed), _middle(speed),
                  float(temperature.mean()) if by_temperature else math.nan)
    named = candidates(drive)
    terms = {name: scale.terms(names, pushed, speed, temperature) for name, names in named.items()}
    terms = {name: made for name, made in terms.items()
             if len(values) - made.shape[1] >= LEAST_FREE}
    weights = _weights({name: float(aicc(log_likelihood(values, made, sigma), len(values),
                                         made.shape[1] + 1)) for name, made in terms.items()})
    return Model(of, scale, drive, tuple(known), tuple(
        _fitted(name, named[name], weight, values, terms[name], sigma)
        for name, weight in weights.items()))


def _weights(criterion: dict[str, float]) -> dict[str, float]:
    """Return Akaike's weights of the candidates that count, the best first."""
    least = min(criterion.values())
    support = {name: math.exp((least - criterion[name]) / 2)
               for name in sorted(criterion, key=lambda name: criterion[name])}
    kept = {name: each for name, each in support.items() if each >= LEAST_WEIGHT}
    return {name: each / sum(kept.values()) for name, each in kept.items()}


def _fitted(name: str, names: tuple[str, ...], weight: float, values: Array, terms: Array,
            sigma: Array) -> Candidate:
    scatter = scatter_of(values, terms, sigma)
    fit = WLS(values, terms, weights=1 / (sigma**2 + scatter**2)).fit(cov_type='fixed scale')
    return Candidate(name, names, weight, scatter,
                     scatter_of(values, terms, np.zeros(len(values))), fit)


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
