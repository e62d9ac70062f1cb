"""The window of an ink in a terminal."""

from __future__ import annotations

import math

from rich.markup import escape
from rich.table import Table

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.window.assess import InkWindow
from bpc_perception.core.window.sweep import Drive
from bpc_perception.core.window.window import MET
from bpc_perception.core.window.words import several
from bpc_perception.display.plain_json import plain
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.window.rows import DRIVES, law, Row, settings, speed_rows

ROWS = 7  # speeds in the table
UNITS = {'mm3_s': 'mm³/s', 'kpa': 'kPa'}


def show(terminal: Terminal, window: InkWindow) -> None:
    """Show the laws, the window by speed and the recommended setting."""
    failed = [line.name for line in window.lines if not math.isfinite(line.width)]
    terminal.say(f'{len(window.lines)} lines' + (
        f', {len(failed)} without a width: {several(failed)}' if failed else ''))
    if window.proven.drive == Drive.FLOW and any(math.isfinite(line.pressure)
                                                 for line in window.lines):
        terminal.say('the flow is known of all lines: their pressure is not used')
    for model in window.models.values():
        terminal.say(f'{law(model)}; {100 * model.scatter:.1f} % from line to line')
    rows = speed_rows(window)
    for row in rows:
        terminal.emit('speed', '', **plain(row))
    terminal.show(_table(window, rows[::max(1, (len(rows) - 1) // (ROWS - 1))]))
    for each in window.strangers:
        terminal.warn(f'expected {each.name} as the others are, found it '
                      f'{100 * each.deviation:+.0f} % off; look at it, or print it again')
    terminal.emit('settings', recommendation(window), **plain(settings(window)))
    if window.chance < MET:
        terminal.warn(f'expected a setting that is within tolerance with {MET:.0%}, found '
                      f'{window.chance:.0%} at best: lines differ too much; print more lines, or '
                      'allow more with --tolerance')


def recommendation(window: InkWindow) -> str:
    """Return the recommended setting and what to expect of it, in a line."""
    width = window.expected['width']
    low, high = (width.interval[0] * MM_PER_M).tolist()
    value = float(width.value[0]) * MM_PER_M
    values = settings(window)
    name, unit, _ = DRIVES[window.proven.drive]
    setting = f'{values[f"{name}_{unit}"]:.4g} {UNITS[unit]} with {values["speed_mm_s"]:g} mm/s'
    return (f'recommended: {setting}: {value:.3f} ± {value * float(width.mean_sigma[0]):.3f} mm, '
            f'a line {low:.3f} to {high:.3f} mm (95 %); within tolerance with a chance of '
            f'{min(100 * window.chance, 99.9):.1f} %')


def _table(window: InkWindow, rows: list[Row]) -> Table:
    name, unit, _ = DRIVES[window.proven.drive]
    shown = UNITS[unit]
    wanted = window.wanted
    columns = {
        'speed_mm_s': 'speed [mm/s]', f'{name}_low_{unit}': f'{name} from [{shown}]',
        f'{name}_{unit}': 'on target', f'{name}_high_{unit}': 'to',
        'width_spread_mm': 'a line ± [mm]', 'chance': 'chance', 'height_mm': 'height [mm]',
        'area_mm2': 'area [mm²]'}
    columns = {key: heading for key, heading in columns.items() if key in rows[0]}
    table = Table(*map(escape, columns.values()), title=escape(
        f'{wanted.width * MM_PER_M:.4g} mm ± {100 * wanted.tolerance:.3g} %'))
    for row in rows:
        table.add_row(*('-' if math.isnan(row[key]) else f'{row[key]:#.3g}'.rstrip('.')
                        for key in columns))
    return table
