"""The colour of the bed on both sides of a path."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.measurement.cross_section.appearance.contrast import Contrast
from bpc_perception.core.measurement.cross_section.sections.sections import Sections

NEAR_BED = 0.4  # of the step from bed to ink: what is nearer to the bed is taken for bed


def find_bed(sections: Sections, beside: Array, centre: Array,
             known: Contrast | None = None) -> tuple[Array, Array]:
    """Find the colours (2, N, 3) of the bed on the right and on the left, close and in the open.

    Where strands lie closely, what lies half-way between them may be ink as well. It is taken for
    bed only if it is nearer to the bed farther out than to the ink.

    Args:
        sections: N sections.
        beside: (2, N, 3) colours where bed is to be expected; NaN = not seen.
        centre: (N, 3) colours on the path.
        known: how ink differs from bed in the whole print.
    """
    clearance = sections.clearance.max() / 2 if known is None else known.clearance
    sure = sections.clearance >= clearance
    open_bed = np.stack([sections.steady(np.where(chosen[:, None], colours, np.nan))
                         for chosen, colours in zip(sure, beside, strict=True)])
    open_bed = np.where(np.isfinite(open_bed), open_bed, open_bed[::-1])
    step = known.step if known is not None else strong_step(centre - open_bed.mean(axis=0))
    if step.any():
        sure |= (beside - open_bed) @ step < NEAR_BED * (step @ step)
    bed = np.stack([sections.steady(np.where(chosen[:, None], colours, np.nan))
                    for chosen, colours in zip(sure, beside, strict=True)])
    bed = np.where(np.isfinite(bed), bed, bed[::-1])
    return bed, np.where(np.isfinite(open_bed), open_bed, bed)


def strong_step(step: Array) -> Array:
    """Return the median (3,) of the larger half of steps (N, 3); 0 where none is known."""
    size = np.linalg.norm(step, axis=1)
    if not np.isfinite(size).any():
        return np.zeros(3)
    return np.asarray(np.median(step[size >= np.nanmedian(size)], axis=0))
