"""A test print: a design, and what each of its strokes is there for."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from bpc_perception.core.design.design import Design


class Part(str, Enum):
    """What a stroke is there for; the values are those of the stroke table."""

    PRIME = 'prime'  # fills the nozzle, and is not judged
    LINE = 'line'  # of a sweep
    REPEAT = 'repeat'  # the middle of a sweep, before and after it: tells drift
    STRAND = 'strand'  # of a pair, or of a lattice
    TURN = 'turn'
    SUPPORT = 'support'
    SPAN = 'span'  # lies over supports
    WALL = 'wall'


@dataclass(frozen=True)
class StrokePlan:
    """What a stroke is there for; NaN = not told, or none.

    Attributes:
        part: kind of stroke.
        flow: volume of ink per time that is commanded [m^3/s].
        speed: of the nozzle [m/s].
        judged: arc lengths from its start between which its bead is taken to be steady [m].
        lead_in: way before the stroke on which the nozzle moves alike without ink [m].
        run_out: the same behind it.
        pair: number of the pair of strands, from 1; 0 = none.
        distance: from the line of the strand, or of the support, before it [m].
        angle: by which a turn turns [rad].
        radius: of a turn; 0 = a corner [m].
        pressure: of the air on the ink [Pa].
        temperature: of the ink [degrees Celsius].
    """

    part: Part
    flow: float
    speed: float
    judged: tuple[float, float]
    lead_in: float = 0.0
    run_out: float = 0.0
    pair: int = 0
    distance: float = np.nan
    angle: float = np.nan
    radius: float = np.nan
    pressure: float = np.nan
    temperature: float = np.nan


@dataclass(frozen=True)
class TestPrint:
    """A test print.

    Attributes:
        name: as in ``bpc testprint NAME``.
        nozzle: inner diameter [m].
        layer_height: height of the nozzle above what it lays on [m].
        design: its strokes, on a bed whose corner is the origin.
        plans: one for each stroke of the design.

    Raises:
        ValueError: strokes and plans are not as many.
    """

    __test__ = False  # for pytest, it is none

    name: str
    nozzle: float
    layer_height: float
    design: Design
    plans: tuple[StrokePlan, ...]

    def __post_init__(self) -> None:
        if len(self.plans) != len(self.design.strokes):
            raise ValueError(f'{self.name}: expected a plan for each of '
                             f'{len(self.design.strokes)} strokes, found {len(self.plans)}'
                             '; take path and stroke table of one test print')

    def numbers(self, *parts: Part) -> list[int]:
        """Return the indices of the strokes that are there for one of these."""
        return [index for index, plan in enumerate(self.plans) if plan.part in parts]
