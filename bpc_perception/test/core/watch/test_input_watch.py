"""Silence of an input is seen when it is due, and not before."""

from __future__ import annotations

import pytest

from bpc_perception.core.config import WatchConfig
from bpc_perception.core.watch.input_watch import InputWatch, Level

CONFIG = WatchConfig(warn_after=0.2, error_after=1.0)


def heard_at(*times: float, paced: bool = False, config: WatchConfig = CONFIG) -> InputWatch:
    watch = InputWatch(config, paced)
    for time in times:
        watch.heard(time)
    return watch


@pytest.mark.parametrize(('now', 'level'), [
    (10.0, Level.OK), (10.19, Level.OK), (10.21, Level.WARN), (10.99, Level.WARN),
    (11.01, Level.ERROR), (1000.0, Level.ERROR)])
def test_a_stream_is_due_all_the_time(now: float, level: Level) -> None:
    assert heard_at(9.9, 10.0).level(now) == level


@pytest.mark.parametrize(('times', 'now', 'level'), [
    ((1, 3, 5, 7), 9.1, Level.OK), ((1, 3, 5, 7), 9.3, Level.WARN),
    ((1, 3, 5, 7), 10.1, Level.ERROR),
    ((1, 3, 5, 8.5), 12.1, Level.OK),  # as long as the longest pause
    ((1, 3, 5), 100.0, Level.OK),  # a pace shows in three pauses
    ((1, 3, 5, 10), 100.0, Level.OK)])  # by hand
def test_captures_are_due_after_their_pace(times: tuple[float, ...], now: float,
                                           level: Level) -> None:
    assert heard_at(*times, paced=True).level(now) == level


def test_what_comes_again_is_well_again() -> None:
    watch = heard_at(1.0)
    assert watch.level(5.0) == Level.ERROR
    watch.heard(5.0)
    assert watch.level(5.1) == Level.OK


def test_what_never_came_is_stale_unless_it_comes_when_asked_for() -> None:
    assert heard_at().level(100.0) == Level.STALE
    assert heard_at().age(100.0) is None
    assert heard_at(paced=True).level(100.0) == Level.OK


@pytest.mark.parametrize('config', [
    WatchConfig(warn_after=0.0), WatchConfig(warn_after=0.2, error_after=0.0)])
def test_thresholds_of_0_are_none(config: WatchConfig) -> None:
    expected = Level.WARN if config.warn_after else Level.OK
    assert heard_at(1.0, config=config).level(100.0) == expected
