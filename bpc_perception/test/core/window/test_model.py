"""The law that is fitted to lines of a known one, and how sure it is."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
import pytest
from scipy.stats import t as student_t
from swept_lines import half_circle, MM, MM3, sweep

from bpc_perception.core.window.model import fit_model, Prediction
from bpc_perception.core.window.scatter import scatter_of
from bpc_perception.core.window.sweep import Drive


def expected(lines, flow, speed, temperature=math.nan, of='width', by_temperature=False):
    model = fit_model(lines, of, Drive.FLOW, by_temperature)
    return model, model.predict(np.array([flow * MM3]), np.array([speed * MM]), temperature)


def test_a_law_of_geometry_is_found_as_it_is() -> None:
    model, found = expected(sweep(), 1.7, 12)
    assert found.value[0] == pytest.approx(half_circle(1.7, 12) * MM, rel=1e-6)
    assert model.best.name == 'ratio'  # width = sqrt(8 / π · flow / speed)
    assert model.coefficients['d-v'][0] == pytest.approx(0.5, abs=1e-6)


def test_powers_that_differ_are_told_apart() -> None:
    model, found = expected(sweep(lambda flow, speed: flow**0.6 * speed**-0.4, scatter=0.005,
                                   seed=1), 2, 9)
    assert model.best.name == 'powers'
    for name, power in (('d', 0.6), ('v', -0.4)):
        value, sigma = model.coefficients[name]
        assert abs(value - power) < 3 * sigma
        assert 0.001 < sigma < 0.005
    assert abs(found.value[0] / MM / (2**0.6 * 9**-0.4) - 1) < 3 * found.mean_sigma[0]


def test_a_bend_is_followed_where_lines_show_it() -> None:
    def bent(flow: float, speed: float) -> float:
        return half_circle(flow, speed) * math.exp(0.3 * math.log(flow / 2)**2)

    model, found = expected(sweep(bent, scatter=0.005), 2, 10)
    assert 'd²' in model.best.names
    assert found.value[0] == pytest.approx(bent(2, 10) * MM, rel=0.01)


def test_scatter_and_uncertainty_are_as_large_as_what_was_drawn() -> None:
    model, found = expected(sweep(scatter=0.03, seed=3), 2, 10)
    assert model.scatter == pytest.approx(0.03, rel=0.4)
    assert found.spread[0] > model.scatter
    # At the middle of 25 lines the mean is about five times as sure as one line.
    assert found.mean_sigma[0] == pytest.approx(model.scatter / 5, rel=0.6)


def test_uncertainties_that_explain_the_scatter_do_not_make_a_new_line_surer() -> None:
    told, of_told = expected(sweep(scatter=0.03, sigma=0.03, seed=3), 2, 10)
    untold, of_untold = expected(sweep(scatter=0.03, seed=3), 2, 10)
    assert told.best.scatter < 0.7 * untold.best.scatter
    assert of_told.spread[0] == pytest.approx(of_untold.spread[0], rel=0.05)


def test_scatter_without_measurement_errors_is_that_of_students_t() -> None:
    chance = np.random.default_rng(1)
    values, terms = chance.standard_normal(22) * 0.02, np.ones((22, 1))
    deviation = float(np.std(values, ddof=1))
    wanted = deviation * float(student_t(21).std())
    assert scatter_of(values, terms, np.zeros(22)) == pytest.approx(wanted, rel=0.01)


def test_a_line_that_is_less_sure_counts_less() -> None:
    lines = sweep(sigma=0.005)
    off = replace(lines[12], width=1.3 * lines[12].width, width_sigma=0.5 * lines[12].width)
    _, found = expected([*lines[:12], off, *lines[13:]], 2, 10)
    assert found.value[0] == pytest.approx(half_circle(2, 10) * MM, rel=1e-3)


def test_sigma_that_is_not_told_is_that_of_the_others() -> None:
    lines = sweep(sigma=0.01)
    lines[3] = replace(lines[3], width_sigma=math.nan)
    model, found = expected(lines, 2, 10)
    assert found.value[0] == pytest.approx(half_circle(2, 10) * MM, rel=1e-3)
    assert model.best.fit.model.weights.max() == pytest.approx(
        model.best.fit.model.weights.min(), rel=1e-6)


def test_temperature_counts_after_arrhenius() -> None:
    def warmer(kelvin: float):
        share = math.exp(2000 * (1 / 310 - 1 / kelvin))
        return [replace(line, temperature=kelvin) for line in
                sweep(lambda flow, speed: share * half_circle(flow, speed))]

    lines = [*warmer(300.0), *warmer(310.0), *warmer(320.0)]
    model, found = expected(lines, 2, 10, 310.0, by_temperature=True)
    assert found.value[0] == pytest.approx(half_circle(2, 10) * MM, rel=1e-4)
    assert model.coefficients['1000/T'][0] == pytest.approx(-2, rel=1e-3)


def test_pressure_over_speed_is_no_area() -> None:
    lines = [replace(line, pressure=1e5 * line.flow / MM3, flow=math.nan) for line in sweep()]
    model = fit_model(lines, 'width', Drive.PRESSURE, False)
    assert not any('ratio' in each.name for each in model.candidates)
    found = model.predict(np.array([2e5]), np.array([10 * MM]), math.nan)
    assert found.value[0] == pytest.approx(half_circle(2, 10) * MM, rel=1e-4)


def test_intervals_and_chances_are_those_of_the_normal_distribution() -> None:
    found = Prediction(np.array([1.0]), np.array([0.01]), np.array([0.1]))
    np.testing.assert_allclose(np.log(found.interval[0]), (-0.196, 0.196), atol=1e-3)
    np.testing.assert_allclose(np.log(found.mean_interval[0]), (-0.0196, 0.0196), atol=1e-4)
    assert found.chance(math.exp(-0.1), math.exp(0.1))[0] == pytest.approx(0.6827, abs=1e-4)
