"""Unevenness as measured: correlations by their formulas, series by waves that are known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.parameter import ConfigError
from bpc_sim.ink.extrusion import ExtruderBehaviour, Extrusion
from bpc_sim.ink.measured_series import MeasuredSeries, REACH_COLUMN, read_line, read_series
from bpc_sim.ink.unevenness import MeasuredUnevenness

STEP_M, COUNT = 2e-4, 100_000  # twenty metres: chance is within the tolerances
MODEL = MeasuredUnevenness(wave=0.1, wavelength=2.5e-3, memory=9e-3, slow=0.04,
                           slow_length=0.05, repeats=0.7)


def autocorrelation(values: Array, lags: Array) -> Array:
    """Of values (N,) at lags (K,) in steps."""
    values = values - values.mean()
    return np.array([np.mean(values[:len(values) - lag] * values[lag:])
                     for lag in lags]) / values.var()


@pytest.mark.parametrize('seed', range(3))
def test_the_wave_is_as_large_and_forgets_as_said(seed: int) -> None:
    factors = replace(MODEL, slow=0.0).factors(COUNT, STEP_M, seed, 1)
    assert factors.mean() == pytest.approx(1, abs=1e-3)
    assert factors.std() == pytest.approx(0.1, rel=0.03)
    lags = np.arange(0, 150, 3)
    d = lags * STEP_M
    expected = np.exp(-d / 9e-3) * np.cos(2 * np.pi * d / 2.5e-3)
    np.testing.assert_allclose(autocorrelation(factors, lags), expected, atol=0.04)


@pytest.mark.parametrize('seed', range(3))
def test_the_slow_change_fades_as_said(seed: int) -> None:
    slow = replace(MODEL, wave=0.0).factors(COUNT, STEP_M, seed, 1)
    # The standard error of the variance over n lengths L is sqrt(2 L / n L) of it: 7 %.
    assert slow.std() == pytest.approx(0.04, rel=0.12)
    lags = np.array((25, 125, 250, 500))
    np.testing.assert_allclose(autocorrelation(slow, lags), np.exp(-lags * STEP_M / 0.05),
                               atol=0.15)


def test_stretches_as_long_as_the_measured_ones_change_as_much() -> None:
    model = MeasuredUnevenness(wave=0.0)
    stretches = [model.factors(250, STEP_M, seed, 1).std() for seed in range(1000)]
    found = np.sqrt(np.mean(np.square(stretches)))
    # The mean over a length T has 2 (T - 1 + exp(-T)) / T^2 of the variance, T in fade lengths.
    length = 250 * STEP_M / model.slow_length
    around_mean = 1 - 2 * (length - 1 + np.exp(-length)) / length**2
    assert found == pytest.approx(model.slow * np.sqrt(around_mean), rel=0.05)
    assert found == pytest.approx(0.036, abs=0.005)  # as measured, with its standard error


def test_both_add_up() -> None:
    variance = [MODEL.factors(COUNT, STEP_M, seed, 1).var() for seed in range(5)]
    assert np.mean(variance) == pytest.approx(0.1**2 + 0.04**2, rel=0.05)


@pytest.mark.parametrize('repeats', [0.0, 0.7, 1.0])
def test_only_the_slow_change_repeats_from_layer_to_layer(repeats: float) -> None:
    model = replace(MODEL, repeats=repeats)
    slow, wave = replace(model, wave=0.0), replace(model, slow=0.0)
    for part, expected, tolerance in ((slow, repeats, 0.2), (wave, 0.0, 0.06)):
        first, second = (part.factors(COUNT, STEP_M, 3, layer) for layer in (1, 2))
        assert np.corrcoef(first, second)[0, 1] == pytest.approx(expected, abs=tolerance)


def test_a_seed_is_a_printer_on_paths_of_any_length() -> None:
    np.testing.assert_array_equal(
        MODEL.factors(500, STEP_M, 3, 2), MODEL.factors(900, STEP_M, 3, 2)[:500])
    slow = replace(MODEL, wave=0.0, repeats=1.0)
    assert not np.allclose(slow.factors(500, STEP_M, 3, 1), slow.factors(500, STEP_M, 4, 1))


@pytest.mark.parametrize(('name', 'value'), [
    ('wave', -0.1), ('wave', np.nan), ('wavelength', 0.0), ('memory', 0.0), ('slow', 1.0),
    ('slow_length', np.inf), ('repeats', 1.1)])
def test_a_constant_that_makes_no_sense_is_refused(name: str, value: float) -> None:
    with pytest.raises(ConfigError, match=f'{name}: expected'):
        MeasuredUnevenness(**{name: value})


def test_the_bead_is_as_uneven_as_the_model() -> None:
    behaviour = ExtruderBehaviour(lag=1e-3, dead_time=0.0, noise=0.5, unevenness=MODEL, seed=3,
                                  layer=2)
    extrusion = Extrusion(behaviour, 0.09)
    flow = behaviour.flow_for(2e-3, 3e-3)
    for time in np.arange(0, 31, 0.05):
        extrusion.advance(float(time), 3e-3 * float(time), flow)
    # At the places of the model's values, but for the start.
    expected = MODEL.factors(400, STEP_M, 3, 2)[100:]
    found = extrusion.width(np.arange(100, 400) * STEP_M) / 2e-3
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def series(file: Path, time: Array, reach: list[str] | Array) -> Path:
    """Write a file as they were published."""
    rows = [f'1,{t},{value}' for t, value in zip(time, reach, strict=True)]
    file.write_text('\n'.join((f'frame #,time (s),{REACH_COLUMN}', *rows)) + '\n', 'utf-8')
    return file


def waves(s: Array) -> Array:
    """A reach [mm] with waves of 5 mm, over arc lengths [m]."""
    return 0.6 * (1 + 0.1 * np.sin(2 * np.pi * s / 5e-3))


def test_a_series_becomes_factors_along_the_path(tmp_path: Path) -> None:
    time = 12.0 + np.arange(501) / 50  # 50 mm at 5 mm/s: ten waves, whose mean is none
    reach = [f'{value:.9f}' for value in waves((time - 12.0) * 5e-3)]
    reach[100] = ''  # a frame without a surface; at 10 mm the waves pass their mean
    s, factor = read_line(series(tmp_path / 'line.csv', time, reach), 5e-3)
    assert len(s) == 500
    np.testing.assert_allclose(s[[0, -1]], (0, 0.05), atol=1e-12)
    np.testing.assert_allclose(factor, waves(s) / 0.6, atol=1e-5)


def test_a_longer_path_goes_on_backwards_and_a_layer_takes_the_next_line() -> None:
    place = np.linspace(0, 0.05, 501)
    lines = MeasuredSeries(((place, waves(place) / 0.6), (place, np.full(501, 1.0))))
    np.testing.assert_array_equal(lines.factors(1000, STEP_M, 3, 1), 1.0)
    factors = lines.factors(1000, STEP_M, 3, 2)  # 0.2 m: twice there and back
    np.testing.assert_allclose(factors[500:], factors[:500], atol=1e-9)
    # Somewhere it turns: around there it is its own mirror image.
    assert any(np.allclose(factors[turn - 100:turn], factors[turn + 1:turn + 101][::-1], atol=0.03)
               for turn in range(100, 500))
    assert factors.std() == pytest.approx(0.1 / np.sqrt(2), rel=0.02)


@pytest.mark.parametrize(('time', 'reach', 'found'), [
    (np.arange(99) / 50, np.full(99, 0.6), 'found 99; '),
    (np.zeros(200), np.full(200, 0.6), 'growing times'),
    (np.arange(200) / 50, np.full(200, -0.6), 'mean above 0'),
    (np.arange(200) / 50, ['much'] * 200, 'expected numbers')])
def test_what_is_no_series_is_refused(tmp_path: Path, time: Array, reach: list[str] | Array,
                                      found: str) -> None:
    with pytest.raises(ValueError, match=found):
        read_line(series(tmp_path / 'line.csv', time, reach), 5e-3)


def test_a_table_without_the_column_and_no_table_are_refused(tmp_path: Path) -> None:
    file = series(tmp_path / 'line.csv', np.arange(200) / 50, np.full(200, 0.6))
    with pytest.raises(ValueError, match='found none named height; name another'):
        read_series([file], [5e-3], 'height')
    with pytest.raises(ValueError, match='expected lines'):
        read_series([], [])
