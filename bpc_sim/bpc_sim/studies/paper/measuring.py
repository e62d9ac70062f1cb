"""The paper's cases as our methods measure them."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.stress.stress_scene import NOZZLE_SPEED_M_PER_S, STAMP_NS
from bpc_sim.studies.paper.cases import PaperCase
from bpc_sim.studies.paper.drawing import Image
from bpc_sim.studies.study_runner import METHODS
from bpc_sim.studies.truth_comparison import compare_profile, Comparison


def case_path(case: PaperCase) -> DepositionPath:
    """Return the path of a case; the extruder does not know of the gaps."""
    s = case.arc_length
    unknown = np.full(len(s), np.nan)
    return DepositionPath('study', 0, STAMP_NS * 1e-9, True, s / NOZZLE_SPEED_M_PER_S, s,
                          case.path, unknown, unknown, np.ones(len(s), bool),
                          np.ones(len(s), bool))


def compare_case(case: PaperCase, image: Image) -> dict[str, Comparison]:
    """Measure a case in an image (H, W, 3) RGB by each method, and compare with the truth."""
    capture, T_base_camera = planar_capture(image, case.pixel_size, STAMP_NS)
    path = case_path(case)
    return {method: compare_profile(
        measure(capture, path, T_base_camera, ThicknessConfig(method=method)), case.thickness)
        for method in METHODS}
