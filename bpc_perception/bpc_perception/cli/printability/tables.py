"""The tables of printability in a terminal."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
import math
from operator import itemgetter
from typing import Any

from rich.markup import escape
from rich.table import Table

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.printability.assess import Printability
from bpc_perception.display.plain_json import plain
from bpc_perception.display.plain_text import one_line
from bpc_perception.report.printability.rows import metric_row, pore_row

DIGITS = 4  # of a number whose uncertainty is not known
MOST_ROWS = 40  # of a table; a print may have a hundred strands
PORE_COLUMNS = (
    ('pore', 'pore', ''), ('layers', 'layers', ''), ('x [mm]', 'x_mm', ''),
    ('y [mm]', 'y_mm', ''), ('z [mm]', 'z_mm', ''), ('area [mm²]', 'area_mm2', 'area_sigma_mm2'),
    ('perimeter [mm]', 'perimeter_mm', 'perimeter_sigma_mm'), ('Pr', 'pr', 'pr_sigma'),
    ('ideal Pr', 'pr_ideal', ''),
    ('mesh [%]', 'mesh_printability_percent', 'mesh_printability_sigma_percent'), ('', 'note', ''))
Row = dict[str, Any]


def show(terminal: Terminal, found: Printability, print_id: str) -> None:
    """Show metrics and pores: as tables for people, an event each for scripts."""
    metrics = [metric_row(metric) for metric in found.metrics]
    pores = [pore_row(pore) for pore in found.pores]
    for event, rows in (('metric', metrics), ('pore', pores)):
        for row in rows:
            terminal.emit(event, '', print_id=print_id, **plain(row))
    terminal.show(_metric_table([row for row in metrics if row['of'] == 'print'],
                                one_line(print_id)))
    for part in _alike([row for row in metrics if row['of'] != 'print']):
        _show_up_to_most(terminal, part, _part_table)
    if pores:
        _show_up_to_most(terminal, [[row] for row in pores], _pore_table)


def _alike(rows: list[Row]) -> list[list[list[Row]]]:
    """Return rows by what they are about, and these by which metrics there are."""
    parts = [list(part) for _, part in groupby(rows, itemgetter('of'))]
    tables: dict[tuple[str, ...], list[list[Row]]] = {}
    for part in parts:
        tables.setdefault(tuple(row['metric'] for row in part), []).append(part)
    return list(tables.values())


def _show_up_to_most(terminal: Terminal, parts: list[list[Row]],
                     table: Callable[[list[list[Row]]], Table]) -> None:
    terminal.show(table(parts[:MOST_ROWS]))
    if len(parts) > MOST_ROWS:
        terminal.say(f'{len(parts) - MOST_ROWS} more: --out and --json have all')


def _metric_table(rows: list[Row], title: str) -> Table:
    table = Table('metric', 'value', 'unit', 'spread', 'samples', '', title=escape(title))
    for row in rows:
        table.add_row(row['metric'], _number(row['value'], row['sigma']), row['unit'],
                      _number(row['spread']), str(row['samples']), escape(row['note']))
    return table


def _part_table(parts: list[list[Row]]) -> Table:
    """Return a table with a column for each metric."""
    units = [f' [{row["unit"]}]' if row['unit'] else '' for row in parts[0]]
    table = Table('of', *(escape(row['metric'] + unit)
                          for row, unit in zip(parts[0], units, strict=True)))
    for part in parts:
        table.add_row(part[0]['of'], *(_number(row['value'], row['sigma']) for row in part))
    return table


def _pore_table(pores: list[list[Row]]) -> Table:
    table = Table(*(escape(heading) for heading, _, _ in PORE_COLUMNS))
    for (row,) in pores:
        table.add_row(*(
            _number(row[name], row[sigma] if sigma else math.nan)
            if isinstance(row[name], float) else escape(str(row[name]))
            for _, name, sigma in PORE_COLUMNS))
    return table


def _number(value: float, sigma: float = math.nan) -> str:
    """Return a number in words, with two digits of its uncertainty; a dash for what is unknown."""
    if math.isnan(value):
        return '-'
    if not sigma > 0:
        return f'{value:#.{DIGITS}g}'.rstrip('.')
    decimals = max(0, 1 - math.floor(math.log10(sigma)))
    return f'{value:.{decimals}f} ± {sigma:.{decimals}f}'
