"""Lines of a sweep after a law that is given in the test."""

from __future__ import annotations

from collections.abc import Callable, Sequence
import math

import numpy as np

from bpc_perception.core.window.sweep import SweepLine

MM, MM3 = 1e-3, 1e-9
FLOWS, SPEEDS = np.geomspace(1, 4, 5), np.geomspace(5, 20, 5)  # mm³/s, mm/s
Law = Callable[[float, float], float]


def half_circle(flow: float, speed: float) -> float:
    """Return the width [mm] of a bead that is half a circle: π w² / 8 = flow / speed."""
    return math.sqrt(8 / math.pi * flow / speed)


def sweep(law: Law = half_circle, flows: Sequence[float] = tuple(FLOWS),
          speeds: Sequence[float] = tuple(SPEEDS), scatter: float = 0.0, seed: int = 0,
          sigma: float = math.nan) -> list[SweepLine]:
    """Return a line for each flow [mm³/s] and speed [mm/s], numbered from 1, speed by speed.

    Args:
        law: width in mm; NaN = the line failed.
        flows: in mm³/s.
        speeds: in mm/s.
        scatter: by which widths differ from the law, as a share.
        seed: of the scatter.
        sigma: uncertainty of each width, as a share; NaN = not told.
    """
    chance = np.random.default_rng(seed)
    lines = []
    for speed in speeds:
        for flow in flows:
            width = law(flow, speed) * math.exp(scatter * chance.standard_normal()) * MM
            lines.append(SweepLine(f'line {len(lines) + 1}', speed * MM, flow=flow * MM3,
                                   width=width, width_sigma=sigma * width))
    return lines
