"""Printability of simulated lattices whose pores are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.printability.assess import assess, Conditions, Printability
from bpc_sim.studies.layers_study import measure_job, print_job

pytestmark = [pytest.mark.accuracy]

PITCH_M, WIDTH_M = 4e-3, 1.3e-3


@pytest.fixture(scope='module', params=[1.0, 0.85])
def measured(request: pytest.FixtureRequest) -> tuple[float, Printability]:
    """A lattice of four layers with strands of this share of their width, and what is told."""
    job = print_job('lattice', 10.0, 2)
    width = job.commanded.profile
    job = replace(job, printed_width=lambda s: request.param * width(s))
    profile = measure_job(job)
    return request.param * WIDTH_M, assess(
        profile, Conditions(target=np.full(len(profile), WIDTH_M)))


def test_areas_and_shapes(measured: tuple[float, Printability]) -> None:
    width, found = measured
    true = (PITCH_M - width) ** 2
    told = [pore for pore in found.pores if np.isfinite(pore.area)]
    assert len(found.pores) == 3 * 16
    # The nozzle hides a part of some strands until the next layer covers them.
    assert len(told) >= 0.75 * len(found.pores)
    error = np.array([pore.area for pore in told]) / true - 1
    assert np.mean(np.abs(error) < 0.03) > 0.9
    assert np.abs(error).max() < 0.04
    assert np.abs(error.mean()) < 0.01
    for pore in told:
        assert pore.printability == pytest.approx(1, abs=0.02), pore
        assert pore.ideal == pytest.approx(1, abs=0.002)
    off = np.array([(pore.area - true) / pore.area_sigma for pore in told])
    assert np.mean(np.abs(off) < 2) > 0.9
    assert np.mean([pore.mesh_printability for pore in told]) == pytest.approx(
        100 * true / (PITCH_M - WIDTH_M) ** 2, abs=2)


def test_strands(measured: tuple[float, Printability]) -> None:
    width, found = measured
    values = {metric.name: metric.value for metric in found.metrics if metric.of == 'print'}
    assert values['width'] == pytest.approx(width, rel=0.02)
    assert values['width_accuracy'] == pytest.approx(100 * width / WIDTH_M, abs=2)
    assert values['continuity'] == pytest.approx(1, abs=1e-3)
    assert values['stability'] > 0.96
    assert 1 <= values['uniformity'] < 1.005
