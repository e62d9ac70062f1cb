"""Sources whose stamps are by a clock behind that of the others."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.watch.clocks import Clocks, SteadyClocks

SECOND = 10**9
POSE, STATE, IMAGE = 'pose', 'state', 'image'


def lags(late: float, camera_late: float = 0.0, held_up: tuple[float, float] = (0, 0),
         recorder: float = 0.0, seconds: float = 4.0) -> tuple[float, float]:
    """Return how far poses and states are behind in the end, of which states come late [s].

    Poses are held up between two times, and then come at once.
    """
    clocks = Clocks({IMAGE})
    for tick in range(int(seconds * 50)):
        now = tick / 50
        log_ns = round((now + recorder) * SECOND)
        if held_up[0] <= now < held_up[1]:
            pass
        elif held_up[1] and abs(now - held_up[1]) < 0.01:
            for early in np.arange(held_up[0], held_up[1], 0.02):
                clocks.note(POSE, log_ns + round(early * 1e3), round(early * SECOND))
        else:
            clocks.note(POSE, log_ns, round(now * SECOND))
        clocks.note(STATE, log_ns + 1000, round((now - late) * SECOND))
        if tick % 50 == 0:
            clocks.note(IMAGE, log_ns + 2000, round((now - camera_late) * SECOND))
    return clocks.lag(POSE, log_ns), clocks.lag(STATE, log_ns)


@pytest.mark.parametrize(('late', 'lag'), [(0.0, 0.0), (0.25, 0.0), (0.5, 0.5), (2.0, 2.0)])
@pytest.mark.parametrize('camera_late', [0.0, 1.5])
def test_a_source_is_behind_that_is_later_than_the_other(late: float, lag: float,
                                                         camera_late: float) -> None:
    assert lags(late, camera_late) == (0.0, pytest.approx(lag, abs=0.01))


def test_a_source_that_is_ahead_is_no_measure_for_the_other() -> None:
    assert lags(-0.5) == (0.0, 0.0)


def test_what_was_held_up_for_a_while_is_not_behind() -> None:
    assert lags(0.0, held_up=(2.0, 3.9)) == (0.0, 0.0)


def test_the_clock_of_the_recorder_may_be_any() -> None:
    assert lags(0.0, recorder=3600.0) == (0.0, 0.0)


@pytest.mark.parametrize(('seconds', 'behind'), [(1.5, False), (3.0, True)])
def test_live_it_has_to_stay_behind(seconds: float, behind: bool) -> None:
    """Messages of a while may come at once, one topic after the other."""
    clocks, found = SteadyClocks(), 0.0
    for tick in range(int(seconds * 50)):
        now_ns = tick * SECOND // 50
        assert clocks.behind(POSE, now_ns, now_ns) == 0.0
        found = clocks.behind(STATE, now_ns, now_ns - SECOND // 2)
    assert found == (pytest.approx(0.5) if behind else 0.0)
