"""``bpc testprint NAME``: write the path of a test print."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bpc_perception.cli.parts.options import JsonOption, QuietOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.testprints import flat, stacked, sweep
from bpc_perception.core.testprints.plan import TestPrint
from bpc_perception.core.testprints.setup import LARGEST_NOZZLE_M, LEAST_NOZZLE_M, Setup
from bpc_perception.display.units import M_PER_MM, MM_PER_M, UL_PER_M3
from bpc_perception.files.settings_file import read_settings
from bpc_perception.files.testprints.folder import write_test_print

LARGEST_PLUNGER_MM = 200.0

OutOption = Annotated[Path, typer.Option(
    '--out', metavar='DIR', help='Folder for NAME.csv, NAME.gcode and NAME_strokes.csv.')]
NozzleOption = Annotated[float, typer.Option(
    '--nozzle-mm', metavar='MM', help='Inner diameter of the nozzle.')]
BedOption = Annotated[str, typer.Option(
    '--bed-mm', metavar='X,Y', help='Size of the bed; the path lies in its middle.')]
HeightOption = Annotated[float, typer.Option(
    '--layer-height-mm', metavar='MM', show_default=False,
    help='Height of the nozzle above what it lays ink on; 0.8 of the nozzle unless given.')]
SpeedOption = Annotated[float, typer.Option(
    '--speed-mm-s', metavar='MM_S', show_default=False,
    help='Of the nozzle; 8 of its diameters a second unless given. The flow is that of a filament '
    'as wide as the nozzle.')]
PlungerOption = Annotated[float, typer.Option(
    '--plunger-mm', metavar='MM', show_default=False,
    help='Inner diameter of the syringe: E is then the way of its plunger [mm]; else it is the '
    'volume of ink [mm3].')]
SettingsOption = Annotated[Path | None, typer.Option(
    '--settings', metavar='FILE', help='next_print.yaml of "bpc window", whose flow, speed and '
    'width all strokes get, in place of those of a filament as wide as the nozzle.')]
FlowsOption = Annotated[str, typer.Option(
    '--flows-mm3-s', metavar='Q,Q,...', help='Flows of the sweep; four around that of a filament '
    'as wide as the nozzle unless given.')]
SpeedsOption = Annotated[str, typer.Option(
    '--speeds-mm-s', metavar='V,V,...', help='Speeds of the sweep; four around 8 nozzle '
    'diameters a second unless given.')]
LengthOption = Annotated[float, typer.Option(
    '--length-mm', metavar='MM', show_default=False,
    help='Length of a line; as short as can be judged unless given.')]


def lines(out: OutOption, nozzle: NozzleOption, bed: BedOption, height: HeightOption = math.nan,
          flows: FlowsOption = '', speeds: SpeedsOption = '', length: LengthOption = math.nan,
          plunger: PlungerOption = math.nan, quiet: QuietOption = False,
          json_lines: JsonOption = False) -> None:
    """A line for each pair of flow and speed: width, height, and lag."""
    setup = _setup(nozzle, bed, height)
    _write(out, sweep.lines(
        setup, [flow / UL_PER_M3 for flow in _numbers('--flows-mm3-s', flows)],
        _lengths('--speeds-mm-s', speeds), length * M_PER_MM), plunger, quiet, json_lines)


def fusion(out: OutOption, nozzle: NozzleOption, bed: BedOption, height: HeightOption = math.nan,
           speed: SpeedOption = math.nan, settings: SettingsOption = None,
           distances: Annotated[str, typer.Option(
               '--distances-mm', metavar='D,D,...', help='Between the lines of each pair; 3 to '
               '1 nozzle diameters unless given.')] = '',
           plunger: PlungerOption = math.nan, quiet: QuietOption = False,
           json_lines: JsonOption = False) -> None:
    """Strands in pairs at falling distances: where they fuse."""
    setup = _setup(nozzle, bed, height, speed, settings)
    _write(out, flat.fusion(setup, _lengths('--distances-mm', distances)), plunger, quiet,
           json_lines)


def turns(out: OutOption, nozzle: NozzleOption, bed: BedOption, height: HeightOption = math.nan,
          speed: SpeedOption = math.nan, settings: SettingsOption = None,
          angles: Annotated[str, typer.Option(
              '--angles-deg', metavar='A,A,...', help='By which corners turn; 60 to 150 unless '
              'given.')] = '',
          radii: Annotated[str, typer.Option(
              '--radii-mm', metavar='R,R,...', help='Of arcs that turn by 90 degrees; 1, 2 and 4 '
              'nozzle diameters unless given.')] = '',
          plunger: PlungerOption = math.nan, quiet: QuietOption = False,
          json_lines: JsonOption = False) -> None:
    """Turns of several angles and radii: how wide the bead is at them."""
    setup = _setup(nozzle, bed, height, speed, settings)
    _write(out, flat.turns(setup, np.radians(_numbers('--angles-deg', angles)).tolist(),
                           _lengths('--radii-mm', radii)), plunger, quiet, json_lines)


def lattice(out: OutOption, nozzle: NozzleOption, bed: BedOption, height: HeightOption = math.nan,
            speed: SpeedOption = math.nan, settings: SettingsOption = None,
            strands: Annotated[int, typer.Option(
                '--strands', metavar='N', help='In each layer.')] = stacked.STRANDS,
            pitch: Annotated[float, typer.Option(
                '--pitch-mm', metavar='MM', show_default=False,
                help='From strand to strand; 4 nozzle diameters unless given.')] = math.nan,
            plunger: PlungerOption = math.nan, quiet: QuietOption = False,
            json_lines: JsonOption = False) -> None:
    """Two layers of crossed strands: pores."""
    setup = _setup(nozzle, bed, height, speed, settings)
    _write(out, stacked.lattice(setup, strands, pitch * M_PER_MM), plunger, quiet, json_lines)


def line_over_lines(
        out: OutOption, nozzle: NozzleOption, bed: BedOption, height: HeightOption = math.nan,
        speed: SpeedOption = math.nan, settings: SettingsOption = None,
        spans: Annotated[str, typer.Option(
            '--spans-mm', metavar='D,D,...', help='Between neighbours of the lines below; 5 and '
            '10 nozzle diameters unless given.')] = '',
        plunger: PlungerOption = math.nan, quiet: QuietOption = False,
        json_lines: JsonOption = False) -> None:
    """A line across others, after the draft ASTM WK72274: how far it sags."""
    setup = _setup(nozzle, bed, height, speed, settings)
    _write(out, stacked.line_over_lines(setup, _lengths('--spans-mm', spans)), plunger, quiet,
           json_lines)


def wall(out: OutOption, nozzle: NozzleOption, bed: BedOption, height: HeightOption = math.nan,
         speed: SpeedOption = math.nan, settings: SettingsOption = None,
         layers: Annotated[int, typer.Option(
             '--layers', metavar='N', help='On top of each other.')] = stacked.LAYERS,
         length: Annotated[float, typer.Option(
             '--length-mm', metavar='MM', show_default=False,
             help='Of the wall; 20 nozzle diameters, 20 mm at least, unless given.')] = math.nan,
         plunger: PlungerOption = math.nan, quiet: QuietOption = False,
         json_lines: JsonOption = False) -> None:
    """Strokes on top of each other, after the draft ASTM WK72274: heights of layers."""
    setup = _setup(nozzle, bed, height, speed, settings)
    _write(out, stacked.wall(setup, layers, length * M_PER_MM), plunger, quiet, json_lines)


def _setup(nozzle_mm: float, bed: str, height_mm: float, speed_mm_s: float = math.nan,
           settings: Path | None = None) -> Setup:
    """Return what a test print is written for. Raises ValueError."""
    if not LEAST_NOZZLE_M <= nozzle_mm * M_PER_MM <= LARGEST_NOZZLE_M:
        raise ValueError(f'--nozzle-mm: expected {LEAST_NOZZLE_M * MM_PER_M:g} to '
                         f'{LARGEST_NOZZLE_M * MM_PER_M:g} mm, found {nozzle_mm:g}'
                         '; is it in millimetres?')
    sides = _lengths('--bed-mm', bed)
    if len(sides) != 2:
        raise ValueError(f'--bed-mm: expected its size along x and y as 60,60, found {bed!r}'
                         '; give two numbers in millimetres')
    if settings is not None and not math.isnan(speed_mm_s):
        raise ValueError('--settings: expected it alone, found --speed-mm-s; leave one out')
    told = {'speed': speed_mm_s * M_PER_MM} if settings is None else read_settings(settings)
    return Setup(nozzle_mm * M_PER_MM, (sides[0], sides[1]), height_mm * M_PER_MM, **told)


def _write(out: Path, test: TestPrint, plunger_mm: float, quiet: bool, json_lines: bool) -> None:
    """Write a test print, and say what it is."""
    terminal = Terminal(quiet, json_lines)
    if not math.isnan(plunger_mm) and not 0 < plunger_mm <= LARGEST_PLUNGER_MM:
        raise ValueError(f'--plunger-mm: expected up to {LARGEST_PLUNGER_MM:g} mm, found '
                         f'{plunger_mm:g}; give the inner diameter of the syringe')
    files = write_test_print(out, test, plunger_mm * M_PER_MM)
    ink = sum(stroke.length / plan.speed * plan.flow
              for stroke, plan in zip(test.design.strokes, test.plans, strict=True)) * UL_PER_M3
    lasting = sum(stroke.length / plan.speed
                  for stroke, plan in zip(test.design.strokes, test.plans, strict=True))
    terminal.emit('testprint', f'{test.name}: {len(test.plans)} strokes, {ink:.0f} mm3 of ink, '
                  f'{lasting:.0f} s without travel', name=test.name, strokes=len(test.plans),
                  ink_mm3=ink, ink_time_s=lasting)
    terminal.files(files)


def _lengths(option: str, words: str) -> list[float]:
    """Return lengths [m], or speeds [m/s], that are told in millimetres."""
    return [value * M_PER_MM for value in _numbers(option, words)]


def _numbers(option: str, words: str) -> list[float]:
    """Return numbers that are told as '1,2,3'; none = none. Raises ValueError."""
    try:
        found = [float(word) for word in words.split(',')] if words else []
        if not np.isfinite(found).all():
            raise ValueError
    except ValueError:
        raise ValueError(f'{option}: expected numbers as 1,2.5,4, found {words!r}'
                         '; put commas between them') from None
    return found
