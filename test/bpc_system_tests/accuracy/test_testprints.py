"""Test prints on the simulator: what is judged, against the law of ink and extruder."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.testprints.flat import fusion
from bpc_perception.core.testprints.judge import judge
from bpc_perception.core.testprints.plan import TestPrint
from bpc_perception.core.testprints.setup import round_width, Setup
from bpc_perception.core.testprints.stacked import lattice
from bpc_perception.core.testprints.sweep import lines
from bpc_sim.ink.extrusion import ExtruderBehaviour
from bpc_sim.printer.design_job import design_job
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.recorded_path import recorded_path

pytestmark = [pytest.mark.accuracy]

MM, START_NS = 1e-3, 10**18
SETUP = Setup(1 * MM, (100 * MM, 100 * MM))
SPREADING, DEAD_TIME = 1.6, 0.15
BEHAVIOUR = ExtruderBehaviour(lag=1e-3, dead_time=DEAD_TIME, noise=0.0, spreading=SPREADING)


def job_of(test: TestPrint) -> PrintJob:
    return design_job(test.design, test.plans, BEHAVIOUR)


def measured(job: PrintJob, *times: float) -> ThicknessProfile:
    """What captures at times [s] and at the end tell."""
    path, memory = recorded_path(job, START_NS), PrintMemory()
    for number, time in enumerate((*times, job.duration)):
        capture = job.capture(time, number, START_NS + round(1e9 * time))
        profile = measure(capture, path, job.view.T_base_camera, ThicknessConfig(), number, memory)
    return profile


def test_a_sweep_and_a_planted_lag() -> None:
    test = lines(SETUP, [4e-9, 7e-9], [5 * MM, 12 * MM])
    sweep = judge(test, measured(job_of(test))).sweep
    assert sweep is not None
    off = []
    for result in sweep.lines:
        width = SPREADING * round_width(result.plan.flow, result.plan.speed)
        area = result.plan.flow / result.plan.speed
        height = 3 / 2 * area / width  # of a parabola
        off += [(result.width - width) / result.width_sigma,
                (result.height - height) / result.height_sigma,
                (result.area - area) / result.area_sigma]
        assert result.width == pytest.approx(width, rel=0.015)
        assert result.area == pytest.approx(area, rel=0.06)
    assert np.isfinite(off).all()
    assert np.mean(np.abs(off) < 2) >= 0.9
    for lag in (sweep.start, sweep.stop):
        assert lag.lines >= 5
        assert lag.sigma < 0.03
        assert lag.time == pytest.approx(DEAD_TIME, abs=2 * lag.sigma)


def test_where_strands_fuse() -> None:
    test = fusion(SETUP, [3.2 * MM, 2.6 * MM, 2.1 * MM, 1.3 * MM, 1.1 * MM])
    found = judge(test, measured(job_of(test))).findings[0]
    assert found.quantity == 'fusing_distance'
    assert 1.3 * MM < found.value < 2.1 * MM
    assert found.value == pytest.approx(SPREADING * 1 * MM, abs=2 * found.sigma)


def test_the_pores_of_a_lattice() -> None:
    test = lattice(SETUP, 3, 5 * MM)
    job = job_of(test)
    # Once between the layers, while the nozzle is lifted away from the first.
    ink = job.flow_rate(np.arange(0.0, job.duration, 0.01)) > 0
    ends = np.flatnonzero(ink[:-1] & ~ink[1:]) * 0.01
    profile = measured(job, float(ends[3]) + 0.3)
    found = {finding.quantity: finding for finding in judge(test, profile).findings
             if finding.of == 'print'}
    side = (5 - SPREADING) * MM
    assert found['pore_area'].value == pytest.approx(side**2, rel=0.03)
    assert found['pore_area'].samples == 4
    assert found['pore_printability'].value == pytest.approx(1, abs=0.02)
    assert found['mesh_printability'].value == pytest.approx(100 * side**2 / (4 * MM)**2, abs=2.5)
    assert found['filament_to_nozzle_ratio'].value == pytest.approx(SPREADING, abs=0.04)
