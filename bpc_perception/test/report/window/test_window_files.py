"""The files of a window: what they say, and what they never replace."""

from __future__ import annotations

import csv
from dataclasses import replace
import json
import math
from pathlib import Path

import plotly.graph_objects as go
import pytest
from swept_lines import half_circle, MM, sweep

from bpc_perception.core.window.assess import find_window, InkWindow
from bpc_perception.core.window.window import Wanted
from bpc_perception.report.pages.window_page import render, window_figure
from bpc_perception.report.window.files import check_out, write
from bpc_perception.report.window.rows import law, settings, speed_rows, window_csv

TARGET_MM = 0.7
FLOW_PER_SPEED = math.pi / 8 * TARGET_MM**2  # mm², of a bead that is half a circle


def breaking(flow: float, speed: float) -> float:
    return math.nan if speed / flow > 15 else half_circle(flow, speed)


@pytest.fixture(scope='module')
def window() -> InkWindow:
    lines = [replace(line, area=line.flow / line.speed, start_lag=0.1,
                     stop_lag=0.2 + 0.5 * MM / line.speed) for line in sweep(breaking)]
    return find_window(lines, Wanted(TARGET_MM * MM, 0.1))


def test_a_row_for_each_speed(window: InkWindow) -> None:
    rows = list(csv.DictReader(window_csv(window).splitlines()))
    assert len(rows) == len(window.grid.speed)
    for row in rows:
        speed = float(row['speed_mm_s'])
        if not row['flow_mm3_s']:
            continue
        assert float(row['flow_mm3_s']) == pytest.approx(FLOW_PER_SPEED * speed, rel=2e-3)
        assert float(row['width_mm']) == pytest.approx(TARGET_MM, rel=2e-3)
        assert float(row['area_mm2']) == pytest.approx(FLOW_PER_SPEED, rel=5e-3)
    # Between 5 and 20 mm/s, and 1 and 4 mm³/s.
    told = [float(row['speed_mm_s']) for row in rows if row['flow_mm3_s']]
    assert told[0] == pytest.approx(1 / FLOW_PER_SPEED, rel=0.03)
    assert told[-1] == pytest.approx(20, rel=0.01)
    middle = min(rows, key=lambda row: abs(float(row['speed_mm_s']) - 10))
    speed = float(middle['speed_mm_s'])
    for name, share in (('low', 0.9), ('high', 1.1)):
        assert float(middle[f'flow_{name}_mm3_s']) == pytest.approx(
            share**2 * FLOW_PER_SPEED * speed, rel=0.01)


def test_settings_have_no_noise(window: InkWindow) -> None:
    values = settings(window)
    assert values['flow_mm3_s'] / values['speed_mm_s'] == pytest.approx(FLOW_PER_SPEED, rel=2e-3)
    assert values['start_lag_s'] == 0.1
    assert values['stop_lag_s'] == 0.2  # what lies behind the place of the nozzle is no lag
    assert 'stop_lag_s' not in settings(find_window(sweep(), Wanted(TARGET_MM * MM, 0.1)))
    assert all(len(repr(value)) < 13 for value in values.values())
    assert values['delivered_share'] == pytest.approx(1, rel=1e-3)


def test_the_law_in_words(window: InkWindow) -> None:
    assert law(window.models['area']).startswith('area = ')
    assert law(window.models['width']).count('^') == 2
    assert 'mm/s)^-0.50' in law(window.models['width'])


def test_the_page_says_it_and_loads_nothing(window: InkWindow) -> None:
    page = render(window, ['<sweep>'])
    assert '0.700 mm ± 10.0 %' in page
    assert 'Without a width: line 21.' in page
    assert '&lt;sweep&gt;' in page
    figure = window_figure(window)
    go.Figure(figure.traces, figure.layout)  # raises for what plotly does not know
    assert len(speed_rows(window)) > 13


def test_a_speed_that_is_wanted_leaves_the_whole_window_to_be_seen() -> None:
    found = find_window(sweep(), Wanted(TARGET_MM * MM, 0.1, speed=12 * MM))
    assert settings(found)['speed_mm_s'] == 12
    assert len(speed_rows(found)) > 13


def test_files_replace_those_of_the_same_sweeps_only(window: InkWindow, tmp_path: Path) -> None:
    folder = tmp_path / 'new' / 'window'
    check_out(folder, ['a'])
    names = {file.name for file in write(folder, window, ['a'], None, figures=True)}
    assert names == {'window.csv', 'window.json', 'window.html', 'next_print.yaml', 'window.pdf',
                     'window.svg'}
    assert {file.name for file in folder.iterdir()} == names
    values = json.loads((folder / 'window.json').read_text())
    assert values['target_mm'] == TARGET_MM
    assert values['lines_without_width'] == ['line 21']
    (folder / 'mine.txt').write_text('mine')
    check_out(folder, ['a'])
    write(folder, window, ['a'], None, figures=False)
    assert {file.name for file in folder.iterdir()} == (
        names - {'window.pdf', 'window.svg'} | {'mine.txt'})
    with pytest.raises(ValueError, match='that of b, found that of a; name another folder'):
        check_out(folder, ['b'])
    (folder / 'window.json').write_text('{}')
    with pytest.raises(ValueError, match=r'found next_print\.yaml; name another folder'):
        check_out(folder, ['a'])


def test_the_same_sweep_gives_the_same_files(window: InkWindow, tmp_path: Path) -> None:
    one, two = (write(tmp_path / name, window, ['a'], None, figures=True) for name in 'ab')
    assert [file.read_bytes() for file in one] == [file.read_bytes() for file in two]
