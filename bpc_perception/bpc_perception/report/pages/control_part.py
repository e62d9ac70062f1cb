"""The part of a page that shows control charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bpc_perception.report.control.charts import ControlGroup
from bpc_perception.report.control.setup import not_alike
from bpc_perception.report.control.tables import control_tables
from bpc_perception.report.control.words import baseline_in_words, drifts, notes
from bpc_perception.report.figures.control import control_figure
from bpc_perception.report.figures.figure import Figure

FEWEST_DRAWN = 3  # prints of a group


def control_figures(groups: Sequence[ControlGroup]) -> dict[str, Figure]:
    """Return the figures of the groups that are large enough, by the names in the template."""
    return {f'control{group.number}': control_figure(group) for group in groups
            if len(group.prints) >= FEWEST_DRAWN}


def control_part(groups: Sequence[ControlGroup]) -> dict[str, Any]:
    """Return the variables of the template ``control.html.j2``."""
    _, capability = control_tables(groups)
    alarms: dict[int, list[str]] = {group.number: [] for group in groups}
    for group, _, words in drifts(groups):
        alarms[group.number].append(words)
    return {
        'groups': [{
            'number': group.number, 'prints': len(group.prints), 'notes': notes(group),
            'drawn': len(group.prints) >= FEWEST_DRAWN, 'alarms': alarms[group.number],
            'baseline': baseline_in_words(group), 'charts': len(group.charts),
            'rows': [row for row in capability.rows if row['group'] == group.number],
        } for group in groups],
        'not_alike': not_alike([group.prints[0].setup for group in groups])}
