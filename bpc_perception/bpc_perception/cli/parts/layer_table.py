"""What each layer of a print came to, a line for each."""

from __future__ import annotations

from rich.markup import escape
from rich.table import Table

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.display.plain_json import plain
from bpc_perception.display.plain_text import one_line
from bpc_perception.report.comparison import LAYER_COLUMNS
from bpc_perception.report.entries import layer_entries


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
