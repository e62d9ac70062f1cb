"""Prints of an archive of which the last ones get thinner: what batch and compare tell of it."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

from openpyxl import load_workbook
from pyarrow import parquet
import pytest
from scipy.io import loadmat
from selenium.webdriver import Chrome
from selenium.webdriver.common.by import By

from bpc_system_tests.parts.archive import NAMES, record_archive, STEADY, WIDTHS_MM
from bpc_system_tests.parts.browser import errors
from bpc_system_tests.parts.command_line import refusal, succeed

pytestmark = pytest.mark.system

@pytest.fixture(scope='module')
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recordings of prints, of which the last ones get thinner."""
    folder = tmp_path_factory.mktemp('archive')
    record_archive(folder)
    return folder


@pytest.fixture(scope='module')
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder for the results."""
    return tmp_path_factory.mktemp('results')


@pytest.fixture(scope='module')
def events(archive: Path, out: Path) -> list[dict[str, Any]]:
    """What a batch says of it."""
    said = succeed('batch', archive, '--out', out, '--baseline', STEADY, '--xlsx', '--mat',
                   '--json')
    return [json.loads(line) for line in said.splitlines()]


def test_a_drift_is_told_with_the_print_at_which_it_begins(events: list[dict[str, Any]]) -> None:
    drifts = {event['quantity']: event['alarms'] for event in events if event['event'] == 'drift'}
    assert 'width' in drifts
    below, = (alarm for alarm in drifts['width'] if alarm['rule'] == 'BELOW')
    # Sigma is some 0.035 mm: of 1.9, 1.8, 1.7 and 1.6 mm the last three at least are beyond.
    assert below['first'] in NAMES[STEADY:STEADY + 2]
    assert below['last'] == NAMES[-1]


@pytest.mark.usefixtures('events')
def test_all_formats_have_the_same_numbers_in_the_order_of_time(out: Path) -> None:
    with (out / 'control.csv').open(newline='') as stream:
        rows = list(csv.DictReader(stream))
    assert [row['print'] for row in rows] == NAMES
    widths = [float(row['width_mm']) for row in rows]
    assert widths == pytest.approx(WIDTHS_MM, abs=0.06)
    stored = parquet.read_table(out / 'control.parquet').to_pylist()
    assert [row['width_mm'] for row in stored] == widths
    heading, *cells = load_workbook(out / 'prints.xlsx')['control'].iter_rows(values_only=True)
    place = heading.index('width_mm')
    assert [row[place] for row in cells] == pytest.approx(widths, rel=1e-15)
    found = loadmat(out / 'prints.mat', simplify_cells=True)
    assert found['control']['width_mm'].tolist() == widths
    assert sorted(found['prints']['bag']) == sorted(NAMES)
    assert math.isnan(found['capability']['cp'][1])  # of the height no tolerance is set


@pytest.mark.usefixtures('events')
def test_the_page_shows_the_chart_and_leads_to_the_reports(out: Path) -> None:
    page = (out / 'prints.html').read_text()
    assert 'width is not steady' in page
    assert 'id="control1-figure"' in page
    for name in NAMES:
        assert f'href="{name}/report.html"' in page
        assert (out / name / 'report.html').exists()


@pytest.mark.usefixtures('events')
def test_a_browser_draws_the_chart(browser: Chrome, out: Path) -> None:
    browser.get((out / 'prints.html').as_uri())
    drawn = browser.find_elements(By.CSS_SELECTOR, '#control1-figure .scatterlayer .trace')
    assert len(drawn) > 2
    assert 'hardly by chance' in browser.find_element(By.ID, 'control1-figure').text
    assert errors(browser) == []


@pytest.mark.usefixtures('events')
def test_compare_has_the_same_charts_of_the_prints_that_are_named(
        out: Path, tmp_path: Path) -> None:
    said = succeed('compare', *(out / name for name in NAMES[::-1]), '--baseline', STEADY,
                   '--out', tmp_path / 'all.html', '--xlsx', '--mat')
    assert 'width is not steady' in said
    assert {file.name for file in tmp_path.iterdir()} == {'all.html', 'all.xlsx', 'all.mat'}
    control = loadmat(tmp_path / 'all.mat', simplify_cells=True)['control']
    assert list(control['print']) == NAMES
    few = succeed('compare', out / NAMES[0], out / NAMES[1], '--out', tmp_path / 'few.html')
    assert 'steady' not in few


@pytest.mark.usefixtures('events')
def test_a_workbook_of_others_is_not_replaced(out: Path, tmp_path: Path) -> None:
    (tmp_path / 'mine.xlsx').write_text('not of bpc')
    line = refusal('compare', out / NAMES[0], out / NAMES[1], '--out', tmp_path / 'mine.html',
                   '--xlsx')
    assert 'mine.xlsx: expected no file but one that bpc wrote, found another' in line
    assert [file.name for file in tmp_path.iterdir()] == ['mine.xlsx']


def test_measure_writes_the_profile_for_other_programs(archive: Path, tmp_path: Path) -> None:
    for options in (('--xlsx', '--mat'), ()):  # without them, earlier ones are removed
        succeed('measure', archive / NAMES[0], '--out', tmp_path / 'one', *options)
        files = {file.name for file in (tmp_path / 'one').iterdir()}
        more = {f'profile{option.replace("--", ".")}' for option in options}
        assert files == {'profile.csv', 'summary.json', 'report.html', *more}
        if options:
            book = load_workbook(tmp_path / 'one' / 'profile.xlsx')
            assert book.sheetnames == ['profile', 'strokes', 'layers', 'legend']
            with (tmp_path / 'one' / 'profile.csv').open(newline='') as stream:
                assert len(list(stream)) == book['profile'].max_row
