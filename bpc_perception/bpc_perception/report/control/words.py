"""Words for what control charts show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bpc_perception.core.control.rules import Alarm
from bpc_perception.report.control.charts import Chart, ControlGroup

MOST_TOLD = 3  # alarms of a chart


def drifts(groups: Sequence[ControlGroup]) -> Iterator[tuple[ControlGroup, Chart, str]]:
    """Yield each chart of all groups that has alarms, and these in words."""
    for group in groups:
        among = f'group {group.number}, ' if len(groups) > 1 else ''
        for chart in group.charts:
            if chart.alarms:
                start = min(alarm.start for alarm in chart.alarms)
                told = [f'{_places(alarm)} {alarm.rule.value}'
                        for alarm in chart.alarms[:MOST_TOLD]]
                if len(chart.alarms) > MOST_TOLD:
                    told.append(f'and {len(chart.alarms) - MOST_TOLD} more')
                yield group, chart, (
                    f'{among}{chart.quantity} is not steady, first at print {start + 1} of '
                    f'{len(group.prints)} ({group.prints[start].name}): {", ".join(told)}')


def _places(alarm: Alarm) -> str:
    first, last = alarm.start + 1, alarm.end
    return str(first) if first == last else f'{first} to {last}'


def baseline_in_words(group: ControlGroup) -> str:
    """Return which prints set the limits."""
    if group.baseline is None or group.baseline >= len(group.prints):
        return 'all prints'
    return f'the first {group.baseline} prints'


def notes(group: ControlGroup) -> list[str]:
    """Return why there are numbers that a group does not have, and what else to know."""
    found = [f'{chart.quantity}: {reason}' for chart in group.charts for reason in (
        f'no control limits: {chart.limits.reason}' if chart.limits.reason else '',
        f'no Cp and Cpk: {chart.capability.reason}' if chart.capability.reason else '',
        'Cp and Cpk tell of these prints and not of the next one, since they are not steady'
        if chart.alarms and not chart.capability.reason else '') if reason]
    if group.twice:
        found.append(f'the same print as another, left out: {", ".join(group.twice)}')
    return found
