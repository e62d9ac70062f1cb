"""An extruder that says one thing and does another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import path_through
import pytest

from bpc_perception.core.watch.extruder_flag import extruder_contradiction

MM = 1e-3
COUNT = 101
PATH = path_through(np.column_stack((np.arange(COUNT) * 0.5 * MM, np.zeros((COUNT, 2)))))
PUSHING, STANDING, RETRACTING = 1e-4, 0.0, -1e-4
ALL = np.ones(COUNT, bool)


@pytest.mark.parametrize(('extruding', 'velocity', 'words'), [
    (ALL, PUSHING, ''),
    (~ALL, STANDING, ''),
    (~ALL, RETRACTING, ''),
    (~ALL, np.nan, ''),
    (ALL, np.nan, ''),
    (~ALL, PUSHING, 'found it moving along 50 mm'),
    (ALL, STANDING, 'found it standing or going back along 50 mm'),
    (ALL, RETRACTING, 'found it standing or going back along 50 mm'),
    (np.arange(COUNT) < 50, PUSHING, 'found it moving along 26 mm')])
def test_plunger_and_extruding_say_the_same(extruding: np.ndarray, velocity: float,
                                            words: str) -> None:
    path = replace(PATH, extruding=extruding, extruder_known=ALL,
                   plunger_velocity=np.full(COUNT, velocity), flow_rate=np.full(COUNT, np.nan))
    found = extruder_contradiction(path)
    assert words in found
    assert bool(found) == bool(words)


def test_what_is_short_is_a_state_that_came_late() -> None:
    velocity = np.where(np.arange(COUNT) < 8, STANDING, PUSHING)  # 3.5 mm
    assert extruder_contradiction(replace(
        PATH, extruding=ALL, extruder_known=ALL, plunger_velocity=velocity)) == ''


def test_a_state_that_is_not_known_contradicts_nothing() -> None:
    assert extruder_contradiction(replace(
        PATH, extruding=~ALL, extruder_known=~ALL,
        plunger_velocity=np.full(COUNT, PUSHING))) == ''


def test_where_ink_flows_without_a_plunger_it_need_not_move() -> None:
    assert extruder_contradiction(replace(
        PATH, extruding=ALL, extruder_known=ALL, plunger_velocity=np.zeros(COUNT),
        flow_rate=np.full(COUNT, 1e-8))) == ''
