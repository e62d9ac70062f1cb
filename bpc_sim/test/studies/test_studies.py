"""Studies: figures of samples counted by hand, the order of tasks, other tools on a band."""

from dataclasses import replace
import json
import operator
from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.profile import Status
from bpc_sim.cli.parts.rows import without_nan
from bpc_sim.cli.study import study as command
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.stress.stress_scene import STAMP_NS, StressScene
from bpc_sim.stress.truth import Truth
from bpc_sim.studies import STUDIES
from bpc_sim.studies.hardware_study import statistics
from bpc_sim.studies.peers.methods import (
    canny_cut,
    first_edges,
    from_skeleton,
    grab_cut,
    half_level,
    import_optional,
    otsu_cut,
)
from bpc_sim.studies.peers.picture import picture_of, remove_specks
from bpc_sim.studies.study_runner import METHODS, Study
from bpc_sim.studies.sweep_figure import draw_sweep
from bpc_sim.studies.truth_comparison import compare_scene, Comparison, merge

MM = 1e-3  # [m]
M, G, J, H, E = (Truth.MEASURED, Truth.GAP, Truth.JUNCTION, Truth.HIDDEN, Truth.EDGE)
REFUSED = Status.LOW_CONFIDENCE


def compared(*samples):
    """Compare samples: truth, true width, status, measured width [mm]; sigma 0.1 mm."""
    expected, true, status, width = (np.array(column, float)
                                     for column in zip(*samples, strict=True))
    return Comparison(true * MM, expected.astype(np.uint8), status.astype(np.uint8), width * MM,
                      np.full(len(true), 0.1 * MM), np.array((0.5,)))


NAN = np.nan
SAMPLES = compared(
    (M, 2.0, Status.MEASURED, 2.05), (M, 2.0, Status.MEASURED, 1.85),
    (M, 2.0, Status.MEASURED, 2.41), (M, 1.0, Status.MEASURED, 1.29),
    (M, 2.0, REFUSED, NAN), (M, 2.0, Status.GAP, 0.0),
    (G, 0.0, Status.GAP, 0.0), (G, 0.0, Status.MEASURED, 0.31),
    (J, 2.0, Status.JUNCTION, NAN), (H, 2.0, Status.MEASURED, 2.0),
    (E, 2.0, Status.MEASURED, 9.0), (E, 2.0, REFUSED, NAN))


def test_figures_of_a_comparison():
    assert SAMPLES.mae == pytest.approx((0.05 + 0.15 + 0.41 + 0.29) / 4 * MM)
    assert SAMPLES.median_error == pytest.approx(0.22 * MM)
    assert SAMPLES.largest_error == pytest.approx(0.41 * MM)
    assert SAMPLES.answered == 7 / 8
    # 0.41 mm is more than 20 % of 2 mm, and 0.31 mm more than 0.3 mm; an EDGE is never wrong.
    assert SAMPLES.wrong == 2 / 10
    assert SAMPLES.confidently_wrong == 3 / 10
    assert (SAMPLES.unknowable, SAMPLES.guessed) == (2, 0.5)
    assert (SAMPLES.gap_called_material, SAMPLES.material_called_gap) == (1, 1)
    assert (SAMPLES.within(1), SAMPLES.within(2)) == (0.25, 0.5)


def test_figures_of_nothing_are_nan_not_zero():
    nothing = compared((E, 2.0, REFUSED, NAN))
    assert np.isnan([nothing.mae, nothing.median_error, nothing.largest_error, nothing.answered,
                     nothing.wrong, nothing.guessed, nothing.within(1)]).all()


def test_comparisons_are_put_together():
    both = merge((SAMPLES, compared((M, 2.0, Status.MEASURED, 2.0))))
    assert len(both.true) == 13
    assert both.mae == pytest.approx(0.9 / 5 * MM)
    np.testing.assert_array_equal(both.time, (0.5, 0.5))


def test_statistics_are_those_of_material():
    np.testing.assert_allclose(statistics(np.array((0, 1, 2, 3, np.nan, 4, 5)) * MM),
                               (3, np.sqrt(2), 2, 3, 4))
    assert np.isnan(statistics(np.zeros(3))).all()


@pytest.mark.parametrize('processes', [1, 2])
def test_results_come_in_the_order_of_the_tasks(processes):
    study = Study('', lambda seeds: list(range(seeds)), operator.neg,
                  lambda found: [{'found': found}], seeds=5)
    told = []
    rows = study.run(processes=processes, progress=lambda done, total: told.append((done, total)))
    assert rows == [{'found': [0, -1, -2, -3, -4]}]
    assert told == [(number, 5) for number in range(1, 6)]
    assert study.run(2) == [{'found': [0, -1]}]


def test_the_seeds_of_a_scene_share_a_row():
    study = STUDIES['hardware']
    line = [task for task in study.tasks(2) if task[0] == 'hardware_line']
    rows = study.rows([study.work(task) for task in line])
    assert [row['method'] for row in rows] == ['cross_section', 'paper']
    assert all(row['paper_mean_mm'] == 2.135 for row in rows)
    assert all(abs(row['mean_mm'] - row['true_mean_mm']) < 0.3 for row in rows)


