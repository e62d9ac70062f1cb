"""The images of the paper's cases: area-sampled, with a camera, and as the paper drew them.

Images show the surface from straight above, its normal towards the viewer, in the coordinates of
bpc_sim.scene.raster.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_sim.scene.imaging import expose, Imaging, mix
from bpc_sim.scene.raster import coverage
from bpc_sim.studies.paper.cases import PaperCase, SAMPLE_COUNT

IDEAL_IMAGING = Imaging()
CAMERA_IMAGING = Imaging(blur=1.0, noise=6.0, lamp_gradient=0.12, glare_spots=13)
POLYGON_SCALE = 8  # at which polygons are drawn enlarged

Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Drawing:
    """A way to draw a case.

    Attributes:
        raster: draws a case with imperfections and a seed.
        imaging: colours and imperfections.
    """

    raster: Callable[[PaperCase, Imaging, int], Image]
    imaging: Imaging = IDEAL_IMAGING

    def image(self, case: PaperCase, seed: int) -> Image:
        """Return the image (H, W, 3) RGB; the seed is that of glare and noise."""
        return self.raster(case, self.imaging, seed)


def area_coverage(case: PaperCase, supersample: int = 8) -> Array:
    """Return the fraction (H, W) of each pixel that ink covers.

    At edges it comes from ``supersample`` x ``supersample`` points per pixel.
    """
    return coverage(lambda points: case.deposit.locate(points).margin, case.size,
                    case.pixel_size, supersample)


def area_raster(case: PaperCase, imaging: Imaging = IDEAL_IMAGING, seed: int = 0) -> Image:
    """Return the image (H, W, 3) RGB that a sensor takes, with the given imperfections."""
    covered = area_coverage(case)
    light = mix(imaging.ink, imaging.bed, covered)
    return expose(light, covered, imaging, np.random.default_rng(seed))


def polygon_raster(case: PaperCase, imaging: Imaging = IDEAL_IMAGING, seed: int = 0) -> Image:
    """Return the image (H, W, 3) RGB as the paper drew it: binary, polygon vertices on pixels.

    Each run of path points with ink is one polygon through its side points. A pixel is ink if its
    centre lies inside. OpenCV paints the outline too, which adds a pixel to the width. So polygons
    are drawn enlarged, and read beside the pixel centres, where no outline reaches. Nothing in
    this drawing is random: the seed is not used.
    """
    del seed
    inked = case.deposit.inked(case.arc_length)
    sides = [np.rint(_pixels(side, case)).astype(np.int32)
             for side in case.deposit.sides(case.arc_length)]
    scale = POLYGON_SCALE
    mask = np.zeros((scale * case.size, scale * case.size), np.uint8)
    for run in np.split(np.arange(SAMPLE_COUNT), np.flatnonzero(np.diff(inked)) + 1):
        if inked[run[0]]:
            polygon = np.concatenate((sides[0][run], sides[1][run[::-1]]))
            # One by one: where runs touch, even-odd filling of all at once would cut holes.
            cv2.fillPoly(mask, [scale * polygon], 1)
    covered = mask[1::scale, 1::scale].astype(np.float64)
    return np.rint(mix(imaging.ink, imaging.bed, covered)).astype(np.uint8)


def _pixels(points: Array, case: PaperCase) -> Array:
    """Return the pixels (N, 2) as (u, v) of points (N, 2) of the surface [m]."""
    return (case.size - 1) / 2 + points * (1.0, -1.0) / case.pixel_size


DRAWINGS = {'area': Drawing(area_raster), 'camera': Drawing(area_raster, CAMERA_IMAGING),
            'polygon': Drawing(polygon_raster)}
