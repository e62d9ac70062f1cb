"""How long prints take, said before they begin."""

from __future__ import annotations

import time

import pytest

from bpc_perception.cli.parts.terminal import Terminal
from bpc_sim.cli.parts.simulated_print import announce
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.closed_loop.situations import SITUATIONS
from bpc_sim.printer.scenarios import SCENARIOS

TICK_S = 0.02


@pytest.mark.parametrize('name', SCENARIOS)
def test_a_print_of_every_scenario_is_over_after_its_duration(name: str) -> None:
    job = SCENARIOS[name](10e-3)
    end = job.duration - job.dwell_after
    assert job.laid(end) == pytest.approx(job.length, abs=1e-9)
    assert job.laid(end - TICK_S) < job.length - 1e-6
    assert not job.extruding(end + TICK_S)


@pytest.mark.parametrize('name', ['speed_changes', 'under_delivery'])
def test_a_print_in_a_closed_loop_is_over_after_its_duration(name: str) -> None:
    assert name in SITUATIONS
    print_ = ClosedLoopJob.named(name, 0, 10e-3)
    progress, ticks = 0.0, 0
    while progress < print_.job.duration:  # as the printer goes on
        extruding = bool(print_.job.extruding(progress))
        pace = print_.speed(float(print_.job.laid(progress))) / print_.job.speed
        progress += TICK_S * (pace if extruding else 1.0)
        ticks += 1
    assert ticks * TICK_S == pytest.approx(print_.duration, abs=3 * TICK_S)


def test_what_is_said_is_the_time_that_is_left(capsys: pytest.CaptureFixture[str]) -> None:
    announce(0.05, 3e-3, time.time_ns() + 26 * 10**9, Terminal())
    assert capsys.readouterr().out == (
        '50 mm at 3 mm/s: done in 26 s; Ctrl-C ends it before.\n')
