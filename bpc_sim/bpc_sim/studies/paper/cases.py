"""The prints of the paper's simulation study: eight cases, and those of its sweeps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import archimedean, Curve, fermat
from bpc_sim.ink.deposit import constant_width, Deposit, linear_width, random_gaps

PIXEL_SIZE_M = 1e-4  # at ratio 1
IMAGE_SIZE_PX = 512  # width and height, at ratio 1
SAMPLE_COUNT = 1000  # path points
GAP_SHARE = 0.02  # length of a gap as a share of the path
CURVES: dict[str, Callable[[], Curve]] = {
    'A': lambda: archimedean(12 * PIXEL_SIZE_M, np.pi, 6 * np.pi),
    'F': lambda: fermat(90 * PIXEL_SIZE_M, 2 * np.pi),
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
    """One simulated print of the study, at a multiple of the paper's resolution.

    Attributes:
        number: row of the paper's table; 0 for the sweeps.
        label: what is printed, in words.
        curve_type: A (Archimedean) or F (Fermat).
        deposit: the ink, in the surface frame.
        reported: errors that the paper reports; None for the sweeps.
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
        return int(IMAGE_SIZE_PX * self.ratio)

    @property
    def pixel_size(self) -> float:
        """Length of a pixel's side on the surface [m]."""
        return PIXEL_SIZE_M / self.ratio

    @property
    def arc_length(self) -> Array:
        """Arc lengths (1000,) of the path points [m]."""
        return self.deposit.curve.uniform(SAMPLE_COUNT)

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
    """Build a print of the study.

    The paper's sweeps have ten gaps: one goes over ratios from 1/4 to 2 with a width of 2 mm, the
    other over widths from 0.4 mm to 4 mm at ratio 1.

    Args:
        curve_type: A (Archimedean) or F (Fermat).
        start_width: width at the start of the path [m].
        end_width: width at the end of the path [m].
        gap_count: number of random gaps.
        rng: places the gaps; needed for them only.
        ratio: resolution relative to 512 x 512 pixels of 0.1 mm.

    Raises:
        ValueError: there are gaps, but no ``rng``.
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
        gaps = random_gaps(curve.length, gap_count, GAP_SHARE, rng)
        label += f', {gap_count} gaps'
    return PaperCase(0, label, curve_type, Deposit(curve, profile, gaps), ratio=ratio)


def paper_cases(seed: int = 0, ratio: float = 1.0) -> Iterator[PaperCase]:
    """Yield the eight cases of the paper's table; the seed places the gaps of the last two."""
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
