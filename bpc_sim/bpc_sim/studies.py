"""Studies on simulated prints of known thickness: each gives a title and flat rows."""

from __future__ import annotations

from collections.abc import Callable

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement import measure
from bpc_perception.core.path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
import numpy as np

from bpc_sim.paper_cases import area_raster, paper_cases, PaperCase, planar_capture

Row = dict[str, object]

STAMP_NS = 10**12  # any time after the print


def case_path(case: PaperCase) -> DepositionPath:
    """The path of a case, laid at 3 mm/s."""
    s = case.arc_length
    unknown = np.full(len(s), np.nan)
    return DepositionPath('study', 0, STAMP_NS * 1e-9, True, s / 3e-3, s, case.path, unknown,
                          unknown, case.thickness > 0)


def measure_case(case: PaperCase, config: ThicknessConfig) -> ThicknessProfile:
    """Draw a case area-sampled and measure it."""
    capture, T_base_camera = planar_capture(area_raster(case), case.pixel_size, STAMP_NS)
    return measure(capture, case_path(case), T_base_camera, config)


def table1() -> tuple[str, list[Row]]:
    """The paper's eight cases beside the paper's own figures, over all 1000 path points."""
    rows: list[Row] = []
    for case in paper_cases():
        profile = measure_case(case, ThicknessConfig(method='paper'))
        answered = np.isfinite(profile.thickness)
        error = np.abs(profile.thickness - case.thickness)[answered] * 1e3
        reported = case.reported
        assert reported is not None
        rows.append({
            'case': case.number, 'print': case.label, 'method': profile.method,
            'MAE_mm': float(error.mean()), 'paper_MAE_mm': reported.mae * 1e3,
            'std_mm': float(error.std()), 'paper_std_mm': reported.std * 1e3,
            'max_mm': float(error.max()), 'paper_max_mm': reported.max * 1e3,
            'min_mm': float(error.min()), 'paper_min_mm': reported.min * 1e3,
            'answered': float(answered.mean()),
            'gap_called_material': int(
                ((case.thickness == 0) & (profile.status == Status.MEASURED)).sum()),
            'material_called_gap': int(
                ((case.thickness > 0) & (profile.status == Status.GAP)).sum()),
            'time_ms': profile.processing_time * 1e3})
    return 'The eight cases of the paper, 512 x 512 pixels of 0.1 mm, area-sampled', rows


STUDIES: dict[str, Callable[[], tuple[str, list[Row]]]] = {'table1': table1}
