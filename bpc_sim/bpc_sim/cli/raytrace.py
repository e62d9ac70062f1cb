"""``bpc raytrace``: makes the pictures of the study ``raytraced``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.options import QuietOption
from bpc_perception.cli.parts.terminal import Terminal


def raytrace(
    folder: Annotated[Path, typer.Argument(
        metavar='FOLDER', help='Where to write a file for each scene.')],
    names: Annotated[list[str] | None, typer.Argument(
        metavar='[NAME]...', help='Of scenes; all, if none is given.')] = None,
    quiet: QuietOption = False,
) -> None:
    """Trace the scenes of the study raytraced anew, by Mitsuba 3 (pip install mitsuba==3.9.0)."""
    # Imported late: this module is loaded with every command.
    from bpc_sim.raytraced.catalogue import SCENES
    from bpc_sim.raytraced.making import make
    from bpc_sim.raytraced.tracer import load_tracer

    terminal = Terminal(quiet)
    known = {scene.name: scene for scene in SCENES}
    unknown = sorted(set(names or ()) - set(known))
    if unknown:
        raise ValueError(f'raytrace: expected names of scenes ({", ".join(known)}), '
                         f'found {", ".join(unknown)}')
    if not folder.is_dir():
        raise ValueError(f'{folder}: expected a folder, found none; make it')
    load_tracer()
    chosen = [known[name] for name in names or known]
    there = [scene.name for scene in chosen if (folder / f'{scene.name}.npz').exists()]
    if there:
        raise ValueError(f'{folder}: expected a folder without these scenes, found '
                         f'{", ".join(there)}; name another folder, or remove them')
    with terminal.progress('raytrace', len(chosen)) as advance:
        for scene in chosen:
            make(folder, scene)
            advance()
