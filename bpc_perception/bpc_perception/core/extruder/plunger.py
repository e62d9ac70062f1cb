"""How the plunger moves, and what ink flows."""

from __future__ import annotations

from dataclasses import dataclass
import math

from bpc_perception.core.config import PlungerConfig
from bpc_perception.core.extruder.tic import MICROSTEPS, TicState, VELOCITY_PERIOD_S

POSITION_UNCERTAIN_FLAG = 1 << 1  # of misc_flags


@dataclass(frozen=True)
class PlungerMotion:
    """How the plunger moves.

    Attributes:
        extruding: whether ink is being pushed out.
        velocity: of the plunger, > 0 while ink is pushed out [m/s]; NaN = unknown.
        position: of the plunger, growing while ink is pushed out [m]; NaN = unknown.
        flow_rate: commanded volume of ink per time [m^3/s]; NaN = unknown.
        position_uncertain: whether the position cannot be relied on.
    """

    extruding: bool
    velocity: float
    position: float
    flow_rate: float
    position_uncertain: bool


class Plunger:
    """Turns what the extruder reports into motion, with the geometry of syringe and drive."""

    def __init__(self, config: PlungerConfig) -> None:
        self._config = config
        self._step_mode: int | None = None
        self._position = 0.0
        self._zero = 0.0

    def motion(self, state: TicState) -> PlungerMotion:
        """Return the motion of a state of the stepper driver.

        Positions count microsteps of the size that holds now. When the size changes, the plunger
        has not moved: the zero of the positions moves.
        """
        sign = -1.0 if self._config.reversed else 1.0
        pitch = sign * self.travel_per_microstep(state.step_mode)
        travelled = pitch * state.position
        if self._step_mode not in (None, state.step_mode):
            self._zero = self._position - travelled
        self._step_mode = state.step_mode
        self._position = travelled + self._zero
        velocity = pitch * state.velocity / VELOCITY_PERIOD_S
        extruding = (sign * state.velocity > 0 if math.isnan(velocity)
                     else velocity > self._config.minimum_velocity)
        return PlungerMotion(extruding, velocity, self._position, self.flow_rate(velocity),
                             bool(state.misc_flags & POSITION_UNCERTAIN_FLAG))

    def travel_per_microstep(self, step_mode: int) -> float:
        """Return how far the plunger moves per microstep [m]; NaN if the lead is not known."""
        if not self._config.lead:
            return math.nan
        steps = self._config.steps_per_revolution * MICROSTEPS[step_mode]
        return self._config.lead / steps

    def flow_rate(self, velocity: float) -> float:
        """Return the flow [m^3/s] at a plunger velocity [m/s]; NaN if the bore is not known."""
        return math.pi / 4 * self._config.bore**2 * velocity if self._config.bore else math.nan

    def moving(self, velocity: float, position: float) -> PlungerMotion:
        """Return the motion of a plunger that reports velocity [m/s] and position [m] itself."""
        sign = -1.0 if self._config.reversed else 1.0
        velocity *= sign
        return PlungerMotion(velocity > self._config.minimum_velocity, velocity, sign * position,
                             self.flow_rate(velocity), math.isnan(position))
