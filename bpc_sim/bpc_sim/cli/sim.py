"""``bpc sim``: the nodes on the synthetic printer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.live_page import PageOption
from bpc_perception.cli.parts.options import JsonOption, QuietOption, SeparateOption
from bpc_perception.cli.parts.saved_prints import NoSaveOption, PrintsOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import CameraConfig
from bpc_perception.recording.print_folder import PRINTS
from bpc_perception.report.result_folder import expect_room_for

OPEN_LOOP_CAPTURE_RATE_HZ, CLOSED_LOOP_CAPTURE_RATE_HZ = 0.5, 1.0
SLOWEST_MM_S, FASTEST_MM_S = 0.1, 500


def sim(
    scenario: Annotated[str | None, typer.Option(help=(
        'What is printed: spiral_gaps, line, ring, meander, archimedean, fermat, strokes, dense, '
        'purge, stack, wall, lattice, crosshatch or lattice_curved. In a closed loop what goes '
        'wrong, as in `bpc study closedloop`: under_delivery unless told otherwise.'
    ))] = None,
    speed: Annotated[float, typer.Option(help='Of the nozzle [mm/s].')] = 3.0,
    rate: Annotated[float | None, typer.Option(
        help='Captures a second: 0.5, in a closed loop 1.')] = None,
    target: Annotated[float, typer.Option(
        help='Thickness wanted [mm]; in a closed loop the scenario knows.')] = 2.0,
    design: Annotated[Path | None, typer.Option(
        metavar='FILE', help='Print a design with --record: G-code, a CSV path with widths, or a '
        'test print, whose NAME_strokes.csv lies beside it.')] = None,
    spreading: Annotated[float, typer.Option(
        help='Of the ink, with --design: width of a bead over that of a round filament.')] = 1.6,
    lag: Annotated[float, typer.Option(
        help='With --design: time constant of the syringe [s].')] = 0.05,
    dead_time: Annotated[float, typer.Option(
        '--dead-time', help='With --design: time before a command has any effect [s].')] = 0.15,
    sag: Annotated[float, typer.Option(
        help='With --design: how far ink hangs down between two strokes below [mm].')] = 0.1,
    record: Annotated[Path | None, typer.Option(
        metavar='BAG', help='Only write the print to a new bag, without a graph.')] = None,
    closed_loop: Annotated[bool, typer.Option(
        '--closed-loop', help='Let a print controller follow the advice.')] = False,
    actuator: Annotated[str, typer.Option(
        help='In a closed loop, what is corrected: flow or speed.')] = 'flow',
    seed: Annotated[int, typer.Option(
        help='In a closed loop, and with --design: which printer.')] = 0,
    out: PrintsOption = PRINTS,
    no_save: NoSaveOption = False,
    separate: SeparateOption = False,
    page: PageOption = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Print on the synthetic printer, measured live, in an open or a closed loop."""
    # Imported late: every command of bpc loads this module, and the simulator is slow to load.
    from bpc_sim.cli.parts.closed_loop import closed_loop_print, run_closed_loop
    from bpc_sim.cli.parts.open_loop import open_loop_print, record_open_loop, run_open_loop

    terminal = Terminal(quiet, json_lines)
    check_speed(speed)
    capture_rate = check_capture_rate(rate, closed_loop)
    expect_room_for(out, 'the prints')
    prints = None if no_save else out
    if design is not None:
        from bpc_sim.cli.parts.design_print import behaviour_of, record_design

        bag = bag_of_design(scenario, closed_loop, record)
        behaviour = behaviour_of(spreading, lag, dead_time, seed)
        record_design(design, behaviour, sag, speed, capture_rate, target, bag, terminal)
        return
    if closed_loop:
        if record is not None:
            raise ValueError('--record: expected an open loop, found --closed-loop')
        corrected = closed_loop_print(scenario, speed, seed, actuator, capture_rate)
        run_closed_loop(corrected, prints, page, terminal)
        return
    planned = open_loop_print(scenario, speed, capture_rate, target)
    if record is not None:
        record_open_loop(planned, record, terminal)
    else:
        run_open_loop(planned, prints, separate, page, terminal)


def bag_of_design(scenario: str | None, closed_loop: bool, record: Path | None) -> Path:
    """Return where to record the print of a design; ValueError = with these options it is none."""
    if record is None:
        raise ValueError('--design: expected --record, found none; name the new bag with it')
    if scenario is not None or closed_loop:
        raise ValueError('--design: expected it alone, found --scenario or --closed-loop'
                         '; leave one out')
    return record


def check_speed(speed_mm_s: float) -> None:
    """Raise ValueError unless the printer can move at this speed."""
    if not SLOWEST_MM_S <= speed_mm_s <= FASTEST_MM_S:
        raise ValueError(f'speed: expected {SLOWEST_MM_S} to {FASTEST_MM_S} mm/s, '
                         f'found {speed_mm_s:g}')


def check_capture_rate(rate: float | None, closed_loop: bool) -> float:
    """Return the rate of captures [Hz]; None = the usual one. Raises ValueError."""
    if rate is None:
        return CLOSED_LOOP_CAPTURE_RATE_HZ if closed_loop else OPEN_LOOP_CAPTURE_RATE_HZ
    CameraConfig(rate=rate)
    if rate == 0:
        raise ValueError('rate: expected more than 0 Hz, found 0')
    return rate
