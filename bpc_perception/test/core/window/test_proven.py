"""Which settings lines have proven: those between good lines, and not beside one that failed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from swept_lines import FLOWS, half_circle, MM, MM3, SPEEDS, sweep

from bpc_perception.core.window.proven import Proven
from bpc_perception.core.window.sweep import Drive, WindowError


def proven_by(lines):
    good = tuple(line for line in lines if math.isfinite(line.width))
    failed = tuple(line for line in lines if not math.isfinite(line.width))
    return Proven(Drive.FLOW, good, failed)


def holds(proven, flow, speed):
    return bool(proven.holds(np.array([flow * MM3]), np.array([speed * MM]))[0])


def breaking(flow: float, speed: float) -> float:
    """The corner of least flow and highest speed fails."""
    return math.nan if speed / flow > 15 else half_circle(flow, speed)


def test_the_grid_itself_is_proven_and_nothing_beyond() -> None:
    proven = proven_by(sweep())
    assert all(holds(proven, flow, speed) for flow in FLOWS for speed in SPEEDS)
    assert holds(proven, 1.3, 17)
    for flow, speed in ((0.98, 10), (4.1, 10), (2, 4.9), (2, 20.4)):
        assert not holds(proven, flow, speed)


def test_a_corner_that_failed_is_cut_off() -> None:
    proven = proven_by(sweep(breaking))
    assert len(proven.failed) == 1
    assert holds(proven, FLOWS[1], SPEEDS[4])
    assert holds(proven, FLOWS[0], SPEEDS[3])
    # The straight way between both, in logarithms, and a little to either side of it.
    flow, speed = np.sqrt(FLOWS[0] * FLOWS[1]), np.sqrt(SPEEDS[3] * SPEEDS[4])
    assert holds(proven, flow * 1.02, speed / 1.02)
    assert not holds(proven, flow / 1.02, speed * 1.02)


def test_settings_nearer_to_a_line_that_failed_are_not() -> None:
    def failing(flow: float, speed: float) -> float:
        inner = math.isclose(flow, FLOWS[2]) and math.isclose(speed, SPEEDS[2])
        return math.nan if inner else half_circle(flow, speed)

    proven = proven_by(sweep(failing))
    ratio = SPEEDS[3] / SPEEDS[2]
    assert not holds(proven, FLOWS[2], SPEEDS[2] * ratio**0.48)
    assert holds(proven, FLOWS[2], SPEEDS[2] * ratio**0.52)
    assert not holds(proven, FLOWS[2] * ratio**0.48, SPEEDS[2])
    assert holds(proven, FLOWS[2] * ratio**0.52, SPEEDS[2])


def test_a_setting_that_failed_once_is_not() -> None:
    once = sweep()
    again = sweep(lambda *_: math.nan, flows=(2.0,), speeds=(10.0,))
    assert holds(proven_by(once), 2, 10)
    assert not holds(proven_by([*once, *again]), 2, 10)
    assert holds(proven_by([*once, *again]), FLOWS[3], 10)


def test_lines_on_one_curve_prove_nothing() -> None:
    lines = [each for flow in (1, 2, 3, 4) for each in sweep(flows=(flow,), speeds=(5 * flow,))]
    with pytest.raises(WindowError, match='found 4 on one curve; print others beside it'):
        proven_by(lines)
