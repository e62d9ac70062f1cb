"""The study of windows: its laws against textbooks, and a few of its inks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bpc_perception.core.window.sweep import Drive
from bpc_sim.studies.windows.camera import measured, print_job
from bpc_sim.studies.windows.ink_law import draw_ink, InkLaw
from bpc_sim.studies.windows.outcome import Outcome
from bpc_sim.studies.windows.printed_sweep import measure_sweep, print_sweep
from bpc_sim.studies.windows.study import rows, WINDOWS

INK = InkLaw(Drive.PRESSURE, consistency=100.0, index=1.0, yield_stress=0.0, radius=0.5e-3,
             length=0.01, delivered=0.9, leak=0.1, swell=0.1, swell_exponent=0.3, aspect=0.5,
             pull_exponent=0.0, breaking_pull=3.0, lag=0.1, scatter=0.01)


def test_a_newtonian_ink_flows_after_hagen_and_poiseuille() -> None:
    pressure = 5e4
    poiseuille = np.pi * INK.radius**4 * pressure / (8 * INK.consistency * INK.length)
    assert INK.flow(pressure) == pytest.approx(poiseuille, rel=1e-9)
    assert INK.command(poiseuille) == pytest.approx(pressure, rel=1e-6)


def test_a_power_law_ink_flows_with_a_power_of_the_pressure() -> None:
    ink = replace(INK, index=0.4)
    assert ink.flow(8e4) / ink.flow(4e4) == pytest.approx(2**2.5, rel=1e-9)
    shear = 4 * ink.flow(4e4) / (np.pi * ink.radius**3) * (3 * 0.4 + 1) / (4 * 0.4)
    assert ink.consistency * shear**0.4 == pytest.approx(4e4 * ink.radius / (2 * ink.length))


def test_below_its_yield_stress_nothing_flows() -> None:
    ink = replace(INK, yield_stress=100.0)
    least = 100.0 * 2 * ink.length / ink.radius
    assert ink.flow(0.99 * least) == 0
    assert ink.breaks(0.0, 0.01)
    assert 0 < ink.flow(1.2 * least) < INK.flow(0.2 * least)


def test_a_bead_of_aspect_a_half_is_half_a_circle_with_all_of_the_flow() -> None:
    flow, speed = 4e-9, 0.01
    width, height = INK.width(flow, speed), INK.height(flow, speed)
    assert width == pytest.approx(np.sqrt(8 / np.pi * flow / speed), rel=1e-9)
    assert height == pytest.approx(width / 2)
    flat = replace(INK, aspect=0.2)
    assert flat.height(flow, speed) / flat.width(flow, speed) == pytest.approx(0.2)
    # The segment of a circle through both feet and the top.
    w, h = flat.width(flow, speed), flat.height(flow, speed)
    radius = (w**2 / 4 + h**2) / (2 * h)
    angle = np.arcsin(w / 2 / radius)
    assert radius**2 * (angle - np.sin(angle) * np.cos(angle)) == pytest.approx(flow / speed)


def test_a_strand_that_is_pulled_too_fast_breaks() -> None:
    ink = replace(INK, swell=0.0)
    flow = np.pi * ink.radius**2 * 0.01  # as fast as 10 mm/s
    assert ink.pull(flow, 0.01) == pytest.approx(1)
    assert not ink.breaks(flow, 0.0299)
    assert ink.breaks(flow, 0.0301)


def test_a_line_builds_up_with_the_lag() -> None:
    s = np.array((0.001, 0.1))
    width = INK.along(4e-9, 0.01, s)
    assert width[0] == pytest.approx(INK.width(4e-9 * (1 - np.exp(-1)), 0.01))
    assert width[1] == pytest.approx(INK.width(4e-9, 0.01), rel=1e-9)


def test_measured_lines_are_as_far_off_as_their_sigma_says() -> None:
    rng = np.random.default_rng(2001)
    ink = draw_ink(rng)
    printed = print_sweep(ink, rng)
    off = [(line.width - true.width) / line.width_sigma for _ in range(20) for line, true in
           zip(measure_sweep(ink, printed, rng), printed, strict=True) if true.width > 0]
    assert np.std(off) == pytest.approx(1, abs=0.12)


def test_the_camera_sees_lines_as_they_are_laid() -> None:
    rng = np.random.default_rng(2002)
    ink = draw_ink(rng)
    lines = print_sweep(ink, rng)[:5]
    lines[2] = replace(lines[2], width=np.nan)
    for line, (width, sigma) in zip(lines, measured(print_job(ink, lines, rng)), strict=True):
        if np.isnan(line.width):
            assert np.isnan(width)
        elif np.isfinite(width):  # not hidden by the nozzle
            assert width == pytest.approx(line.width, rel=0.02)
            assert 0 < sigma < 0.05e-3


@pytest.mark.accuracy
def test_recommended_settings_of_a_few_inks() -> None:
    (*_, both, camera) = WINDOWS.run(8, processes=1)
    assert (both['by'], camera['by']) == ('both', 'camera')
    assert both['within_3_percent'] >= 7
    assert both['mean_error_percent'] < 1
    assert both['lines_covered_percent'] > 85
    assert camera['within_3_percent'] == camera['inks'] == 1


def test_rows_count_refusals_as_not_met() -> None:
    told = Outcome('flow', 0.01, True, 0.9, 1.0, 1.0, 0.97, 0.0)
    far = Outcome('pressure', -0.04, False, 0.5, 0.9, 0.8)
    table = {row['by']: row for row in rows([[told], [far, Outcome('camera', refusal='few')]])}
    assert (table['both']['inks'], table['both']['within_3_percent']) == (2, 1)
    assert table['both']['mean_covered_percent'] == 50
    assert table['both']['worst_percent'] == pytest.approx(4)
    assert table['camera']['refused'] == 1
