"""Where lines contradict the model that was fitted to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from statsmodels.regression.linear_model import OLS, WLS

from bpc_perception.core.arrays import Array
from bpc_perception.core.window.model import Model
from bpc_perception.core.window.sweep import column, WindowError
from bpc_perception.core.window.words import several

CONTRADICTED = 1e-3  # p, below which the model is refused
MATTERS = 0.01  # of a width; less than this contradicts nothing
STRANGE = 0.01  # p, after Bonferroni, below which a line does not fit to the others
MOST_NAMED = 3


@dataclass(frozen=True)
class Stranger:
    """A line that does not fit to the others.

    Attributes:
        name: of the line.
        deviation: how much wider it is than the others let expect, as a share.
        p: how probable that is for the farthest of so many lines, after Bonferroni.
    """

    name: str
    deviation: float
    p: float


def strangers(model: Model) -> list[Stranger]:
    """Return the lines that do not fit: by Studentized residuals without themselves.

    [Cook and Weisberg 1982, ch. 2; Bonferroni for the number of lines]
    """
    fit = model.best.fit
    if np.abs(np.asarray(fit.resid)).max() < MATTERS:
        return []
    white = OLS(fit.model.wendog, fit.model.wexog).fit()
    found = np.asarray(white.outlier_test(method='bonf'))
    # What the line says less what the others expect there.
    leverage = white.get_influence().hat_matrix_diag
    deviation = np.expm1(np.asarray(fit.resid) / (1 - leverage))
    named = zip(model.lines, deviation.tolist(), found[:, 2].tolist(), strict=True)
    return [Stranger(line.name, share, p) for line, share, p in named if p < STRANGE]


def expect_agreement(model: Model) -> None:
    """Raise WindowError if the lines contradict the model, and name those that do most."""
    p = min(bend(model), lack_of_fit(model))
    if p > CONTRADICTED:
        return
    fit = model.best.fit
    residual = np.asarray(fit.resid)
    worst = np.argsort(-np.abs(residual * np.sqrt(fit.model.weights)))[:MOST_NAMED]
    shares = several(f'{model.lines[index].name} ({100 * np.expm1(residual[index]):+.0f} %)'
                     for index in worst)
    raise WindowError(
        f'expected a {model.of} that changes smoothly with {model.drive.value} and speed, found '
        f'lines that contradict it (p = {p:.1g}), most of all {shares}; print these again, or a '
        'sweep of a smaller range')


def bend(model: Model) -> float:
    """Return how probable so much of a bend in the residuals is by chance [Ramsey 1969].

    The squares and cubes of what was fitted would explain nothing of a model that is right.
    """
    fit = model.best.fit
    fitted = np.asarray(fit.fittedvalues)
    about = (fitted - fitted.mean()) / max(float(np.ptp(fitted)), 1e-9)
    return _gained(model, np.column_stack((fit.model.exog, about**2, about**3)))


def lack_of_fit(model: Model) -> float:
    """Return how probable so much difference of repeated settings from the model is by chance.

    The classical test: what lines of one setting differ from each other against what their means
    differ from the model [Draper and Smith 1998, 2.1]. 1 = nothing was repeated.
    """
    settings = np.round(np.log(np.column_stack([
        column(model.lines, name) for name in (model.drive.value, 'speed')])), 2)
    if np.isfinite(model.scale.temperature):
        settings = np.column_stack((settings, np.round(column(model.lines, 'temperature'))))
    _, which = np.unique(settings, axis=0, return_inverse=True)
    return _gained(model, np.eye(which.max() + 1)[which.ravel()])


def _gained(model: Model, terms: Array) -> float:
    """Return p of the F test that wider terms (N, P) explain no more than the model's.

    1 = they change what the model expects by less than MATTERS, or cannot be told apart.
    """
    fit = model.best.fit
    own = np.linalg.matrix_rank(fit.model.exog)
    wider = np.linalg.matrix_rank(terms)
    if wider <= own or len(terms) <= wider:
        return 1.0
    restricted, full = (WLS(fit.model.endog, chosen, weights=fit.model.weights).fit()
                        for chosen in (fit.model.exog, terms))
    change = np.asarray(full.fittedvalues - restricted.fittedvalues)
    if float(np.sqrt(np.mean(change**2))) < MATTERS:
        return 1.0
    return float(full.compare_f_test(restricted)[1])
