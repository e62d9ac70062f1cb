"""A print in a closed loop: the printer misbehaves, and a controller follows the advice."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
import tempfile
import time
from typing import Any

from bpc_perception.cli.parts.monitor import Monitor, monitoring
from bpc_perception.cli.parts.printer_nodes import printer_nodes
from bpc_perception.cli.parts.saved_prints import saving
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.display.units import M_PER_MM
from bpc_perception.messages import topics
from bpc_perception.runtime.child_processes import Nodes
from bpc_sim.cli.parts.simulated_print import (
    announce,
    END_MARGIN_S,
    reasons,
    saved_print,
    Settings,
    START_DELAY_S,
    START_TIMEOUT_S,
    wait_for_recorders,
    write_settings,
)
from bpc_sim.closed_loop.controllers import FLOW_SCALE, SPEED_SCALE
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.closed_loop.live_report import report
from bpc_sim.closed_loop.live_settings import loop_hand_eye, loop_parameters
from bpc_sim.closed_loop.situations import SITUATIONS
from bpc_sim.config import ControllerConfig, SimConfig

DEFAULT_SITUATION = 'under_delivery'
MISSING_AT_END_M = 1e-3  # of the path, when a print is complete


@dataclass(frozen=True)
class ClosedLoopPrint:
    """A print that goes wrong, and is corrected.

    Attributes:
        config: what goes wrong, on which printer, and the speed.
        actuator: what is corrected: 'flow' or 'speed'.
        capture_rate: [Hz].
    """

    config: SimConfig
    actuator: str
    capture_rate: float

    @property
    def common_parameters(self) -> dict[str, Any]:
        """The parameters of all nodes of the printer."""
        return {'situation': self.config.situation, 'seed': self.config.seed,
                'speed': self.config.speed}


def closed_loop_print(situation: str | None, speed_mm_s: float, seed: int, actuator: str,
                      capture_rate: float) -> ClosedLoopPrint:
    """Check the options of the command. Raises ValueError."""
    ControllerConfig(actuator=actuator)
    situation = situation or DEFAULT_SITUATION
    if situation not in SITUATIONS:
        raise ValueError(f'scenario: expected one of {", ".join(SITUATIONS)}, '
                         f'found {situation!r}')
    config = SimConfig(situation=situation, speed=speed_mm_s * M_PER_MM, seed=seed)
    return ClosedLoopPrint(config, actuator, capture_rate)


def run_closed_loop(plan: ClosedLoopPrint, prints: Path | None, page: bool,
                    terminal: Terminal) -> None:
    """Print, correct and measure until the path is complete, or Ctrl-C; say how it went.

    The print is kept in a folder among ``prints``; None = it is not.

    Raises:
        ValueError: nodes do not start, or nothing was measured in time.
    """
    print_ = plan.config.closed_loop_job()
    with monitoring(terminal) as monitor, tempfile.TemporaryDirectory() as folder:
        settings = write_settings(Path(folder), loop_hand_eye(print_),
                                  loop_parameters(print_, Path(folder, 'targets.csv')))
        with (saving(saved_print(prints, settings), monitor, terminal),
              printer_nodes(monitor, terminal, page, settings.parameters) as nodes):
            start_measuring_nodes(nodes, plan, settings, monitor)
            wait_for_recorders(monitor, nodes, prints)
            # The print starts when the printer does.
            start_ns = time.time_ns() + round(START_DELAY_S / 2 * 1e9)
            nodes.start('bpc_sim.nodes.printer', start_time_ns=start_ns, **plan.common_parameters)
            last_ns = start_ns + round((print_.duration + 1 / plan.capture_rate) * 1e9)
            announce(print_.job.length, plan.config.speed, last_ns, terminal)
            # Do not wait for captures without end: the camera may be lost. The speed may halve.
            timeout = START_DELAY_S + 2 * print_.duration + END_MARGIN_S
            complete = monitor.spin_until(lambda: is_complete(print_, monitor), timeout,
                                          nodes.check)
            if not complete and not monitor.profiles:
                raise ValueError(f'expected profiles, found none; {reasons(monitor)}')
            last = list(monitor.profiles.values())[-1]
            text = report(print_, last, plan.actuator, plan.capture_rate)
            terminal.emit('report', text, text=text)


def start_measuring_nodes(nodes: Nodes, plan: ClosedLoopPrint, settings: Settings,
                          monitor: Monitor) -> None:
    """Start all nodes but the printer, and wait for them.

    Raises:
        ValueError: one does not start in time.
    """
    nodes.start('bpc_perception.nodes.path_recorder')
    # Separate: the camera listens to the robot, and must not wait for what is being measured.
    nodes.start_measuring(
        {'back_end': 'synthetic', 'rate': plan.capture_rate, **plan.common_parameters},
        {'hand_eye_file': str(settings.hand_eye)}, separate=True)
    nodes.start('bpc_sim.nodes.print_controller', actuator=plan.actuator)
    correction = FLOW_SCALE if plan.actuator == 'flow' else SPEED_SCALE
    names = (topics.PATH, topics.ADVICE, topics.IMAGE, correction)
    if not monitor.spin_until(lambda: all(monitor.publishers(name) for name in names),
                              START_TIMEOUT_S, nodes.check):
        raise ValueError('expected all nodes to start, found some that did not')


def is_complete(print_: ClosedLoopJob, monitor: Monitor) -> bool:
    """Return whether the newest profile reaches the end of the path, and its results are there.

    It looks at places: arc length counts from where the recorder first heard of the print.
    """
    if not monitor.profiles:
        return False
    last = list(monitor.profiles.values())[-1]
    return len(last) > 0 and monitor.has(last.stamp_ns) and bool(
        print_.nearest(last.points[-1]) > print_.job.length - MISSING_AT_END_M)
