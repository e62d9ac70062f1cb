"""One print that goes wrong, under each of the controllers that are compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bpc_sim.closed_loop.controllers import (
    AdviceFollower,
    Controller,
    MassBalance,
    NoFeedback,
    ProportionalIntegral,
)
from bpc_sim.closed_loop.model import ClosedLoopModel, Trace
from bpc_sim.closed_loop.situation import Situation


@dataclass(frozen=True)
class ControllerChoice:
    """A controller that is compared.

    Attributes:
        actuator: what it corrects, ``flow`` or ``speed``.
        make: makes the controller of a print.
    """

    actuator: str
    make: Callable[[Situation], Controller]


# By the name in the table.
CONTROLLERS: dict[str, ControllerChoice] = {
    'none': ControllerChoice('flow', lambda _: NoFeedback()),
    'mass_balance': ControllerChoice('flow', lambda print_: MassBalance(print_.targets)),
    'pi': ControllerChoice('flow', lambda print_: ProportionalIntegral(print_.targets)),
    'advice': ControllerChoice('flow', lambda _: AdviceFollower('flow')),
    'advice_speed': ControllerChoice('speed', lambda _: AdviceFollower('speed')),
}


def run_print(print_: Situation, controller: str) -> Trace:
    """Print under the controller of a name."""
    choice = CONTROLLERS[controller]
    return ClosedLoopModel(print_, choice.make(print_), choice.actuator).run()
