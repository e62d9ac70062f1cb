"""Thickness over length as options of ECharts, in millimetres.

https://echarts.apache.org/en/option.html; keys with a colon in front hold JavaScript.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status
from bpc_perception.display.legend import HEIGHT_COLOUR, rgb, STATUS_COLOURS
from bpc_perception.display.units import MM_PER_M
from bpc_perception.page.board import TargetBand
from bpc_perception.page.curve import Curve, Stretch

LEAST_RANGE_SHARE = 0.25  # of the target, or else of the median, that is shown around it
MARGIN_SHARE = 0.08  # of the range shown, above and below
EMPTY_CHART_M = 1e-3  # the thickness in the middle of a chart without target and samples
RANGE_SAMPLES = 50  # of the target, to find its range
# On a light and on a dark page.
INK_COLOUR = {False: '#4a4a4a', True: '#c8c8c8'}
GRID_COLOUR = {False: '#e4e4e4', True: '#3a3a3a'}
TARGET_GREY = '#8C8C8C'  # shows on both
MEASURED_COLOUR = STATUS_COLOURS[Status.MEASURED]


def options(curve: Curve, marked: list[Stretch], target: TargetBand | None,
            span: tuple[float, float], dark: bool) -> dict[str, Any]:
    """Return the chart of a curve and of what interrupts it.

    Args:
        curve: of the measured samples.
        marked: stretches without a thickness, which are shaded.
        target: with its dead band; None = no target.
        span: arc length from and to [m].
        dark: whether the page is dark.
    """
    axis = {'type': 'value', 'nameLocation': 'middle',
            'nameTextStyle': {'color': INK_COLOUR[dark], 'fontSize': 14},
            'axisLabel': {'color': INK_COLOUR[dark], 'fontSize': 14, 'showMaxLabel': False},
            'axisLine': {'lineStyle': {'color': INK_COLOUR[dark]}},
            'splitLine': {'lineStyle': {'color': GRID_COLOUR[dark]}}}
    low, high = thickness_range(curve, target, span)
    return {
        'animation': False,
        'grid': {'left': 56, 'right': 16, 'top': 12, 'bottom': 44},
        'textStyle': {'fontFamily': 'Roboto, sans-serif'},
        'tooltip': {'trigger': 'axis', 'confine': True, ':formatter': TOOLTIP},
        'xAxis': {**axis, 'name': 'along the path [mm]', 'nameGap': 28,
                  'splitLine': {'show': False}, 'min': _place(span[0]), 'max': _place(span[1])},
        'yAxis': {**axis, 'name': 'thickness, height [mm]', 'nameGap': 40,
                  'min': low, 'max': high},
        'series': [*_target_series(target, span), *_curve_series(curve, marked)],
    }


def thickness_range(curve: Curve, target: TargetBand | None, span: tuple[float, float]
                    ) -> tuple[float, float]:
    """Return from where to where thickness is shown [mm]: all samples, and the target."""
    shown = curve.thickness[np.isfinite(curve.thickness)]
    if target is not None:
        wanted = target.targets.at(np.linspace(*span, RANGE_SAMPLES))
    else:
        wanted = np.array([np.median(shown) if len(shown) else EMPTY_CHART_M])
    height = curve.height[np.isfinite(curve.height)]
    known = np.concatenate((shown, height, wanted * (1 - LEAST_RANGE_SHARE),
                            wanted * (1 + LEAST_RANGE_SHARE))) * MM_PER_M
    margin = MARGIN_SHARE * (known.max() - known.min())
    return (round(max(0.0, float(known.min() - margin)), 1),
            round(float(known.max() + margin), 1))


def _curve_series(curve: Curve, marked: list[Stretch]) -> list[dict[str, Any]]:
    """Return the curve with one standard deviation, the shaded stretches, and the height."""
    return [
        *_band('± sigma', curve.arc_length, curve.thickness - curve.sigma,
               curve.thickness + curve.sigma, MEASURED_COLOUR, 0.3),
        {'name': 'thickness', 'type': 'line', 'showSymbol': False, 'silent': True,
         'lineStyle': {'width': 2, 'color': MEASURED_COLOUR},
         'itemStyle': {'color': MEASURED_COLOUR},
         'data': _points(curve.arc_length, curve.thickness),
         'markArea': {'silent': True, 'data': [_area(stretch) for stretch in marked]}},
        {'name': 'height', 'type': 'line', 'showSymbol': False, 'silent': True,
         'lineStyle': {'width': 1.5, 'color': HEIGHT_COLOUR},
         'itemStyle': {'color': HEIGHT_COLOUR},
         'data': _points(curve.arc_length, curve.height)}]


def _area(stretch: Stretch) -> list[dict[str, Any]]:
    """Return the two ends of a shaded area."""
    # On a dark page black is seen only by its border.
    border = 1 if stretch.status == Status.OCCLUDED else 0
    style = {'color': STATUS_COLOURS[stretch.status], 'opacity': 0.28,
             'borderColor': TARGET_GREY, 'borderWidth': border}
    return [{'xAxis': _place(stretch.start), 'itemStyle': style}, {'xAxis': _place(stretch.end)}]


def _target_series(target: TargetBand | None, span: tuple[float, float]) -> list[dict[str, Any]]:
    """Return the target and its dead band; nothing without a target."""
    if target is None:
        return []
    knots = target.targets.arc_length
    inside = (knots > span[0]) & (knots < span[1])
    at = np.concatenate((span[:1], knots[inside], span[1:]))
    thickness = target.targets.at(at)
    # A step is two knots of one arc length: take both sides of it, not what is interpolated.
    thickness[1:-1] = target.targets.thickness[inside]
    return [
        *_band('dead band', at, thickness * (1 - target.dead_band),
               thickness * (1 + target.dead_band), TARGET_GREY, 0.3),
        {'name': 'target', 'type': 'line', 'showSymbol': False, 'silent': True,
         'lineStyle': {'width': 1.5, 'type': 'dashed', 'color': TARGET_GREY},
         'itemStyle': {'color': TARGET_GREY}, 'data': _points(at, thickness)}]


def _band(name: str, x: Array, low: Array, high: Array, colour: str, opacity: float
          ) -> list[dict[str, Any]]:
    """Return an area between two curves: ECharts stacks its height onto an invisible line."""
    fill = 'rgba({},{},{},{})'.format(*rgb(colour), opacity)
    common = {'type': 'line', 'stack': name, 'stackStrategy': 'all', 'showSymbol': False,
              'silent': True, 'lineStyle': {'opacity': 0}, 'itemStyle': {'color': fill}}
    return [{**common, 'name': f'{name} from', 'data': _points(x, low)},
            {**common, 'name': f'{name} height', 'data': _points(x, high - low),
             'areaStyle': {'color': fill}}]


def _points(x: Array, y: Array) -> list[list[float | None]]:
    """Return pairs of lengths (N,) and (N,) [m] as millimetres; None interrupts the line."""
    places, heights = np.round(x * MM_PER_M, 2).tolist(), np.round(y * MM_PER_M, 3).tolist()
    return [[place, None if np.isnan(height) else height]
            for place, height in zip(places, heights, strict=True)]


def _place(arc_length: float) -> float:
    """Return an arc length [m] as rounded millimetres."""
    return round(arc_length * MM_PER_M, 2)


TOOLTIP = """items => {
  const of = name => items.find(item => item.seriesName === name)?.value[1];
  const mm = value => value.toFixed(3) + ' mm';
  const lines = [items[0].value[0].toFixed(1) + ' mm along the path'];
  if (of('thickness') != null)
    lines.push('thickness ' + of('thickness').toFixed(3) + ' \\u00b1 '
               + mm(of('\\u00b1 sigma height') / 2));
  if (of('height') != null) lines.push('height ' + mm(of('height')));
  return lines.join('<br>');
}"""
