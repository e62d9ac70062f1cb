"""Control charts as tables: a row for each print, and one for each chart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from typing import Any

import numpy as np

from bpc_perception.core.control.individuals import D2
from bpc_perception.display.units import NS_PER_S
from bpc_perception.report.control.charts import Chart, ControlGroup
from bpc_perception.report.control.setup import not_alike
from bpc_perception.report.control.words import notes
from bpc_perception.report.tables.table import Column, Table

QUANTITIES = ('width', 'height')
CONTROL = (
    Column('group', int, 'number of the group: its prints were made and measured with the same'),
    Column('number', int, 'number of the print in its group, in the order of time, from 1'),
    Column('time', str, 'time of the capture that is reported, UTC'),
    Column('print', str, 'name of the print, as its recording or its folder'),
    Column('print_id', str, 'identifier of the print'),
    *(column for what in QUANTITIES for column in (
        Column(f'{what}_mm', float, f'mean {what} of the print'),
        Column(f'{what}_centre_mm', float, f'mean {what} of the baseline'),
        Column(f'{what}_lower_mm', float, f'lower control limit of the mean {what}'),
        Column(f'{what}_upper_mm', float, f'upper control limit of the mean {what}'),
        Column(f'{what}_alarm', str, f'what is hardly by chance about its {what}; empty = '
               'nothing'))),
    Column('verdict', str, 'PASS, FAIL or NOT_ENOUGH_SEEN'),
    Column('good_share', float, 'share of good prints among those judged up to this one'))
CAPABILITY = (
    Column('group', int, 'number of the group'),
    Column('quantity', str, 'width or height: of each print the mean'),
    Column('prints', int, 'number of prints in which it is known'),
    Column('first', str, 'time of the first print, UTC'),
    Column('last', str, 'time of the last print, UTC'),
    Column('baseline', int, 'number of prints that set the control limits'),
    Column('centre_mm', float, 'mean of the baseline'),
    Column('lower_mm', float, 'lower control limit'),
    Column('upper_mm', float, 'upper control limit'),
    Column('sigma_short_mm', float, 'standard deviation by the differences of neighbours in the '
           f'baseline, by {D2}'),
    Column('mean_mm', float, 'mean of all prints'),
    Column('sigma_mm', float, 'standard deviation of all prints, which Cp and Cpk are made of'),
    Column('least_mm', float, 'least that is good'),
    Column('target_mm', float, 'target'),
    Column('largest_mm', float, 'largest that is good'),
    Column('cp', float, 'Cp: width of the tolerance per six sigma'),
    Column('cp_low', float, 'lower bound of Cp, 95 % two-sided'),
    Column('cp_high', float, 'upper bound of Cp'),
    Column('cpk', float, 'Cpk: from the mean to the nearer end of the tolerance, per three sigma'),
    Column('cpk_low', float, 'lower bound of Cpk, 95 % two-sided'),
    Column('cpk_high', float, 'upper bound of Cpk'),
    Column('alarms', int, 'number of alarms'),
    Column('judged', int, 'number of prints that are good or not good'),
    Column('good', int, 'number of good prints'),
    Column('good_low', float, 'lower bound of the share of good prints, 95 % two-sided'),
    Column('good_high', float, 'upper bound of the share of good prints'),
    Column('note', str, 'why numbers are missing, and what else to know'),
    Column('setup', str, 'settings in which the groups differ'))


def control_tables(groups: Sequence[ControlGroup]) -> tuple[Table, Table]:
    """Return the tables ``control``, a row a print, and ``capability``, a row a chart."""
    return (Table('control', CONTROL, [row for group in groups for row in _print_rows(group)]),
            Table('capability', CAPABILITY, list(_chart_rows(groups))))


def moment(stamp_ns: int) -> str:
    """Return a stamp [ns] as date and time of day, by ISO 8601, to the second."""
    return f'{datetime.fromtimestamp(stamp_ns // NS_PER_S, timezone.utc):%Y-%m-%dT%H:%M:%SZ}'


def _print_rows(group: ControlGroup) -> Iterator[dict[str, Any]]:
    shares = group.good_share.tolist()
    for place, (each, share) in enumerate(zip(group.prints, shares, strict=True)):
        row = dict.fromkeys(column.name for column in CONTROL)
        row |= {'group': group.number, 'number': place + 1, 'time': moment(each.stamp_ns),
                'print': each.name, 'print_id': each.print_id, 'good_share': _known(share),
                'verdict': None if each.verdict is None else each.verdict.name}
        for chart in group.charts:
            what, limits = chart.quantity, chart.limits
            alarms = [alarm.rule.value for alarm in chart.alarms
                      if alarm.start <= place < alarm.end]
            row |= {f'{what}_mm': _known(chart.values[place]),
                    f'{what}_centre_mm': _known(limits.centre),
                    f'{what}_lower_mm': _known(limits.lower),
                    f'{what}_upper_mm': _known(limits.upper), f'{what}_alarm': '; '.join(alarms)}
        yield row


def _chart_rows(groups: Sequence[ControlGroup]) -> Iterator[dict[str, Any]]:
    differing = not_alike([group.prints[0].setup for group in groups])
    for place, group in enumerate(groups):
        setup = '; '.join(f'{name} = {values[place]}' for name, values in differing)
        good, (low, high) = group.good, group.good_bounds
        for chart in group.charts:
            yield {'group': group.number, 'quantity': chart.quantity,
                   'first': moment(group.prints[0].stamp_ns),
                   'last': moment(group.prints[-1].stamp_ns), **_numbers(chart),
                   'judged': int(np.isfinite(good).sum()), 'good': int(np.nansum(good)),
                   'good_low': _known(low), 'good_high': _known(high),
                   'note': '; '.join(notes(group)), 'setup': setup}


def _numbers(chart: Chart) -> dict[str, Any]:
    found, limits = chart.capability, chart.limits
    numbers = {
        'centre_mm': limits.centre, 'lower_mm': limits.lower, 'upper_mm': limits.upper,
        'sigma_short_mm': limits.sigma, 'mean_mm': found.mean, 'sigma_mm': found.sigma,
        'least_mm': chart.tolerance[0], 'target_mm': chart.target,
        'largest_mm': chart.tolerance[1], 'cp': found.cp, 'cp_low': found.cp_bounds[0],
        'cp_high': found.cp_bounds[1], 'cpk': found.cpk, 'cpk_low': found.cpk_bounds[0],
        'cpk_high': found.cpk_bounds[1]}
    return {'prints': found.count, 'baseline': limits.count, 'alarms': len(chart.alarms),
            **{name: _known(number) for name, number in numbers.items()}}


def _known(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None
