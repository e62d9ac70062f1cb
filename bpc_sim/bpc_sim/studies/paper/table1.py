"""The paper's table of eight cases, measured by both methods, beside the paper's figures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_sim.studies.paper.cases import paper_cases, PaperCase
from bpc_sim.studies.paper.drawing import DRAWINGS
from bpc_sim.studies.paper.measuring import compare_case
from bpc_sim.studies.study_runner import METHODS, Row, Study
from bpc_sim.studies.truth_comparison import Comparison, merge


@dataclass(frozen=True)
class MeasuredCase:
    """A case in one drawing, measured by each method.

    Attributes:
        number: row of the paper's table.
        drawing: name of the drawing.
        comparisons: the comparison with the truth by method.
    """

    number: int
    drawing: str
    comparisons: dict[str, Comparison]


def tasks(seeds: int) -> list[tuple[str, int, int]]:
    """Return drawing, row of the table and seed of each task."""
    return [(drawing, number, seed) for drawing in DRAWINGS for number in range(1, 9)
            for seed in range(seeds)]


def measure_case(task: tuple[str, int, int]) -> MeasuredCase:
    """Draw a case and measure it by each method."""
    drawing, number, seed = task
    case = list(paper_cases(seed))[number - 1]
    image = DRAWINGS[drawing].image(case, seed)
    return MeasuredCase(number, drawing, compare_case(case, image))


def rows(found: list[MeasuredCase]) -> list[Row]:
    """Return a row for each drawing, method and case, with all seeds of a case together."""
    table = []
    for drawing in DRAWINGS:
        for method in METHODS:
            for case in paper_cases():
                measured = merge([one.comparisons[method] for one in found
                                  if (one.drawing, one.number) == (drawing, case.number)])
                table.append(row(case, drawing, method, measured))
    return table


def row(case: PaperCase, drawing: str, method: str, measured: Comparison) -> Row:
    """Return the absolute errors of all samples with an answer; as in the paper, with gaps."""
    error = np.abs(measured.thickness - measured.true)[measured.given] * 1e3
    reported = case.reported
    assert reported is not None
    return {
        'case': case.number, 'print': case.label, 'drawing': drawing, 'method': method,
        'MAE_mm': float(error.mean()), 'paper_MAE_mm': reported.mae * 1e3,
        'std_mm': float(error.std()), 'paper_std_mm': reported.std * 1e3,
        'max_mm': float(error.max()), 'paper_max_mm': reported.max * 1e3,
        'min_mm': float(error.min()), 'paper_min_mm': reported.min * 1e3,
        'answered': measured.answered,
        'gap_called_material': measured.gap_called_material,
        'material_called_gap': measured.material_called_gap,
        'time_ms': float(measured.time.mean()) * 1e3}


TABLE1 = Study('The eight cases of the paper, 512 x 512 pixels of 0.1 mm: area-sampled, with a '
               'camera, and as the paper drew them', tasks, measure_case, rows)
