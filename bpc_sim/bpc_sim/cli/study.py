"""``bpc study``: the paper's tables and figures, and what goes beyond them."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import QuietOption
from bpc_perception.cli.parts.terminal import Terminal
from bpc_sim.cli.parts.rows import check_file, table, write_json


def study(
    name: Annotated[str, typer.Argument(
        help='Which: table1, resolution, thickness, hardware, stress, peers, closedloop, '
        'misfortunes, layers, raytraced, verdicts or windows.')],
    json_file: Annotated[Path | None, typer.Option(
        '--json', metavar='FILE', help='Write the rows as a list of flat objects.')] = None,
    plot: Annotated[Path | None, typer.Option(
        metavar='FILE.html',
        help='Draw the figure, of resolution, thickness and closedloop.')] = None,
    seeds: Annotated[int | None, typer.Option(
        min=1, metavar='N', help='How many variants of each print; each study has its own '
        'default.')] = None,
    quiet: QuietOption = False,
) -> None:
    """Run a study on simulated prints of known thickness."""
    # Imported late: this module is loaded with every command, and the studies are slow to load.
    from bpc_sim.studies import STUDIES
    from bpc_sim.studies.sweep_figure import draw_sweep

    terminal = Terminal(quiet)
    if name not in STUDIES:
        raise ValueError(f'study: expected one of {", ".join(STUDIES)}, found {name}')
    check_file(json_file)
    check_plot(plot, name, [key for key, other in STUDIES.items() if other.axes or other.draw])
    chosen = STUDIES[name]
    with terminal.progress(name, None) as advance:
        rows = chosen.run(seeds, progress=advance)
    terminal.show(table(chosen.title, rows))
    write_json(json_file, rows, terminal)
    if plot is not None:
        page = chosen.draw() if chosen.draw else draw_sweep(chosen.title, rows, chosen.axes)
        plot.write_text(page, encoding='utf-8')
        terminal.files([plot])


def check_plot(plot: Path | None, name: str, drawn: Collection[str]) -> None:
    """Raise ValueError unless a study is one that is drawn, and its page can be written there."""
    if plot is None:
        return
    check_file(plot)
    if plot.suffix != '.html':
        raise ValueError(f'{plot}: expected a name that ends in .html, found another; name one')
    if name not in drawn:
        raise ValueError(f'--plot: expected a study with a figure ({", ".join(drawn)}), '
                         f'found {name}')
