"""How nozzle and plunger move between strokes: lifted, fast, drawn back, and after a pause."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array


@dataclass(frozen=True)
class Travel:
    """A way from one stroke to the next, as G-code has it.

    The plunger is drawn back; the nozzle is lifted, waits, moves, is lowered; the plunger is
    pushed forth.

    Attributes:
        start, end: arc lengths of the path between which it lies [m].
        hop: how far the nozzle is lifted [m].
        speed: of the move [m/s].
        lift_speed: of lifting and lowering [m/s].
        pause: time that the nozzle waits, lifted, before it moves on [s].
        rise: how much higher the next stroke is laid [m].
        retraction: how far the plunger is drawn back before it, and pushed forth after it [m].
        retraction_speed: of the plunger [m/s].
    """

    start: float
    end: float
    hop: float = 0.002
    speed: float = 0.05
    lift_speed: float = 0.025
    pause: float = 0.0
    rise: float = 0.0
    retraction: float = 0.0
    retraction_speed: float = 0.2e-3


class Motion:
    """Arc length and height of the nozzle over time, along a path with travel; its retractions.

    From node to node all moves steadily.

    Args:
        nodes: (K, 4) time [s], arc length, height above the first stroke's, retraction [m].
        strokes: (S, 2) times at which strokes begin and end [s].
    """

    def __init__(self, nodes: Array, strokes: Array) -> None:
        self._time, self._arc, self._height, self._drawn = nodes.T
        self._strokes = strokes

    @classmethod
    def with_travel(cls, length: float, speed: float, travels: tuple[Travel, ...]) -> Motion:
        """Plan the motion along a path of a length [m]; ``speed`` is that of its strokes [m/s]."""
        nodes = [(0.0, 0.0, 0.0, 0.0)]
        strokes = []

        def go(time: float, arc: float, height: float, drawn: float) -> None:
            nodes.append((nodes[-1][0] + time, arc, height, drawn))

        for travel in (*travels, Travel(length, length)):
            begin, arc, height, _ = nodes[-1]
            go((travel.start - arc) / speed, travel.start, height, 0.0)
            strokes.append((begin, nodes[-1][0]))
            if travel.start == length:
                break
            lifted, lowered = height + travel.hop, height + travel.rise
            drawn, drawing = travel.retraction, travel.retraction / travel.retraction_speed
            go(drawing, travel.start, height, drawn)
            go(travel.hop / travel.lift_speed, travel.start, lifted, drawn)
            go(travel.pause, travel.start, lifted, drawn)
            go((travel.end - travel.start) / travel.speed, travel.end, lifted, drawn)
            go(abs(lowered - lifted) / travel.lift_speed, travel.end, lowered, drawn)
            go(drawing, travel.end, lowered, 0.0)
        return cls(np.array(nodes), np.array(strokes))

    @property
    def duration(self) -> float:
        """Time from the start of the path to its end [s]."""
        return float(self._time[-1])

    def arc_length(self, t: Array) -> Array:
        """Return the arc length (...) at times (...) after the start of the path [m]."""
        return np.interp(t, self._time, self._arc)

    def speed(self, t: Array) -> Array:
        """Return the speed (...) along the path at times (...) [m/s]; 0 before and after it."""
        return self._rate(self._arc, t)

    def height(self, t: Array) -> Array:
        """Return the height (...) above the first stroke's at times (...) [m]."""
        return np.interp(t, self._time, self._height)

    def retracted(self, t: Array) -> Array:
        """Return how far the plunger is drawn back (...) at times (...) [m]."""
        return np.interp(t, self._time, self._drawn)

    def pushing(self, t: Array) -> Array:
        """Return the velocity of the plunger (...) from retractions at times (...) [m/s].

        It is below 0 while it is drawn back.
        """
        return self._rate(-self._drawn, t)

    def on_stroke(self, t: Array) -> NDArray[np.bool_]:
        """Tell whether the nozzle follows a stroke at times (...)."""
        begun = np.searchsorted(self._strokes[:, 0], t, side='right') - 1
        within: NDArray[np.bool_] = (begun >= 0) & (
            np.asarray(t) < self._strokes[np.maximum(begun, 0), 1])
        return within

    def _rate(self, values: Array, t: Array) -> Array:
        """Return how fast values (K,) of the nodes change at times (...) [1/s]."""
        lasting = np.diff(self._time)
        rate = np.divide(np.diff(values), lasting, out=np.zeros(len(lasting)), where=lasting > 0)
        padded = np.concatenate(([0.0], rate, [0.0]))
        return padded[np.searchsorted(self._time, t, side='right')]
