"""The paper's table of eight cases, by both methods, beside the paper's own figures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.config import ThicknessConfig
from bpc_sim.studies.cases import DRAWINGS, measure_case
from bpc_sim.studies.comparison import compare_profile, Comparison, together
from bpc_sim.studies.paper_cases import paper_cases, PaperCase
from bpc_sim.studies.study import METHODS, Row, Study


@dataclass(frozen=True)
class Drawn:
    """A case, drawn and measured by each method."""

    number: int
    drawing: str
    measured: dict[str, Comparison]


def tasks(seeds: int) -> list[tuple[str, int, int]]:
    """Drawing, row of the table and seed."""
    return [(drawing, number, seed) for drawing in DRAWINGS for number in range(1, 9)
            for seed in range(seeds)]


def work(task: tuple[str, int, int]) -> Drawn:
    """Draw a case and measure it."""
    drawing, number, seed = task
    case = list(paper_cases(seed))[number - 1]
    image = DRAWINGS[drawing].image(case, seed)
    return Drawn(number, drawing, {
        method: compare_profile(measure_case(case, ThicknessConfig(method=method), image),
                                case.thickness)
        for method in METHODS})


def rows(found: list[Drawn]) -> list[Row]:
    """A row for each drawing, method and case; the seeds of a case taken together."""
    table = []
    for drawing in DRAWINGS:
        for method in METHODS:
            for case in paper_cases():
                measured = together([one.measured[method] for one in found
                                     if (one.drawing, one.number) == (drawing, case.number)])
                table.append(row(case, drawing, method, measured))
    return table


def row(case: PaperCase, drawing: str, method: str, measured: Comparison) -> Row:
    """Absolute errors of all samples with a number, those in gaps included as in the paper."""
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
               'camera, and as the paper drew them', tasks, work, rows)
