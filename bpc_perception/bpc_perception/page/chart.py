"""Thickness over length as options of ECharts, in millimetres.

https://echarts.apache.org/en/option.html; keys with a colon in front hold JavaScript.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status
from bpc_perception.display.legend import COLOURS, rgb
from bpc_perception.page.board import Goal
from bpc_perception.page.curve import Curve, Stretch

MM = 1e3
AROUND = 0.25  # of the target, or else the median, that is shown at least
MARGIN = 0.08  # of the range shown, above and below
INK = {False: '#4a4a4a', True: '#c8c8c8'}  # on a light and on a dark page
GRID = {False: '#e4e4e4', True: '#3a3a3a'}
TARGET = '#8C8C8C'


def options(curve: Curve, marked: list[Stretch], goal: Goal | None, span: tuple[float, float],
            dark: bool) -> dict[str, Any]:
    """The chart of a curve and of what interrupts it, over a span of arc length [m]."""
    axis = {'type': 'value', 'nameLocation': 'middle',
            'nameTextStyle': {'color': INK[dark], 'fontSize': 14},
            'axisLabel': {'color': INK[dark], 'fontSize': 14, 'showMaxLabel': False},
            'axisLine': {'lineStyle': {'color': INK[dark]}},
            'splitLine': {'lineStyle': {'color': GRID[dark]}}}
    low, high = thickness_range(curve, goal, span)
    return {
        'animation': False,
        'grid': {'left': 56, 'right': 16, 'top': 12, 'bottom': 44},
        'textStyle': {'fontFamily': 'Roboto, sans-serif'},
        'tooltip': {'trigger': 'axis', 'confine': True, ':formatter': TOOLTIP},
        'xAxis': {**axis, 'name': 'along the path [mm]', 'nameGap': 28,
                  'splitLine': {'show': False}, 'min': _round(span[0]), 'max': _round(span[1])},
        'yAxis': {**axis, 'name': 'thickness [mm]', 'nameGap': 40, 'min': low, 'max': high},
        'series': [*_goal_series(goal, span), *_curve_series(curve, marked)],
    }


def thickness_range(curve: Curve, goal: Goal | None, span: tuple[float, float]
                    ) -> tuple[float, float]:
    """From where to where thickness is shown [mm]: all that was measured, and the target."""
    shown = curve.thickness[np.isfinite(curve.thickness)]
    wanted = (goal.targets.at(np.linspace(*span, 50)) if goal is not None
              else np.median(shown, keepdims=True) if len(shown) else np.array([1e-3]))
    known = np.concatenate((shown, wanted * (1 - AROUND), wanted * (1 + AROUND))) * MM
    margin = MARGIN * (known.max() - known.min())
    return (round(max(0.0, float(known.min() - margin)), 1),
            round(float(known.max() + margin), 1))


def _curve_series(curve: Curve, marked: list[Stretch]) -> list[dict[str, Any]]:
    blue = COLOURS[Status.MEASURED]
    areas = [[{'xAxis': _round(stretch.start), 'itemStyle': {
        'color': COLOURS[stretch.status], 'opacity': 0.28,
        # Black, on a dark page, is seen by its border.
        'borderColor': TARGET, 'borderWidth': 1 if stretch.status == Status.OCCLUDED else 0}},
              {'xAxis': _round(stretch.end)}] for stretch in marked]
    return [
        *_band('± sigma', curve.arc_length, curve.thickness - curve.sigma,
               curve.thickness + curve.sigma, blue, 0.3),
        {'name': 'thickness', 'type': 'line', 'showSymbol': False, 'silent': True,
         'lineStyle': {'width': 2, 'color': blue}, 'itemStyle': {'color': blue},
         'data': _points(curve.arc_length, curve.thickness),
         'markArea': {'silent': True, 'data': areas}}]


def _goal_series(goal: Goal | None, span: tuple[float, float]) -> list[dict[str, Any]]:
    """The target and its band; none without."""
    if goal is None:
        return []
    knots = goal.targets.arc_length
    at = np.concatenate((span[:1], knots[(knots > span[0]) & (knots < span[1])], span[1:]))
    # Either side of a step, which is two knots of one arc length.
    target = goal.targets.at(at)
    inside = np.flatnonzero((knots > span[0]) & (knots < span[1]))
    target[1:-1] = goal.targets.thickness[inside]
    return [
        *_band('dead band', at, target * (1 - goal.dead_band), target * (1 + goal.dead_band),
               TARGET, 0.3),
        {'name': 'target', 'type': 'line', 'showSymbol': False, 'silent': True,
         'lineStyle': {'width': 1.5, 'type': 'dashed', 'color': TARGET},
         'itemStyle': {'color': TARGET}, 'data': _points(at, target)}]


def _band(name: str, x: Array, low: Array, high: Array, colour: str, opacity: float
          ) -> list[dict[str, Any]]:
    """An area between two curves: ECharts stacks its height onto an invisible line."""
    fill = 'rgba({},{},{},{})'.format(*rgb(colour), opacity)
    common = {'type': 'line', 'stack': name, 'stackStrategy': 'all', 'showSymbol': False,
              'silent': True, 'lineStyle': {'opacity': 0}, 'itemStyle': {'color': fill}}
    return [{**common, 'name': f'{name} from', 'data': _points(x, low)},
            {**common, 'name': f'{name} height', 'data': _points(x, high - low),
             'areaStyle': {'color': fill}}]


def _points(x: Array, y: Array) -> list[list[float | None]]:
    """Pairs in millimetres to a thousandth; None interrupts the line."""
    return [[horizontal, None if np.isnan(vertical) else vertical] for horizontal, vertical in
            zip(np.round(x * MM, 2).tolist(), np.round(y * MM, 3).tolist(), strict=True)]


def _round(length: float) -> float:
    return round(length * MM, 2)


TOOLTIP = """items => {
  const of = name => items.find(item => item.seriesName === name)?.value[1];
  const mm = value => value.toFixed(3) + ' mm';
  const lines = [items[0].value[0].toFixed(1) + ' mm along the path'];
  if (of('thickness') != null)
    lines.push('thickness ' + of('thickness').toFixed(3) + ' \\u00b1 '
               + mm(of('\\u00b1 sigma height') / 2));
  return lines.join('<br>');
}"""
