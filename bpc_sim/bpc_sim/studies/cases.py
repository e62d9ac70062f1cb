"""The paper's cases, drawn and measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import ThicknessProfile
from bpc_sim.scene.imaging import Imaging
from bpc_sim.scene.planar import planar_capture
from bpc_sim.stress.truth import SPEED, STAMP_NS
from bpc_sim.studies.paper_cases import area_raster, IDEAL, PaperCase, polygon_raster

Image = NDArray[np.uint8]

CAMERA = Imaging(blur=1.0, noise=6.0, lamp_gradient=0.12, glare_spots=13)


@dataclass(frozen=True)
class Drawing:
    """A way to draw a case.

    Attributes:
        raster: draws.
        imaging: colours and imperfections.
    """

    raster: Callable[..., Image]
    imaging: Imaging = IDEAL

    def image(self, case: PaperCase, seed: int) -> Image:
        """The image (H, W, 3) RGB; the seed is that of glare and noise."""
        return self.raster(case, self.imaging, seed)


def _polygons(case: PaperCase, imaging: Imaging, _seed: int) -> Image:
    return polygon_raster(case, imaging)


DRAWINGS = {'area': Drawing(area_raster), 'camera': Drawing(area_raster, CAMERA),
            'polygon': Drawing(_polygons)}


def case_path(case: PaperCase) -> DepositionPath:
    """The path of a case, laid at 3 mm/s; the extruder knows nothing of the gaps."""
    s = case.arc_length
    unknown = np.full(len(s), np.nan)
    return DepositionPath('study', 0, STAMP_NS * 1e-9, True, s / SPEED, s, case.path, unknown,
                          unknown, np.ones(len(s), bool))


def measure_case(case: PaperCase, config: ThicknessConfig,
                 image: Image | None = None) -> ThicknessProfile:
    """Measure a case in an image of it, by default area-sampled."""
    if image is None:
        image = area_raster(case)
    capture, T_base_camera = planar_capture(image, case.pixel_size, STAMP_NS)
    return measure(capture, case_path(case), T_base_camera, config)
