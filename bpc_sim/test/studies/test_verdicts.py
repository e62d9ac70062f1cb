"""The study of verdicts: what is planted lies where it is said, and a few of its prints."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.inspection.defects import DefectKind
from bpc_perception.core.inspection.verdict import Verdict
from bpc_sim.studies.verdicts import study
from bpc_sim.studies.verdicts.designed import design_of
from bpc_sim.studies.verdicts.planted import planted, sound_print, STROKE, WIDTH_M


@pytest.mark.parametrize('kind', [DefectKind.THIN, DefectKind.THICK, DefectKind.NECK])
def test_widths_are_planted_where_they_are_said(kind: DefectKind) -> None:
    sound, print_ = planted(kind, 0.0, 1), planted(kind, 0.3, 1)
    start, end = print_.extent
    s = np.linspace(start - 2e-3, end + 2e-3, 101)
    ratio = print_.job.truth(s) / sound.job.truth(s)
    inside = (s > start) & (s < end)
    np.testing.assert_allclose(ratio[~inside], 1.0)
    worst = ratio[inside].max() if kind == DefectKind.THICK else ratio[inside].min()
    assert worst == pytest.approx(1.3 if kind == DefectKind.THICK else 0.7, abs=1e-3)


def test_ink_is_missing_or_too_much_where_it_is_said() -> None:
    gap = planted(DefectKind.GAP, 3e-3, 1)
    assert gap.extent[1] - gap.extent[0] == pytest.approx(3e-3)
    assert (gap.job.truth(np.linspace(*gap.extent, 11)[1:-1]) == 0).all()
    ooze = planted(DefectKind.OOZE, 3e-3, 1)
    laid = ooze.job.truth(np.add(ooze.extent, (1e-5, -1e-5)))
    assert (laid > 0).all()
    assert ooze.job.truth(np.array((ooze.extent[1] + 1e-3,))) == 0
    missing = planted(DefectKind.MISSING_STROKE, 5e-3, 1)
    start, end = missing.job.commanded.runs[STROKE]
    assert end - start == pytest.approx(5e-3)


@pytest.mark.parametrize(('kind', 'size', 'shift', 'left_out'), [
    (DefectKind.OFF_DESIGN, 0.3, 0.3 * WIDTH_M, 0.0), (DefectKind.SKIPPED, 4e-3, 0.0, 4e-3)])
def test_a_print_and_its_design_differ_as_said(kind: DefectKind, size: float, shift: float,
                                               left_out: float) -> None:
    print_ = planted(kind, size, 1)
    assert print_.design is not None
    meant, laid = (design.strokes[STROKE].points
                   for design in (print_.design.design, design_of(print_.job)))
    assert np.linalg.norm(meant[0] - laid[0]) == pytest.approx(shift, abs=1e-5)
    length = np.linalg.norm(meant[-1] - meant[0]) - np.linalg.norm(laid[-1] - laid[0])
    assert length == pytest.approx(left_out, abs=3e-4)


def test_sound_prints_are_as_even_as_said() -> None:
    for number in range(8):
        job = sound_print(number)
        s = np.linspace(0.0, job.length, 2000)
        wanted = job.commanded.width(s)
        ratio = job.truth(s)[wanted > 0] / wanted[wanted > 0]
        assert ratio.std() < 0.05
        assert np.abs(ratio - 1).max() < 0.085


def test_a_sound_print_passes_and_a_defect_is_found() -> None:
    assert study.judge_sound(8).verdict == Verdict.PASS
    found = study.judge_planted(DefectKind.GAP, 4e-3, 0)
    assert (found.verdict, found.hit) == (Verdict.FAIL, True)
    assert {each.kind for each in found.defects} == {DefectKind.GAP}
    assert found.defects[0].worst == pytest.approx(4e-3, abs=0.1 * WIDTH_M)


def test_a_row_tells_from_which_size_on_defects_are_found() -> None:
    def found(size: float, hit: bool) -> study.Found:
        return study.Found(DefectKind.THIN, size, Verdict.FAIL if hit else Verdict.PASS, (), hit)

    sound = study.Found(None, 0.0, Verdict.PASS, ())
    rows = study.rows([[sound, sound], [found(0.1, True), found(0.2, False), found(0.3, True),
                                        found(0.4, True)]])
    assert (rows[0]['prints'], rows[0]['found'], rows[0]['passed']) == (2, 0, 2)
    assert (rows[1]['planted'], rows[1]['found'], rows[1]['unit']) == ('thin', 3, '%')
    assert rows[1]['found_from'] == pytest.approx(30)
