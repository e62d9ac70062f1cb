"""The files that tell the window of an ink, and the folder they are written into."""

from __future__ import annotations

from collections.abc import Sequence
import json
from pathlib import Path
import re

from bpc_perception.core.window.assess import InkWindow
from bpc_perception.files.settings_file import settings_file
from bpc_perception.report.pages import window_page
from bpc_perception.report.result_folder import expect_room_for, replacing
from bpc_perception.report.window.rows import settings, window_csv, window_json

TABLE, VALUES, SETTINGS, PAGE = 'window.csv', 'window.json', 'next_print.yaml', 'window.html'
OURS = re.compile(r'window\.(csv|json|html|pdf|svg)|next_print\.yaml')


def check_out(folder: Path, sources: Sequence[str]) -> None:
    """Raise ValueError if files would replace what is not the window of these sweeps."""
    if expect_room_for(folder, 'the window') != folder:
        return
    there = sorted(path.name for path in folder.iterdir() if OURS.fullmatch(path.name))
    if not there or _sweeps_of(folder / VALUES) == list(sources):
        return
    found = _sweeps_of(folder / VALUES)
    what = f'that of {", ".join(map(str, found))}' if found else there[0]
    raise ValueError(f'{folder}: expected no window there but that of {", ".join(sources)}, '
                     f'found {what}; name another folder with --out')


def write(folder: Path, window: InkWindow, sources: Sequence[str], parameters: Path | None,
          figures: bool) -> list[Path]:
    """Write table, values, page, settings file, and a figure if wanted, all or none.

    Args:
        folder: made if missing.
        window: of an ink.
        sources: the sweeps that it is from.
        parameters: parameter file whose values the settings file keeps; None = there is none.
        figures: whether a figure for papers is wanted.

    Returns:
        The files.

    Raises OSError if the folder cannot be written to, HeldError if another process does that now,
    ValueError if the parameter file is none.
    """
    wanted = window.wanted
    texts = {TABLE: window_csv(window), VALUES: window_json(window, sources),
             PAGE: window_page.render(window, sources),
             SETTINGS: settings_file(settings(window), wanted.width, wanted.tolerance,
                                     parameters)}
    files = {name: text.encode('utf-8', 'replace') for name, text in texts.items()}
    if figures:
        # Imported late: matplotlib is an extra, and is slow to load.
        from bpc_perception.report.window.figure import draw_window

        files |= draw_window(window)
    with replacing(folder, OURS, VALUES) as new:
        for name, data in files.items():
            (new / name).write_bytes(data)
    return [folder / name for name in files]


def _sweeps_of(file: Path) -> list[object] | None:
    """Return the sweeps that an earlier file is about; None = it is not ours, or not there."""
    try:
        found = json.loads(file.read_text('utf-8'))['sweeps']
        return list(found)
    except (OSError, ValueError, LookupError, TypeError):
        return None
