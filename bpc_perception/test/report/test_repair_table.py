"""repair.csv: there where there is something to fill, with the numbers of the plan."""

from __future__ import annotations

import csv
from dataclasses import replace
import json
from typing import Any

import pytest
from repair_builders import AREA_M2, plan, SPEED, WIDTH_M, with_gap

from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.display.repair_words import repairs_in_words
from bpc_perception.report.outputs import write_outputs
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.repair_table import COLUMNS


def logged(results: Any, repair: RepairPlan) -> PrintLog:
    return PrintLog.of([replace(each, repair=repair) if each.profile is not None else each
                        for each in results])


def test_it_has_a_row_for_each_point_in_millimetres(tmp_path: Any, results: Any,
                                                    provenance: Any) -> None:
    made = plan(with_gap(60, 75, with_gap(100, 120)))
    paths = write_outputs(tmp_path, logged(results, made), provenance)
    assert [path.name for path in paths] == ['profile.csv', 'summary.json', 'report.html',
                                             'repair.csv']
    with (tmp_path / 'repair.csv').open() as stream:
        rows = list(csv.DictReader(stream))
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == sum(len(each.points) for each in made.fills)
    first = [row for row in rows if row['fill'] == '1']
    assert {(row['kind'], row['layer'], row['stroke']) for row in first} == {('GAP', '0', '1')}
    assert float(first[0]['x_mm']) == pytest.approx(59.5 * 0.2 - 1e3 * WIDTH_M / 2)
    assert float(first[-1]['arc_length_mm']) == pytest.approx(74.5 * 0.2 + 1e3 * WIDTH_M / 2)
    laid = [row for row in first if float(row['flow_mm3_s'])]
    assert {round(float(row['flow_mm3_s']), 9) for row in laid} == {1e9 * AREA_M2 * SPEED}
    assert {round(float(row['volume_per_length_mm2']), 9) for row in laid} == {1e6 * AREA_M2}
    assert {round(float(row['speed_mm_s']), 9) for row in rows} == {1e3 * SPEED}


def test_summary_and_report_tell_fills_and_the_next_layer(tmp_path: Any, results: Any,
                                                          provenance: Any) -> None:
    log = logged(results, plan(with_gap(150, 159, with_gap(100, 120))))
    write_outputs(tmp_path, log, provenance)
    told = json.loads((tmp_path / 'summary.json').read_text())['repair']
    layer, = told['layers']
    assert (layer['next_layer'], layer['obstacles']) == ('NO', ['GAP'])
    assert layer['longest_gap_mm'] == pytest.approx(4.0)
    fill, = told['fills']
    assert fill['volume_mm3'] == pytest.approx(4.0 * 1e6 * AREA_M2)
    assert [each['reason'] for each in told['unfilled']] == ['ALLOWED']
    page = (tmp_path / 'report.html').read_text()
    assert 'layer 0: 1 × gap to fill with 1.20 mm³, 1 × gap left; next layer: no: a gap of 4.0' \
        in page
    assert 'left: no longer than is allowed' in page


def test_where_nothing_is_to_fill_there_is_no_file_and_an_earlier_one_goes(
        tmp_path: Any, results: Any, provenance: Any) -> None:
    write_outputs(tmp_path, logged(results, plan(with_gap(100, 120))), provenance)
    assert (tmp_path / 'repair.csv').is_file()
    sound = plan(with_gap(0, 0))
    write_outputs(tmp_path, logged(results, sound), provenance)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        'profile.csv', 'report.html', 'summary.json']
    assert repairs_in_words(sound) == ['layer 0: nothing to repair; next layer: yes']


def test_what_goes_on_is_told_when_it_has_ended(tmp_path: Any, results: Any,
                                                provenance: Any) -> None:
    log = logged(results, plan(with_gap(100, 120), ended=False))
    write_outputs(tmp_path, log, provenance)
    assert not (tmp_path / 'repair.csv').exists()
    log.end()
    write_outputs(tmp_path, log, provenance)
    assert (tmp_path / 'repair.csv').is_file()
