"""From the stepper driver's numbers to metres and litres, counted by hand."""

from __future__ import annotations

import math

import pytest

from bpc_perception.core.config import PlungerConfig
from bpc_perception.core.extruder.plunger import Plunger
from bpc_perception.core.extruder.tic import TicState

# 200 steps a turn of 1 mm: in mode 3, an eighth, a microstep is 0.625 micrometres.
CONFIG = PlungerConfig(lead=1e-3, bore=0.02)


def test_microsteps_become_metres() -> None:
    # 16000000 microsteps in 10000 s are 1600 a second: one turn, one millimetre.
    motion = Plunger(CONFIG).motion(TicState(None, 3200, 16_000_000, 3))
    assert motion.velocity == pytest.approx(1e-3)
    assert motion.position == pytest.approx(2e-3)
    assert motion.flow_rate == pytest.approx(math.pi / 4 * 0.02**2 * 1e-3)
    assert motion.extruding
    assert not motion.position_uncertain


def test_a_reversed_drive() -> None:
    config = PlungerConfig(lead=1e-3, bore=0.02, reversed=True)
    pushing = Plunger(config).motion(TicState(None, -3200, -16_000_000, 3))
    assert (pushing.extruding, pushing.velocity, pushing.position) == (
        True, pytest.approx(1e-3), pytest.approx(2e-3))
    retracting = Plunger(config).motion(TicState(None, 0, 16_000_000, 3))
    assert not retracting.extruding
    assert retracting.flow_rate < 0


def test_a_change_of_step_mode_moves_no_plunger() -> None:
    plunger = Plunger(CONFIG)
    plunger.motion(TicState(None, 3200, 0, 3))  # 2 mm
    changed = plunger.motion(TicState(None, 3200, 0, 5))
    assert changed.position == pytest.approx(2e-3)
    further = plunger.motion(TicState(None, 9600, 6400 * 10000, 5))  # a turn on, at one a second
    assert further.position == pytest.approx(3e-3)
    assert further.velocity == pytest.approx(1e-3)


def test_what_is_not_known_is_not_a_number() -> None:
    motion = Plunger(PlungerConfig()).motion(TicState(None, 3200, 1, 3, misc_flags=2))
    assert math.isnan(motion.velocity)
    assert math.isnan(motion.position)
    assert math.isnan(motion.flow_rate)
    assert motion.extruding  # the sign is known
    assert motion.position_uncertain
