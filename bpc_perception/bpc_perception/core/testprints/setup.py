"""Nozzle, bed and speed of a test print, and how strokes are put on the bed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import ToleranceConfig
from bpc_perception.core.design.design import Design, DesignStroke
from bpc_perception.core.geometry import unit_vectors
from bpc_perception.core.testprints.plan import Part, StrokePlan, TestPrint

LEAST_NOZZLE_M, LARGEST_NOZZLE_M = 0.05e-3, 5e-3
LARGEST_BED_M = 2.0
SLOWEST_M_S, FASTEST_M_S = 0.1e-3, 0.5
# Defaults, in diameters of the nozzle: of the layer; per second. Extrusion bioprinters lay 0.2 to
# 0.4 mm strands at 2 to 10 mm/s.
LAYER_HEIGHT, SPEED_PER_S = 0.8, 8.0
ENDS_M = ToleranceConfig().ends  # of a stroke, which verdicts leave out too
MARGIN_M = 2e-3  # of the bed around all
SPREADING = 1.6  # times as wide as a round filament of the same flow, a bead may be; more is rare
PRIME_LENGTH_M, PRIME_AWAY_M = 10e-3, 3e-3


@dataclass(frozen=True)
class Setup:
    """What a test print is written for.

    Attributes:
        nozzle: inner diameter [m].
        bed: its size along x and y [m].
        layer_height: NaN = by the nozzle [m].
        speed: usual one of the nozzle; NaN = by its diameter [m/s].
        flow: usual one; NaN = by nozzle and speed [m^3/s].
        width: wanted of the beads; NaN = that of a round filament of their flow [m].
        pressure, temperature: of the ink, where they are known [Pa, degrees Celsius].

    Raises:
        ValueError: a value is out of range; the message says what to do.
    """

    nozzle: float
    bed: tuple[float, float]
    layer_height: float = np.nan
    speed: float = np.nan
    flow: float = np.nan
    width: float = np.nan
    pressure: float = np.nan
    temperature: float = np.nan

    def __post_init__(self) -> None:
        expect('--nozzle-mm', self.nozzle, LEAST_NOZZLE_M, LARGEST_NOZZLE_M)
        for side in self.bed:
            expect('--bed-mm', side, self.nozzle, LARGEST_BED_M)
        if not np.isnan(self.layer_height):
            expect('--layer-height-mm', self.layer_height, self.nozzle / 10, 2 * self.nozzle)
        if not np.isnan(self.speed):
            expect('--speed-mm-s', self.speed, SLOWEST_M_S, FASTEST_M_S, 'mm/s')

    @property
    def height(self) -> float:
        """Of a layer [m]."""
        return LAYER_HEIGHT * self.nozzle if np.isnan(self.layer_height) else self.layer_height

    @property
    def pace(self) -> float:
        """Usual speed of the nozzle [m/s]."""
        return SPEED_PER_S * self.nozzle if np.isnan(self.speed) else self.speed

    @property
    def rate(self) -> float:
        """Usual flow; of a round filament as wide as the nozzle, if none is told [m^3/s]."""
        if not np.isnan(self.flow):
            return self.flow
        return float(np.pi / 4 * self.nozzle**2 * self.pace)


def expect(what: str, value: float, least: float, largest: float, unit: str = 'mm') -> None:
    """Raise ValueError unless a value [SI] is in a range."""
    if not least <= value <= largest:
        raise ValueError(f'{what}: expected {1e3 * least:g} to {1e3 * largest:g} {unit}, found '
                         f'{1e3 * value:g}; is it in {unit}?')


def round_width(flow: float, speed: float) -> float:
    """Return the diameter of a round filament [m] of a flow [m^3/s] at a speed [m/s].

    That is the width wanted of a test print of an ink that is not known: how much wider or
    narrower a bead gets is what it finds out.
    """
    return float(np.sqrt(4 * flow / (np.pi * speed)))


@dataclass
class Pattern:
    """Strokes as they are put together, anywhere.

    Attributes:
        setup: what they are for.
        strokes, plans: so far.
    """

    setup: Setup
    strokes: list[DesignStroke] = field(default_factory=list)
    plans: list[StrokePlan] = field(default_factory=list)

    def add(self, points: Array, part: Part, layer: int = 0, **others: float) -> None:
        """Add a stroke through points (N, 2) [m]; flow and speed are the usual ones if not told.

        Where nothing else is told, its ends are not judged.
        """
        flow = others.pop('flow', self.setup.rate)
        speed = others.pop('speed', self.setup.pace)
        wanted = self.setup.width
        width = round_width(flow, speed) if np.isnan(wanted) else wanted
        height = np.full((len(points), 1), (layer + 1) * self.setup.height)
        stroke = DesignStroke(np.hstack((points, height)), np.full(len(points) - 1, width), layer)
        begin = others.pop('judged_from', ENDS_M)
        self.strokes.append(stroke)
        self.plans.append(StrokePlan(
            part, flow, speed, (begin, max(stroke.length - ENDS_M, begin)),
            pressure=self.setup.pressure, temperature=self.setup.temperature,
            **others))  # type: ignore[arg-type]

    def finish(self, name: str) -> TestPrint:
        """Return the test print, in the middle of the bed, with a line before it that primes.

        The priming line runs across, at one side: so the design fits the print in one way only.

        Raises ValueError if it is larger than the bed.
        """
        low, high = self._extent()
        away = PRIME_AWAY_M + 4 * self.setup.nozzle
        length = max(high[1] - low[1], PRIME_LENGTH_M)
        rest, plans, self.strokes, self.plans = self.strokes, self.plans, [], []
        self.add(np.array([(low[0] - away, low[1]), (low[0] - away, low[1] + length)]),
                 Part.PRIME)
        self.strokes, self.plans = self.strokes + rest, self.plans + plans
        low, high = self._extent()
        needed = high - low + 2 * MARGIN_M
        if (needed > np.array(self.setup.bed) + 1e-9).any():
            x, y = np.ceil(1e4 * needed) / 10
            raise ValueError(
                f'--bed-mm: expected {x:g},{y:g} or more for this test print, found '
                f'{1e3 * self.setup.bed[0]:g},{1e3 * self.setup.bed[1]:g}; take a larger bed, a '
                'finer nozzle, or fewer or shorter strokes')
        shift = np.append(np.array(self.setup.bed) / 2 - (low + high) / 2, 0.0)
        # To the micrometre: so much is in files.
        design = Design(tuple(replace(stroke, points=np.round(stroke.points + shift, 6))
                              for stroke in self.strokes))
        return TestPrint(name, self.setup.nozzle, self.setup.height, design, tuple(self.plans))

    def _extent(self) -> tuple[Array, Array]:
        """Return the least and the largest x and y of where the nozzle goes [m]."""
        points = np.concatenate([way_through(stroke, plan) for stroke, plan in zip(
            self.strokes, self.plans, strict=True)])[:, :2]
        return points.min(axis=0), points.max(axis=0)


def way_through(stroke: DesignStroke, plan: StrokePlan) -> Array:
    """Return the way (N + 2, 3) of the nozzle from lead-in to run-out of a stroke [m]."""
    points = stroke.points
    ahead = unit_vectors(np.stack((points[1] - points[0], points[-1] - points[-2])))
    return np.vstack((points[0] - plan.lead_in * ahead[0], points,
                      points[-1] + plan.run_out * ahead[1]))
