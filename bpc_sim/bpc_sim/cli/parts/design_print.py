"""A print of a design: recorded without a graph."""

from __future__ import annotations

from pathlib import Path

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import AdviceConfig
from bpc_perception.display.units import M_PER_MM
from bpc_perception.files.design.read import read_design
from bpc_perception.files.testprints.stroke_table import read_test_print, SUFFIX
from bpc_sim.ink.extrusion import ExtruderBehaviour
from bpc_sim.printer.design_job import design_job, plans_of
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.print_recording import record_print

NOISE = 0.02  # of the width, along a line
LARGEST = {'--spreading': 5.0, '--lag': 20.0, '--dead-time': 5.0, '--sag': 10.0}
LEAST_SPREADING = 0.2
LEAST_LAG_S = 1e-3


def behaviour_of(spreading: float, lag: float, dead_time: float, seed: int) -> ExtruderBehaviour:
    """Return extruder and ink. Raises ValueError where a value is out of range."""
    _expect('--spreading', spreading, LEAST_SPREADING)
    _expect('--lag', lag)
    _expect('--dead-time', dead_time)
    return ExtruderBehaviour(lag=max(lag, LEAST_LAG_S), dead_time=dead_time, noise=NOISE,
                             spreading=spreading, seed=seed)


def _expect(option: str, value: float, least: float = 0.0) -> None:
    if not least <= value <= LARGEST[option]:
        raise ValueError(f'{option}: expected {least:g} to {LARGEST[option]:g}, found {value:g}'
                         '; choose another')


def record_design(file: Path, behaviour: ExtruderBehaviour, sag_mm: float, speed_mm_s: float,
                  capture_rate: float, target_mm: float, bag: Path, terminal: Terminal) -> None:
    """Print a design into a new bag.

    Args:
        file: the design; the table of strokes of a test print may lie beside it.
        behaviour: of extruder and ink.
        sag_mm: how far ink hangs down between two strokes below [mm].
        speed_mm_s: of the nozzle where no table tells it [mm/s].
        capture_rate: [Hz].
        target_mm: thickness wanted [mm].
        bag: where to.
        terminal: of the command.

    Raises:
        ValueError: the design cannot be read or printed.
    """
    _expect('--sag', sag_mm)
    AdviceConfig(target_thickness=target_mm * M_PER_MM)
    job = _job(file, behaviour, sag_mm * M_PER_MM, speed_mm_s * M_PER_MM)
    with terminal.progress('record', None) as advance:
        record_print(job, bag, 1 / capture_rate, target_mm * M_PER_MM, advance)
    terminal.files([bag])


def _job(file: Path, behaviour: ExtruderBehaviour, sag: float, speed: float) -> PrintJob:
    """Return the print of a design, at a speed [m/s] where no table tells one."""
    table = file.with_name(file.stem + SUFFIX)
    if table.is_file():
        test = read_test_print(table)
        return design_job(test.design, test.plans, behaviour, sag)
    design = read_design(file)
    return design_job(design, plans_of(design, speed), behaviour, sag)
