"""How the plunger moves, and what ink flows."""

from __future__ import annotations

from dataclasses import dataclass
import math

from bpc_perception.core.config import PlungerConfig
from bpc_perception.core.extruder.tic import MICROSTEPS, TicState

POSITION_UNCERTAIN = 1 << 1  # of misc_flags


@dataclass(frozen=True)
class PlungerMotion:
    """How the plunger moves; unknown is NaN.

    Attributes:
        extruding: whether ink is being pushed out.
        velocity, position: of the plunger, > 0 and growing while ink is pushed out [m/s], [m].
        flow_rate: commanded volume of ink per time [m^3/s].
        position_uncertain: whether nobody vouches for the position.
    """

    extruding: bool
    velocity: float
    position: float
    flow_rate: float
    position_uncertain: bool


class Plunger:
    """Turns states into motion, with the geometry of syringe and drive."""

    def __init__(self, config: PlungerConfig) -> None:
        self._config = config
        self._step_mode: int | None = None
        self._position = 0.0
        self._zero = 0.0

    def motion(self, state: TicState) -> PlungerMotion:
        """The motion of a state.

        Positions count microsteps of whatever size holds now. When that changes the plunger has
        not moved, so the zero does.
        """
        sign = -1.0 if self._config.reversed else 1.0
        pitch = sign * self.travel_per_microstep(state.step_mode)
        travelled = pitch * state.position
        if self._step_mode not in (None, state.step_mode):
            self._zero = self._position - travelled
        self._step_mode = state.step_mode
        self._position = travelled + self._zero
        velocity = pitch * state.velocity / 10000
        extruding = (sign * state.velocity > 0 if math.isnan(velocity)
                     else velocity > self._config.minimum_velocity)
        return PlungerMotion(extruding, velocity, self._position, self.flow_rate(velocity),
                             bool(state.misc_flags & POSITION_UNCERTAIN))

    def travel_per_microstep(self, step_mode: int) -> float:
        """How far the plunger goes [m]; NaN without a known lead."""
        if not self._config.lead:
            return math.nan
        steps = self._config.steps_per_revolution * MICROSTEPS[step_mode]
        return self._config.lead / steps

    def flow_rate(self, velocity: float) -> float:
        """Volume per time of a velocity [m/s] of the plunger [m^3/s]; NaN without a known bore."""
        return math.pi / 4 * self._config.bore**2 * velocity if self._config.bore else math.nan

    def moving(self, velocity: float, position: float) -> PlungerMotion:
        """The motion of a plunger whose velocity [m/s] and position [m] are known as such."""
        sign = -1.0 if self._config.reversed else 1.0
        velocity *= sign
        return PlungerMotion(velocity > self._config.minimum_velocity, velocity, sign * position,
                             self.flow_rate(velocity), math.isnan(position))
