"""A layer is corrected by those before: with any gain and lag, never beyond limits or on gaps."""

from __future__ import annotations

from dataclasses import replace

from learning_builders import layer_of, LENGTH_M, NOMINAL, WIDTH
import numpy as np
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.learning.delay import Delay
from bpc_perception.core.learning.layer_record import LayerRecord
from bpc_perception.core.learning.learner import Learner

CONFIG = AdviceConfig()
GAIN = float(np.log(WIDTH**2 / NOMINAL))
COUNT = 1200
PLACE = np.linspace(0, LENGTH_M, COUNT)


def error(record: LayerRecord) -> float:
    """Root of the mean square of the deviation from the wanted width.

    The first millimetres are what an advance is for, which these layers do not have.
    """
    seen = record.place > 2e-3
    return float(np.sqrt(np.mean((record.width / record.wanted - 1)[seen]**2)))


def print_layers(delay: Delay, gain: Array | float, layers: int = 4,
                 learner: Learner | None = None) -> list[float]:
    learner = learner or Learner(CONFIG, GAIN)
    factor, errors = np.ones(COUNT), []
    for number in range(layers):
        record = layer_of(delay, factor, gain, noise=0.01, seed=number, number=number)
        errors.append(error(record))
        assert learner.take(record)
        schedule = learner.schedule()
        assert schedule is not None
        factor = schedule.at(PLACE)
    return errors


@pytest.mark.parametrize('gain', [0.6, 0.8, 1.25, 1.8])
def test_a_wrong_gain_is_corrected_in_the_second_layer(gain: float) -> None:
    first, second, third, _ = print_layers(Delay(0.1, 0.0), gain)
    assert second < 0.25 * first
    assert third < 0.25 * first


def test_a_drift_along_the_layer_is_corrected() -> None:
    first, _, third, _ = print_layers(Delay(0.1, 0.0), np.linspace(1, 0.6, COUNT))
    assert third < 0.25 * first


@pytest.mark.parametrize('lag', [1.0, 3.0])
def test_the_begin_behind_a_lag_is_corrected(lag: float) -> None:
    first, second, third, _ = print_layers(Delay(lag, 0.1), 1.0)
    assert second < 0.7 * first
    assert third < 0.7 * first


@pytest.mark.parametrize('wrong', [0.5, 2.0])
def test_it_converges_with_a_wrong_lag(wrong: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('bpc_perception.core.learning.learner.fit_delay',
                        lambda _: Delay(1.0 * wrong, 0.1))
    errors = print_layers(Delay(1.0, 0.1), 0.8, layers=6)
    assert max(errors[1:]) < 0.7 * errors[0]
    assert errors[-1] <= 1.1 * min(errors)


def test_no_factor_passes_its_limits() -> None:
    for seed in range(60):
        rng = np.random.default_rng(seed)
        learner = Learner(CONFIG, GAIN + rng.normal(0, 1))
        for number in range(3):
            factor = np.exp(rng.normal(0, 0.5) + rng.normal(0, 0.5, COUNT))
            record = layer_of(Delay(*rng.uniform(0.02, 3, 2)), factor, float(rng.lognormal()),
                              noise=float(rng.uniform(0, 0.5)), seed=seed, number=number)
            hidden = rng.random(COUNT) < rng.uniform(0, 1.2)
            learner.take(replace(record, width=np.where(hidden, np.nan, record.width)))
        schedule = learner.schedule()
        if schedule is None:
            continue
        assert np.isfinite(schedule.factor).all()
        assert schedule.factor.min() >= CONFIG.minimum_scale
        assert schedule.factor.max() <= CONFIG.maximum_scale
        assert 0 <= schedule.advance <= 1
        assert 0 <= schedule.retreat <= 1


def test_a_gap_asks_for_no_ink() -> None:
    record = layer_of(Delay(0.1, 0.0), np.ones(COUNT), 1.0, noise=0.01)
    gap = (PLACE > 0.1) & (PLACE < 0.12)
    learner = Learner(CONFIG, GAIN)
    assert learner.take(replace(record, width=np.where(gap, 0.0, record.width)))
    schedule = learner.schedule()
    assert schedule is not None
    assert schedule.at(PLACE[gap]).max() < 1.03


def test_what_is_hardly_seen_teaches_nothing() -> None:
    record = layer_of(Delay(0.1, 0.0), np.ones(COUNT), 0.7)
    learner = Learner(CONFIG, GAIN)
    assert not learner.take(replace(record, width=np.where(PLACE < 0.2, np.nan, record.width)))
    assert learner.schedule() is None


def test_another_path_teaches_nothing() -> None:
    learner = Learner(CONFIG, GAIN)
    assert learner.take(layer_of(Delay(0.1, 0.0), np.ones(COUNT), 0.7))
    assert learner.take(layer_of(Delay(0.1, 0.0), np.ones(COUNT), 0.7, number=1))
    assert not learner.take(layer_of(Delay(0.1, 0.0), np.ones(COUNT), 0.7, offset=(0.0, 5e-3)))


def test_strokes_begin_and_end_earlier() -> None:
    # Three strokes of 60 mm, with 20 mm of travel behind each.
    stroke = np.mod(PLACE, 0.08) < 0.06
    record = layer_of(Delay(0.2, 0.3), stroke.astype(float), 1.0)
    learner = Learner(CONFIG, GAIN)
    travel = ~stroke
    record = replace(record, ooze=travel & (record.width > 0),
                     width=np.where(travel & (record.width > 0), np.nan, record.width))
    learner.take(record)
    schedule = learner.schedule()
    assert schedule is not None
    # The bead is half as wide where a quarter of its ink arrives.
    assert schedule.advance == pytest.approx(0.3 + 0.2 * np.log(4 / 3), abs=0.1)
    assert 0.3 < schedule.retreat < 0.3 + 0.2 * np.log(100)


def test_speed_of_the_path_is_kept() -> None:
    learner = Learner(CONFIG, GAIN)
    learner.take(layer_of(Delay(0.02, 0.0), np.ones(COUNT), 0.8))
    schedule = learner.schedule()
    assert schedule is not None
    middle = (schedule.place > 0.02) & (schedule.place < LENGTH_M - 0.02)
    np.testing.assert_allclose(schedule.volume[middle], NOMINAL / 0.8, rtol=0.03)