@pytest.fixture
def band():
    """Ink 2 mm wide from left to right, with a gap of 4 mm; 0.1 mm a pixel."""
    u = (np.arange(300) - 149.5) * 0.1 * MM
    rows = np.clip(10.5 - np.abs(np.arange(120) - 59.5), 0, 1)
    columns = np.abs(u - 5 * MM) > 2 * MM
    share = (rows[:, None] * columns)[..., None]
    image = share * (40, 80, 170) + (1 - share) * (205, 205, 200)
    capture, T_base_camera = planar_capture(np.rint(image).astype(np.uint8), 0.1 * MM, STAMP_NS)
    x = np.arange(-12, 12, 0.2) * MM
    gap = np.abs(x - 5 * MM) < 2 * MM
    expected = np.where(gap, G, M)
    expected[np.abs(np.abs(x - 5 * MM) - 2 * MM) < 0.3 * MM] = E
    return StressScene('band', capture, T_base_camera, np.stack((x, 0 * x, 0 * x), axis=1),
                       x - x[0], np.where(gap, 0, 2 * MM), expected.astype(np.uint8), 0.1 * MM)


@pytest.mark.parametrize('method', [grab_cut, otsu_cut, half_level, canny_cut])
def test_other_tools_measure_a_band(band, method):
    width = method(picture_of(band)) * 0.1
    # GrabCut's mask may be off by a pixel on both sides.
    assert np.abs(width[band.expected == M] - 2).max() <= (0.201 if method == grab_cut else 0.101)
    assert (width[band.expected == G] == 0).all()


def test_a_skeleton_counts_where_the_path_runs_in_its_ink(band):
    picture = picture_of(band)
    pixels = np.array([(59, u) for u in range(300) if u < 100])
    width = from_skeleton(picture, pixels, np.full(100, 20.0))
    u = picture.uv[:, 0]
    assert (width[u < 100] == 20).all()
    assert np.isnan(width[(u > 112) & (u < 170)]).all()
    assert (width[band.expected == G] == 0).all()


def test_first_edges():
    # From 0 at the middle, edges at 2.5 to the left and 1.5 to the right, in steps of 1/4 pixel.
    cuts = np.array(((-1, -1, 1, 1, 1, 1, -1, -1, -1), (1,) * 9, (-1,) * 9), float)
    np.testing.assert_allclose(first_edges(cuts), (4 / 4, np.nan, 0))


def test_specks_and_holes_are_cleaned():
    mask = np.zeros((60, 60), bool)
    mask[10:50, 10:50] = True
    expected = mask.copy()
    mask[20:24, 20:24] = False
    mask[2:5, 2:5] = True
    np.testing.assert_array_equal(remove_specks(mask), expected)


def test_a_scene_that_cannot_be_measured_has_no_answers(band):
    blind = Capture(STAMP_NS, '', band.capture.image, np.full_like(band.capture.cloud, np.nan),
                    band.capture.camera)
    refused = compare_scene(replace(band, capture=blind), 'cross_section')
    assert refused.answered == 0
    assert np.isnan(refused.mae)


def test_what_peers_need_is_named_when_it_is_missing():
    with pytest.raises(ValueError, match='expected scikit-image and skan, found no nothing_such'):
        import_optional('nothing_such.module')


def test_a_figure_has_a_line_for_each_method_in_each_panel():
    rows = [{'ratio': ratio, 'time_ms': 1.0, 'MAE_percent': 0.5, 'method': method}
            for ratio in (0.5, 1.0) for method in METHODS]
    page = draw_sweep('Title', rows, ('ratio', 'time_ms', 'MAE_percent'))
    assert '<html>' in page[:30]
    assert page.count('"mode":"lines+markers"') == 2 * len(METHODS)
    assert all(f'"name":"{method}"' in page for method in METHODS)


@pytest.mark.parametrize(('arguments', 'message'), [
    ({'name': 'table9'}, 'study: expected one of table1, .*, found table9'),
    ({'name': 'resolution', 'plot': 'figure.png'}, 'figure.png: expected .* ends in .html'),
    ({'name': 'resolution', 'plot': 'nowhere/figure.html'}, 'nowhere/figure.html: expected'),
    ({'name': 'table1', 'plot': 'figure.html'},
     r'study with a figure \(resolution, thickness, closedloop\)')])
def test_what_a_study_cannot_do_is_refused(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if 'plot' in arguments:
        arguments['plot'] = Path(arguments['plot'])
    with pytest.raises(ValueError, match=message):
        command(**arguments)
    assert list(tmp_path.iterdir()) == []


def test_rows_and_figure_are_written(tmp_path, monkeypatch, capsys):
    study = replace(STUDIES['resolution'], tasks=lambda _: [],
                    rows=lambda _: [{'ratio': 1.0, 'time_ms': NAN, 'MAE_percent': 0.1,
                                     'method': 'paper'}])
    monkeypatch.setitem(STUDIES, 'resolution', study)
    command('resolution', tmp_path / 'rows.json', tmp_path / 'figure.html')
    assert json.loads((tmp_path / 'rows.json').read_text()) == [
        {'ratio': 1.0, 'time_ms': None, 'MAE_percent': 0.1, 'method': 'paper'}]
    assert (tmp_path / 'figure.html').stat().st_size > 1000
    printed = capsys.readouterr().out
    assert 'MAE_percent' in printed
    assert 'nan' not in printed


def test_json_has_no_nan():
    assert without_nan({'a': NAN, 'b': 1, 'c': 'x'}) == {'a': None, 'b': 1, 'c': 'x'}
