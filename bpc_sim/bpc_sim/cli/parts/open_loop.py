"""A print in an open loop: robot and extruder keep to the plan while the nodes measure."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
import tempfile
import time

from bpc_perception.cli.parts.monitor import monitoring
from bpc_perception.cli.parts.printer_nodes import printer_nodes
from bpc_perception.cli.parts.saved_prints import saving
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import AdviceConfig
from bpc_perception.display.units import M_PER_MM
from bpc_perception.runtime.child_processes import Nodes
from bpc_sim.cli.parts.simulated_print import (
    announce,
    END_MARGIN_S,
    reasons,
    saved_print,
    Settings,
    START_DELAY_S,
    wait_for_recorders,
    write_settings,
)
from bpc_sim.config import SimConfig
from bpc_sim.printer.print_recording import record_print
from bpc_sim.printer.settings import hand_eye_calibration, node_parameters

DEFAULT_SCENARIO = 'spiral_gaps'


@dataclass(frozen=True)
class OpenLoopPrint:
    """A print that keeps to its plan.

    Attributes:
        config: scenario and speed.
        capture_rate: [Hz].
        target: thickness wanted [m].
    """

    config: SimConfig
    capture_rate: float
    target: float


def open_loop_print(scenario: str | None, speed_mm_s: float, capture_rate: float,
                    target_mm: float) -> OpenLoopPrint:
    """Check the options of the command. Raises ValueError."""
    config = SimConfig(scenario=scenario or DEFAULT_SCENARIO, speed=speed_mm_s * M_PER_MM)
    AdviceConfig(target_thickness=target_mm * M_PER_MM)
    return OpenLoopPrint(config, capture_rate, target_mm * M_PER_MM)


def record_open_loop(plan: OpenLoopPrint, bag: Path, terminal: Terminal) -> None:
    """Write a print to a new bag, without a graph."""
    with terminal.progress('record', None) as advance:
        record_print(plan.config.job(), bag, 1 / plan.capture_rate, plan.target, advance)
    terminal.files([bag])


def run_open_loop(plan: OpenLoopPrint, prints: Path | None, separate: bool, page: bool,
                  terminal: Terminal) -> None:
    """Print and measure until the first result behind the end of the print, or Ctrl-C.

    Args:
        plan: what is printed.
        prints: where its folder is made; None = nowhere.
        separate: whether camera driver and thickness node are processes of their own.
        page: whether to serve the live page.
        terminal: of the command.

    Raises:
        ValueError: there is no such result in time.
    """
    job = plan.config.job()
    with monitoring(terminal, keep=1) as monitor, tempfile.TemporaryDirectory() as folder:
        settings = write_settings(Path(folder), hand_eye_calibration(job),
                                  node_parameters(job, plan.target))
        with (saving(saved_print(prints, settings), monitor, terminal),
              printer_nodes(monitor, terminal, page, settings.parameters) as nodes):
            nodes.start('bpc_perception.nodes.path_recorder')
            wait_for_recorders(monitor, nodes, prints)
            start_ns = time.time_ns() + round(START_DELAY_S * 1e9)
            end_ns = start_ns + round(job.duration * 1e9)
            start_nodes(nodes, plan, settings, separate, start_ns)
            last_ns = end_ns + round(1e9 / plan.capture_rate)
            announce(job.length, plan.config.speed, last_ns, terminal)
            complete = monitor.spin_until(
                lambda: any(stamp_ns > end_ns and monitor.has(stamp_ns)
                            for stamp_ns in monitor.verdicts),
                START_DELAY_S + job.duration + END_MARGIN_S + 2 / plan.capture_rate, nodes.check)
            if not complete:
                raise ValueError('expected a profile after the end of the print, found none; '
                                 f'{reasons(monitor)}')


def start_nodes(nodes: Nodes, plan: OpenLoopPrint, settings: Settings, separate: bool,
                start_ns: int) -> None:
    """Start printer and measuring nodes, which agree on when the print starts [ns]."""
    common = {'scenario': plan.config.scenario, 'speed': plan.config.speed,
              'start_time_ns': start_ns}
    # First those whose first messages count: on a busy machine the others take seconds to load.
    nodes.start('bpc_sim.nodes.robot', **common)
    nodes.start('bpc_sim.nodes.extruder', **common)
    nodes.start_measuring(
        {'back_end': 'synthetic', 'rate': plan.capture_rate, **common},
        {'hand_eye_file': str(settings.hand_eye)}, separate)
