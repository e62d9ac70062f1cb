"""One printer that goes wrong, under each of the controllers that are compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.learning.learner import Learner
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_sim.closed_loop.controllers import (
    AdviceFollower,
    Controller,
    MassBalance,
    NoFeedback,
    ProportionalIntegral,
    ScheduleFollower,
)
from bpc_sim.closed_loop.model import ClosedLoopModel, Trace
from bpc_sim.closed_loop.p_type import PTypeLearner
from bpc_sim.closed_loop.situation import Situation

LAYERS = 3  # that are printed one after the other
LEARNING = ('p_type', 'learned')  # controllers that learn from layer to layer


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
    """Print one layer under the controller of a name."""
    choice = CONTROLLERS[controller]
    return ClosedLoopModel(print_, choice.make(print_), choice.actuator).run()


def print_layers(print_: Situation, controller: str,
                 law: tuple[float, float, float] | None = None) -> list[Trace]:
    """Print layers of one path, and learn from each for the next.

    Args:
        print_: the printer.
        controller: one of those that learn.
        law: constants of the P-type law; None = those that are best.
    """
    traces: list[Trace] = []
    learner: Learner | PTypeLearner | None = None
    schedule, setup = None, None
    for layer in range(1, LAYERS + 1):
        situation = print_.in_layer(layer)
        model = ClosedLoopModel(situation, _follower(controller, schedule), schedule=schedule,
                                setup=setup)
        traces.append(model.run())
        setup, record = model.setup, model.record()
        if record is None:
            continue
        learner = learner or (
            Learner(AdviceConfig(), setup.gain) if controller == 'learned'
            else PTypeLearner(*law or ()))
        learner.take(record, schedule)
        schedule = learner.schedule()
    return traces


def _follower(controller: str, schedule: RateSchedule | None) -> Controller:
    return (AdviceFollower('flow', schedule) if controller == 'learned'
            else ScheduleFollower(schedule))

