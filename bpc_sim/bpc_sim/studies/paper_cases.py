"""The paper's simulation study: eight cases with known thickness, and its parameter sweeps.

Images show the surface from straight above, its normal to the viewer, in the coordinates of
bpc_sim.scene.raster.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import archimedean, Curve, fermat
from bpc_sim.ink.deposit import constant_width, Deposit, linear_width, random_gaps
from bpc_sim.scene.imaging import expose, Imaging, mix
from bpc_sim.scene.raster import coverage

PIXEL_SIZE = 1e-4  # [m], at ratio 1
IMAGE_SIZE = 512  # [pixels], at ratio 1
SAMPLES = 1000  # path points
IDEAL = Imaging()
CURVES: dict[str, Callable[[], Curve]] = {
    'A': lambda: archimedean(12 * PIXEL_SIZE, np.pi, 6 * np.pi),
    'F': lambda: fermat(90 * PIXEL_SIZE, 2 * np.pi),
}


@dataclass(frozen=True)
class Reported:
    """Absolute thickness errors that the paper reports for a case [m]."""

    mae: float
    std: float
    max: float
    min: float


@dataclass(frozen=True)
class PaperCase:
    """One simulated print of the study, drawn at a ratio of the paper's resolution.

    Attributes:
        number: row of the paper's table; 0 for the sweeps.
        label: what is drawn, in words.
        curve_type: A (Archimedean) or F (Fermat).
        deposit: the ink, in the surface frame.
        reported: the paper's errors, for the eight cases.
        ratio: resolution relative to 512 x 512 pixels of 0.1 mm.
    """

    number: int
    label: str
    curve_type: str
    deposit: Deposit
    reported: Reported | None = None
    ratio: float = 1.0

    @property
    def size(self) -> int:
        """Width and height of the image [pixels]."""
        return int(IMAGE_SIZE * self.ratio)

    @property
    def pixel_size(self) -> float:
        """Length of a pixel's side on the surface [m]."""
        return PIXEL_SIZE / self.ratio

    @property
    def arc_length(self) -> Array:
        """Arc lengths (1000,) of the path points [m]."""
        return self.deposit.curve.uniform(SAMPLES)

    @property
    def path(self) -> Array:
        """Path points (1000, 3) in the base frame, in which the surface is z = 0 [m]."""
        points = self.deposit.curve.points(self.arc_length)
        return np.column_stack((points, np.zeros(len(points))))

    @property
    def thickness(self) -> Array:
        """True thickness (1000,) at the path points [m]; 0 in gaps."""
        return self.deposit.width(self.arc_length)


def make_case(curve_type: str, start_width: float, end_width: float, gap_count: int = 0, *,
              rng: np.random.Generator | None = None, ratio: float = 1.0) -> PaperCase:
    """Build a print of the study; ``rng`` places the gaps and is needed only for them.

    The paper's sweeps are this with ten gaps and a width of 2 mm over ratios from 1/4 to 2, and
    at ratio 1 over widths from 0.4 mm to 4 mm.
    """
    curve = CURVES[curve_type]()
    name = {'A': 'Archimedean', 'F': 'Fermat'}[curve_type]
    if start_width == end_width:
        label, profile = f'{name} {1e3 * start_width:g} mm', constant_width(start_width)
    else:
        label = f'{name} {1e3 * start_width:g}-{1e3 * end_width:g} mm'
        profile = linear_width(start_width, end_width, curve.length)
    gaps = np.empty((0, 2))
    if gap_count:
        if rng is None:
            raise ValueError('gaps are random: expected a random generator, found none')
        gaps = random_gaps(curve.length, gap_count, 0.02, rng)
        label += f', {gap_count} gaps'
    return PaperCase(0, label, curve_type, Deposit(curve, profile, gaps), ratio=ratio)


def paper_cases(seed: int = 0, ratio: float = 1.0) -> Iterator[PaperCase]:
    """The eight cases of the paper's table; the seed places the gaps of the last two."""
    rng = np.random.default_rng(seed)
    table = (  # curve, width from, to, gaps, and the reported MAE, Std., Max, Min [mm]
        ('A', 4, 4, 0, 0.034, 0.025, 0.108, 0.000),
        ('F', 4, 4, 0, 0.051, 0.033, 0.112, 0.000),
        ('A', 2, 2, 0, 0.040, 0.029, 0.133, 0.000),
        ('F', 2, 2, 0, 0.057, 0.033, 0.135, 0.002),
        ('A', 1, 4, 0, 0.035, 0.027, 0.143, 0.000),
        ('F', 1, 4, 0, 0.046, 0.034, 0.150, 0.000),
        ('A', 1, 4, 10, 0.025, 0.027, 0.116, 0.000),
        ('F', 1, 4, 10, 0.038, 0.034, 0.150, 0.000),
    )
    for number, (curve, start, end, gaps, *errors) in enumerate(table, 1):
        case = make_case(curve, 1e-3 * start, 1e-3 * end, gaps, rng=rng, ratio=ratio)
        yield replace(case, number=number, reported=Reported(*(1e-3 * e for e in errors)))


def polygon_raster(case: PaperCase, imaging: Imaging = IDEAL) -> NDArray[np.uint8]:
    """The image (H, W, 3) RGB as the paper drew it: binary, polygon vertices on pixels.

    Each run of path points with ink is one polygon through its side points. A pixel is ink when
    its centre lies inside: OpenCV paints the outline too, a pixel more in width, so polygons
    are drawn enlarged, and looked up beside the pixel centres, where no outline reaches.
    """
    inked = case.deposit.inked(case.arc_length)
    sides = [np.rint(_pixels(side, case)).astype(np.int32)
             for side in case.deposit.sides(case.arc_length)]
    scale = 8
    mask = np.zeros((scale * case.size, scale * case.size), np.uint8)
    for run in np.split(np.arange(SAMPLES), np.flatnonzero(np.diff(inked)) + 1):
        if inked[run[0]]:
            polygon = np.concatenate((sides[0][run], sides[1][run[::-1]]))
            # Each on its own: where runs touch, even-odd filling of all at once cuts holes.
            cv2.fillPoly(mask, [scale * polygon], 1)
    covered = mask[1::scale, 1::scale].astype(np.float64)
    return np.rint(mix(imaging.ink, imaging.bed, covered)).astype(np.uint8)


def area_coverage(case: PaperCase, supersample: int = 8) -> Array:
    """Fraction (H, W) of each pixel that ink covers, from ``supersample``^2 points a pixel."""
    return coverage(lambda points: case.deposit.locate(points).margin, case.size,
                    case.pixel_size, supersample)


def area_raster(case: PaperCase, imaging: Imaging = IDEAL, seed: int = 0,
                supersample: int = 8) -> NDArray[np.uint8]:
    """The image (H, W, 3) RGB as an ideal sensor sees it, with the given imperfections."""
    covered = area_coverage(case, supersample)
    light = mix(imaging.ink, imaging.bed, covered)
    return expose(light, covered, imaging, np.random.default_rng(seed))


def _pixels(points: Array, case: PaperCase) -> Array:
    """Pixels (N, 2) as (u, v) of points (N, 2) of the surface [m]."""
    return (case.size - 1) / 2 + points * (1.0, -1.0) / case.pixel_size
