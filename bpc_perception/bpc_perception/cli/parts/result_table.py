"""Results as they come, a line for each capture; and at the end one for each layer."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np
from rich.markup import escape
from rich.table import Table

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.inspection.defects import Defect
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.core.result import Result
from bpc_perception.display.plain_json import plain
from bpc_perception.display.plain_text import one_line
from bpc_perception.display.repair_words import repairs_in_words
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.verdict_words import (
    defect_in_words,
    not_judged,
    place_in_words,
    verdict_in_words,
)
from bpc_perception.display.wording import advice_in_a_line
from bpc_perception.report.comparison import LAYER_COLUMNS
from bpc_perception.report.control.charts import ControlGroup
from bpc_perception.report.control.words import drifts
from bpc_perception.report.entries import (
    advice_entry,
    layer_entries,
    profile_entry,
    repair_entry,
    result_entry,
    verdict_entry,
)

# What was changed since the first advice of the print, as far as it is heard, is under "printer".
HEADER = ('capture', 'ink mm', 'known', 'thickness mm', 'gaps', 'printer', 'advice')
COLUMN_WIDTHS = (7, 7, 5, 13, 10, 25, 0)  # letters


class ResultTable:
    """A line for each capture below a header, or a JSON object for each."""

    def __init__(self, terminal: Terminal) -> None:
        self._terminal = terminal
        self._headed = False
        self._print_id = ''
        self._first: dict[str, float] = {}  # rates in force, of the print
        self._told: list[Defect] = []

    def add(self, result: Result) -> None:
        """Show what came of a capture."""
        if result.profile is None or result.advice is None or result.verdict is None:
            self._emit(('-', '', '', '', '', '', f'refused: {one_line(result.refusal)}'),
                       **result_entry(result))
            return
        self.add_profile(result.profile, result.advice, result.verdict)

    def add_profile(self, profile: ThicknessProfile, advice: RateAdvice,
                    verdict: PrintVerdict) -> None:
        """Show a profile and what came of it; say where another print begins."""
        if self._print_id and profile.print_id != self._print_id:
            self._terminal.say(f'print {one_line(profile.print_id)}')
            self._first.clear()
            self._told.clear()
        self._print_id = profile.print_id
        summary = profile.summary
        length_mm = float(np.diff(profile.strokes.commanded).sum()) * MM_PER_M
        thickness = ('-' if math.isnan(summary.thickness_mean) else
                     f'{summary.thickness_mean * MM_PER_M:.3f} ± '
                     f'{summary.thickness_std * MM_PER_M:.3f}')
        gaps = f'{summary.gap_count} ({summary.gap_length * MM_PER_M:.1f} mm)'
        self._emit((str(profile.capture), f'{length_mm:.1f}', f'{summary.coverage:.0%}', thickness,
                    gaps, self._changed(advice), advice_in_a_line(advice)),
                   **profile_entry(profile), advice=advice_entry(advice),
                   verdict=verdict_entry(verdict))
        self._tell_defects(verdict)

    def _tell_defects(self, verdict: PrintVerdict) -> None:
        """Say each defect once, when it is found: as it grows it is no other."""
        for defect in verdict.defects:
            if not any(defect.is_part_of(told) for told in self._told):
                self._told.append(defect)
                self._terminal.say(f'  {defect_in_words(defect)} ({place_in_words(defect)})')

    def _changed(self, advice: RateAdvice) -> str:
        """Return the rates in force, relative to the first of the print that are known."""
        rates = {'flow': advice.flow_rate_in_force, 'speed': advice.speed_in_force}
        known = {name: rate for name, rate in rates.items() if rate > 0}
        self._first = known | self._first
        return ', '.join(f'{name} x {rate / self._first[name]:.2f}'
                         for name, rate in known.items())

    def _emit(self, cells: tuple[str, ...], **values: object) -> None:
        if not self._headed:
            self._headed = True
            self._terminal.say(_line(HEADER))
        self._terminal.emit('capture', _line(cells), **values)


def _line(cells: tuple[str, ...]) -> str:
    return '  '.join(
        f'{cell:<{width}}' for cell, width in zip(cells, COLUMN_WIDTHS, strict=True)).rstrip()


def show_verdict(terminal: Terminal, verdict: PrintVerdict) -> None:
    """Say whether a print is good."""
    words = '; '.join(filter(None, (verdict_in_words(verdict), not_judged(verdict))))
    terminal.emit('verdict', f'{one_line(verdict.print_id)}: {words}',
                  print_id=verdict.print_id, **verdict_entry(verdict))


def show_repair(terminal: Terminal, plan: RepairPlan) -> None:
    """Say what is to be mended of the finished layers, and whether the next can be laid."""
    for line in repairs_in_words(plan):
        terminal.say(f'  {line}')
    terminal.emit('repair', '', print_id=plan.print_id, **repair_entry(plan))


def show_layers(terminal: Terminal, profile: ThicknessProfile) -> None:
    """Show a table of the layers of a print; nothing if it has but one."""
    layers = plain(layer_entries(profile))
    if len(layers) < 2:
        return
    table = Table('layer', *(escape(column.heading) for column in LAYER_COLUMNS),
                  title=escape(one_line(profile.print_id)))
    for layer in layers:
        table.add_row(str(layer['layer']), *(column.cell(layer[column.key])
                                             for column in LAYER_COLUMNS))
        terminal.emit('layer', '', print_id=profile.print_id, **layer)
    terminal.show(table)


def show_drifts(terminal: Terminal, groups: Sequence[ControlGroup]) -> None:
    """Print a line for each control chart with alarms."""
    for group, chart, words in drifts(groups):
        terminal.emit('drift', words, group=group.number, quantity=chart.quantity, alarms=[
            {'rule': alarm.rule.name, 'first': group.prints[alarm.start].name,
             'last': group.prints[alarm.end - 1].name} for alarm in chart.alarms])
