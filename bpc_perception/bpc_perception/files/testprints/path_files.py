"""The path of a test print: as the table of points of a design, and as G-code."""

from __future__ import annotations

from itertools import pairwise
import math

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.testprints.plan import StrokePlan, TestPrint
from bpc_perception.core.testprints.setup import way_through

MM = 1e-3
HOP_M = 6e-3  # of the nozzle above the highest layer, on the way from stroke to stroke
TRAVEL_MM_S = 30.0
# Digits behind the point: a micrometre, and shares of volume that add up to a stroke's.
PLACE, VOLUME = 3, 6


def path_csv(test: TestPrint) -> str:
    """Return the whole way of the nozzle as a table of points; travel is stroke 0."""
    rows = ['x_mm,y_mm,z_mm,stroke,width_mm,layer']
    high = _travel_height(test)
    for number, (stroke, plan) in enumerate(zip(test.design.strokes, test.plans, strict=True), 1):
        way = way_through(stroke, plan)
        widths = [math.nan, *stroke.widths.tolist()]
        rows.append(_row((*way[0, :2], high), 0))
        if plan.lead_in > 0:
            rows.append(_row(way[0], 0))
        rows += [_row(point, number, width, stroke.layer) for point, width in zip(
            way[1:-1], widths, strict=True)]
        if plan.run_out > 0:
            rows.append(_row(way[-1], 0))
        rows.append(_row((*way[-1, :2], high), 0))
    return '\n'.join(rows) + '\n'


def _row(point: Array | tuple[float, ...], stroke: int, width: float = math.nan,
         layer: int = 0) -> str:
    x, y, z = (_mm(axis) for axis in point)
    return f'{x},{y},{z},{stroke},{"" if math.isnan(width) else _mm(width)},{layer}'


def g_code(test: TestPrint, plunger: float = math.nan) -> str:
    """Return the path as G-code: metric, absolute places, relative E.

    Args:
        test: what is printed.
        plunger: inner diameter of the syringe [m], so that E is the way of its plunger [mm];
            NaN = E is the volume of ink [mm^3].
    """
    area_mm2 = math.pi / 4 * (plunger / MM)**2
    of_e = ('the volume of ink [mm3], which is microlitres' if math.isnan(plunger) else
            f'the way of a plunger of {plunger / MM:g} mm [mm]')
    lines = [
        f'; bpc testprint {test.name}, nozzle {test.nozzle / MM:g} mm',
        '; the origin is the corner of the bed at the height of the bed; home before',
        f'; E is {of_e}',
        'G21 ; millimetres', 'G90 ; places are absolute', 'M83 ; E is relative',
        _travel(z=_travel_height(test))]
    layer = -1
    for number, (stroke, plan) in enumerate(zip(test.design.strokes, test.plans, strict=True), 1):
        if stroke.layer != layer:
            layer = stroke.layer
            lines.append(f';LAYER:{layer}')
        lines += [_comment(number, plan), f';WIDTH:{_mm(float(stroke.widths[0]))}']
        lines += _stroke(way_through(stroke, plan), plan, 1 if math.isnan(plunger) else area_mm2)
        lines.append(_travel(z=_travel_height(test)))
    return '\n'.join(lines) + '\n'


def _comment(number: int, plan: StrokePlan) -> str:
    flow, speed = plan.flow / MM**3, plan.speed / MM
    return f'; stroke {number}: {plan.part.value}, {flow:.4g} mm3/s at {speed:.4g} mm/s'


def _stroke(way: Array, plan: StrokePlan, per_e: float) -> list[str]:
    """Return the moves along a stroke; an E stands for so much volume [mm^3]."""
    feed = _number(60 * plan.speed / MM, PLACE)
    lines = [_travel(*way[0, :2]), _travel(z=float(way[0, 2]))]
    if plan.lead_in > 0:
        lines.append(f'G1 {_place(way[1])} F{feed}')
    for one, other in pairwise(way[1:-1]):
        volume = plan.flow / MM**3 * float(np.linalg.norm(other - one)) / plan.speed
        lines.append(f'G1 {_place(other)} E{_number(volume / per_e, VOLUME)} F{feed}')
    if plan.run_out > 0:
        lines.append(f'G1 {_place(way[-1])} F{feed}')
    return lines


def _travel(x: float = math.nan, y: float = math.nan, z: float = math.nan) -> str:
    """Return a move without ink; a coordinate that is NaN stays."""
    words = ' '.join(f'{name}{_mm(value)}' for name, value in zip('XYZ', (x, y, z), strict=True)
                     if not math.isnan(value))
    return f'G0 {words} F{_number(60 * TRAVEL_MM_S, PLACE)}'


def _travel_height(test: TestPrint) -> float:
    return max(float(stroke.points[:, 2].max()) for stroke in test.design.strokes) + HOP_M


def _place(point: Array) -> str:
    return ' '.join(f'{name}{_mm(value)}' for name, value in zip('XYZ', point, strict=True))


def _mm(metres: float) -> str:
    return _number(float(metres) / MM, PLACE)


def _number(value: float, digits: int) -> str:
    """Return a number without zeros at its end."""
    text = f'{value:.{digits}f}'.rstrip('0').rstrip('.')
    return '0' if text in ('-0', '') else text
