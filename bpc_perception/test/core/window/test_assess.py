"""From lines to a recommended setting, and why there is none."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
import pytest
from swept_lines import FLOWS, half_circle, MM, MM3, SPEEDS, sweep

from bpc_perception.core.window.assess import find_window
from bpc_perception.core.window.sweep import WindowError
from bpc_perception.core.window.window import MET, Wanted

TARGET = 0.7  # mm
FLOW_PER_SPEED = math.pi / 8 * TARGET**2  # mm², of half a circle


def wanted(target=TARGET, tolerance=0.1, **others):
    return Wanted(target * MM, tolerance, **others)


def test_the_recommended_setting_has_the_width_by_geometry() -> None:
    found = find_window(sweep(scatter=0.01, seed=1), wanted())
    flow, speed = found.drive / MM3, found.speed / MM
    assert half_circle(flow, speed) == pytest.approx(TARGET, rel=0.01)
    assert abs(half_circle(flow, speed) / TARGET - 1) < 3 * found.expected['width'].mean_sigma[0]
    assert found.expected['width'].value[0] == pytest.approx(TARGET * MM, rel=1e-3)
    assert found.chance > 0.999


def test_a_speed_that_is_wanted_is_taken() -> None:
    found = find_window(sweep(), wanted(speed=12 * MM))
    assert found.speed == 12 * MM
    assert found.drive / MM3 == pytest.approx(12 * FLOW_PER_SPEED, rel=1e-3)


def test_the_window_is_where_the_law_is_within_tolerance() -> None:
    found = find_window(sweep(), wanted())
    speed, flow = np.meshgrid(found.grid.speed / MM, found.grid.drive / MM3, indexing='ij')
    width = np.sqrt(8 / np.pi * flow / speed)
    within = np.abs(width / TARGET - 1) < 0.1
    sure = np.abs(np.abs(width / TARGET - 1) - 0.1) > 2e-3
    np.testing.assert_array_equal(found.grid.met[sure & found.grid.proven],
                                  within[sure & found.grid.proven])
    assert found.grid.met.any()
    assert not found.grid.met[~found.grid.proven].any()


def test_scatter_beyond_the_tolerance_leaves_no_window_and_says_how_sure_it_is() -> None:
    found = find_window(sweep(scatter=0.05, seed=2), wanted(tolerance=0.03))
    assert not found.grid.met.any()
    # A normal law with 5 % of spread is within 3 % in 45 of 100 lines.
    assert found.chance == pytest.approx(0.45, abs=0.12)
    assert found.chance < MET


def test_height_area_and_delivery() -> None:
    lines = [replace(line, area=0.9 * line.flow / line.speed, height=line.width / 2)
             for line in sweep(lambda flow, speed: half_circle(0.9 * flow, speed))]
    found = find_window(lines, wanted())
    assert found.expected['height'].value[0] == pytest.approx(TARGET * MM / 2, rel=1e-3)
    assert found.expected['area'].value[0] == pytest.approx(FLOW_PER_SPEED * MM**2, rel=1e-3)
    assert found.delivered[0] == pytest.approx(0.9, rel=1e-3)
    assert set(find_window(sweep(), wanted()).models) == {'width'}
    assert math.isnan(find_window(sweep(), wanted()).delivered[0])


def test_only_a_temperature_that_was_printed_with_is_taken() -> None:
    def at(kelvin: float):
        share = math.exp(1000 * (1 / 300 - 1 / kelvin))
        return [replace(line, temperature=kelvin) for line in
                sweep(lambda flow, speed: share * half_circle(flow, speed))]

    lines = [*at(300.0), *at(310.0)[:12]]
    found = find_window(lines, wanted())
    assert found.wanted.temperature == pytest.approx(300)
    assert found.drive / found.speed / MM**2 == pytest.approx(FLOW_PER_SPEED, rel=0.003)
    warm = find_window(lines, wanted(0.9, temperature=310.4))
    share = math.exp(1000 * (1 / 300 - 1 / 310))
    assert half_circle(warm.drive / MM3, warm.speed / MM) * share == pytest.approx(0.9, rel=0.003)
    with pytest.raises(WindowError, match=r'\(26.9, 36.9 °C\), found 46.9 °C'):
        find_window(lines, wanted(temperature=320.0))
    with pytest.raises(WindowError, match=r'found none of line 1; add it'):
        find_window([replace(lines[0], temperature=math.nan), *lines[1:]], wanted())


@pytest.mark.parametrize(('target', 'nearest', 'more'), [
    (1.5, 'line 5 \\(4 mm³/s with 5 mm/s, 1.427 mm\\)', 'more flow per speed'),
    (0.3, 'line 21 \\(1 mm³/s with 20 mm/s, 0.357 mm\\)', 'less flow per speed')])
def test_nothing_is_told_beyond_the_widths_of_the_sweep(target, nearest, more) -> None:
    with pytest.raises(WindowError, match=f'nearest is {nearest}: print lines with {more}'):
        find_window(sweep(), wanted(target))


def test_nothing_is_told_beyond_the_speeds_of_the_sweep() -> None:
    with pytest.raises(WindowError, match=r'between 5 mm/s and 20 mm/s.*found 25 mm/s; print'):
        find_window(sweep(), wanted(speed=25 * MM))
    with pytest.raises(WindowError, match=r'with 20 mm/s, found 1\.200 mm'):
        find_window(sweep(), wanted(1.2, speed=20 * MM))


def test_a_width_that_only_lines_beside_failed_ones_have_is_refused() -> None:
    def failing(flow: float, speed: float) -> float:
        return math.nan if speed / flow > 9 else half_circle(flow, speed)

    lines = sweep(failing)
    found = find_window(lines, wanted())
    assert len(found.proven.failed) == 6
    with pytest.raises(WindowError, match='print lines'):
        find_window(lines, wanted(0.36))


def test_lines_that_would_have_the_width_are_named_where_they_have_none() -> None:
    """As those that are too narrow for the camera: to print them again would not help."""
    def unseen(flow: float, speed: float) -> float:
        width = half_circle(flow, speed)
        return math.nan if width < 0.45 else width

    narrow = [line.name for line in sweep() if line.width < 0.45 * MM]
    assert len(narrow) == 3
    with pytest.raises(WindowError, match=f'find out why {", ".join(narrow)}, expected beyond, '
                       'have no width, or print lines with less flow per speed'):
        find_window(sweep(unseen), wanted(0.37))
    with pytest.raises(WindowError, match=r'mm\): print lines with more'):
        find_window(sweep(unseen), wanted(1.5))


def test_too_few_flows_or_speeds_name_the_lines_to_print() -> None:
    with pytest.raises(WindowError, match=r'3 different values of speed or more, found 2 '
                       r'\(5 mm/s, 20 mm/s\); print 1 mm³/s with 10 mm/s, 2 mm³/s with 10 mm/s, '
                       r'4 mm³/s with 10 mm/s'):
        find_window(sweep(flows=FLOWS, speeds=(5, 20)), wanted())
    with pytest.raises(WindowError, match=r'values of flow or more, found 1 \(2 mm³/s\); print '
                       r'1.33 mm³/s with 5 mm/s'):
        find_window(sweep(flows=(2,), speeds=SPEEDS), wanted())
    with pytest.raises(WindowError, match='found 7; print 4 mm³/s with 10 mm/s, 4 mm³/s with 20 '
                       'mm/s'):
        find_window([line for line in sweep(flows=(1, 2, 4), speeds=(5, 10, 20))
                     if not (line.flow > 3e-9 and line.speed > 6e-3)], wanted())
    with pytest.raises(WindowError, match='found 0; print a sweep of 3 × 3'):
        find_window(sweep(lambda *_: math.nan), wanted())
    together = [line for index, each in enumerate(SPEEDS) for line in sweep(
        flows=(FLOWS[index], FLOWS[index] * 1.05), speeds=(each,))]
    with pytest.raises(WindowError, match='flow and speed vary together; print'):
        find_window(together, wanted())


def test_what_drives_has_to_be_told_of_every_line() -> None:
    lines = sweep()
    lines[4] = replace(lines[4], flow=math.nan)
    with pytest.raises(WindowError, match='found neither, as in line 5; add them'):
        find_window(lines, wanted())
    by_pressure = [replace(line, pressure=5e4 * FLOWS[index % 5]) for index, line in
                   enumerate(lines)]
    found = find_window(by_pressure, wanted(speed=10 * MM))
    assert found.drive == pytest.approx(5e4 * 10 * FLOW_PER_SPEED, rel=0.002)
