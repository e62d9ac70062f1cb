"""``bpc sim``: the nodes on the synthetic printer."""

from __future__ import annotations

from pathlib import Path
import tempfile
import time
from typing import Annotated, Any

import typer
import yaml

from bpc_perception.cli.parts.live_page import keep_page_open, PageOption, serving
from bpc_perception.cli.parts.monitor import monitoring
from bpc_perception.cli.parts.options import JsonOption, QuietOption, SeparateOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import AdviceConfig, CameraConfig
from bpc_perception.messages import topics
from bpc_perception.runtime.child_processes import Nodes

START_DELAY = 6.0  # until all nodes have found each other [s]
START_PATIENCE = 60.0  # for the nodes of a closed loop, on a busy machine [s]
AT_END = 1e-3  # of path that may be missing when a print is complete [m]


def sim(
    scenario: Annotated[str | None, typer.Option(help=(
        'What is printed: spiral_gaps, line, ring, meander, archimedean or fermat. In a closed '
        'loop what goes wrong, as in `bpc study closedloop`: under_delivery unless told otherwise.'
    ))] = None,
    speed: Annotated[float, typer.Option(help='Of the nozzle [mm/s].')] = 3.0,
    rate: Annotated[float | None, typer.Option(
        help='Captures a second: 0.5, in a closed loop 1.')] = None,
    target: Annotated[float, typer.Option(
        help='Thickness wanted [mm]; in a closed loop the scenario knows.')] = 2.0,
    record: Annotated[Path | None, typer.Option(
        metavar='BAG', help='Only write the print to a new bag, without a graph.')] = None,
    closed_loop: Annotated[bool, typer.Option(
        '--closed-loop', help='Let a print controller follow the advice.')] = False,
    actuator: Annotated[str, typer.Option(
        help='In a closed loop, what is corrected: flow or speed.')] = 'flow',
    seed: Annotated[int, typer.Option(help='In a closed loop: which printer.')] = 0,
    separate: SeparateOption = False,
    page: PageOption = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Print on the synthetic printer, measured live, in an open or a closed loop."""
    # The simulator is a package of its own, needed by this command only.
    from bpc_sim.closed_loop.situations import SITUATIONS
    from bpc_sim.config import ControllerConfig, SimConfig
    from bpc_sim.printer.recording import record as record_print

    terminal = Terminal(quiet, json_lines)
    if not 0.1 <= speed <= 500:
        raise ValueError(f'speed: expected 0.1 to 500 mm/s, found {speed:g}')
    rate = (1.0 if closed_loop else 0.5) if rate is None else rate
    CameraConfig(rate=rate)
    if rate == 0:
        raise ValueError('rate: expected more than 0 Hz, found 0')
    if closed_loop:
        if record is not None:
            raise ValueError('--record: expected an open loop, found --closed-loop')
        ControllerConfig(actuator=actuator)
        scenario = scenario or 'under_delivery'
        if scenario not in SITUATIONS:
            raise ValueError(f'scenario: expected one of {", ".join(SITUATIONS)}, '
                             f'found {scenario!r}')
        config = SimConfig(situation=scenario, speed=speed * 1e-3, seed=seed)
        print_closed_loop(config, actuator, rate, terminal, page)
        return
    config = SimConfig(scenario=scenario or 'spiral_gaps', speed=speed * 1e-3)
    AdviceConfig(target_thickness=target * 1e-3)
    if record is not None:
        with terminal.progress('record', None) as advance:
            record_print(config.job(), record, 1 / rate, target * 1e-3, advance)
        terminal.files([record])
        return
    print_open_loop(config, rate, target * 1e-3, separate, terminal, page)


def print_open_loop(config: Any, rate: float, target: float, separate: bool,
                    terminal: Terminal, page: bool) -> None:
    """Print as planned, and look on; target [m]."""
    from bpc_sim.printer.recording import hand_eye, parameters

    job = config.job()
    with (monitoring(terminal, keep=1) as monitor,
          tempfile.TemporaryDirectory() as folder):
        settings = write_settings(Path(folder), hand_eye(job), parameters(job, target))
        with Nodes(settings) as nodes, serving(page, terminal):
            monitor.expect_no_other_printer()
            start_ns = time.time_ns() + round(START_DELAY * 1e9)
            common = {'scenario': config.scenario, 'speed': config.speed,
                      'start_time_ns': start_ns}
            nodes.start('bpc_perception.nodes.path_recorder')
            nodes.start_measuring({'back_end': 'synthetic', 'rate': rate, **common},
                                  calibration_in(settings), separate)
            nodes.start('bpc_sim.nodes.robot', **common)
            nodes.start('bpc_sim.nodes.extruder', **common)
            announce(job, config, terminal)
            end_ns = start_ns + round(job.duration * 1e9)

            def complete() -> bool:
                nodes.check()
                return any(stamp > end_ns for stamp in monitor.advice)

            if not monitor.spin_until(complete, START_DELAY + job.duration + 10 + 2 / rate):
                raise ValueError('expected a profile after the end of the print, found none; '
                                 f'{"; ".join(monitor.warnings) or "the nodes gave no reason"}')
            keep_page_open(page, terminal, monitor)


def print_closed_loop(config: Any, actuator: str, rate: float, terminal: Terminal,
                      page: bool) -> None:
    """Print with what goes wrong, and with a controller that follows the advice."""
    from bpc_sim.closed_loop.live import loop_hand_eye, loop_parameters, report
    from bpc_sim.closed_loop.rate_control import FLOW_SCALE, SPEED_SCALE

    print_ = config.closed_loop_job()
    job = print_.job
    with monitoring(terminal) as monitor, tempfile.TemporaryDirectory() as folder:
        settings = write_settings(Path(folder), loop_hand_eye(print_),
                                  loop_parameters(print_, Path(folder, 'targets.csv')))
        with Nodes(settings) as nodes, serving(page, terminal):
            monitor.expect_no_other_printer()
            common = {'situation': config.situation, 'seed': config.seed, 'speed': config.speed}
            nodes.start('bpc_perception.nodes.path_recorder')
            # The camera listens to the robot, and must not wait for what is being measured.
            nodes.start_measuring({'back_end': 'synthetic', 'rate': rate, **common},
                                  calibration_in(settings), separate=True)
            nodes.start('bpc_sim.nodes.print_controller', actuator=actuator)
            names = (topics.PATH, topics.ADVICE, topics.IMAGE,
                     FLOW_SCALE if actuator == 'flow' else SPEED_SCALE)

            def ready() -> bool:
                nodes.check()
                return all(monitor.publishers(name) for name in names)

            if not monitor.spin_until(ready, START_PATIENCE):
                raise ValueError('expected all nodes to start, found some that did not')
            # The print starts when the printer does.
            nodes.start('bpc_sim.nodes.printer', start_time_ns=time.time_ns() + round(
                START_DELAY / 2 * 1e9), **common)
            announce(job, config, terminal)
            # The speed may halve, and then there are captures no more where the camera is lost.
            patience = START_DELAY + 2 * job.duration + 10

            def complete() -> bool:
                nodes.check()
                # By place: arc length counts from where the recorder first heard of the print.
                last = list(monitor.profiles.values())[-1:]
                return any(bool(print_.nearest(profile.points[-1]) > job.length - AT_END)
                           for profile in last if len(profile))

            if not monitor.spin_until(complete, patience) and not monitor.profiles:
                raise ValueError('expected profiles, found none; '
                                 f'{"; ".join(monitor.warnings) or "the nodes gave no reason"}')
            text = report(print_, list(monitor.profiles.values())[-1], actuator, rate)
            terminal.tell('report', text, text=text)
            keep_page_open(page, terminal, monitor)


def write_settings(folder: Path, hand_eye: dict[str, object],
                   parameters: dict[str, object]) -> Path:
    """Put calibration and parameters into a folder; the file of the latter."""
    Path(folder, 'hand_eye.calib').write_text(yaml.safe_dump(hand_eye))
    settings = Path(folder, 'params.yaml')
    settings.write_text(yaml.safe_dump(parameters))
    return settings


def calibration_in(settings: Path) -> dict[str, str]:
    """The parameter that names the calibration beside the settings."""
    return {'hand_eye_file': str(settings.with_name('hand_eye.calib'))}


def announce(job: Any, config: Any, terminal: Terminal) -> None:
    """Say how long it takes."""
    terminal.say(f'{job.length * 1e3:.0f} mm at {config.speed * 1e3:g} mm/s: '
                 f'{job.duration + START_DELAY:.0f} s; Ctrl-C ends.')
