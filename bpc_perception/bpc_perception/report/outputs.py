"""The files that a measurement leaves in a folder: profile.csv, summary.json and report.html.

Where there is something to mend, repair.csv as well.

People read these files: their lengths are in millimetres, unlike those of messages and parameters.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from importlib.util import find_spec
import json
import os
from pathlib import Path
import tempfile

from bpc_perception.report.pages import report_page
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.profile_table import profile_csv
from bpc_perception.report.provenance import Provenance
from bpc_perception.report.repair_table import REPAIR, repair_csv
from bpc_perception.report.summary import summarize
from bpc_perception.report.tables.files import table_files
from bpc_perception.report.tables.of_print import result_tables

FIGURES = 'figures'  # the folder for figures for papers


def write_outputs(folder: Path, log: PrintLog, provenance: Provenance,
                  figures: bool = False, formats: Collection[str] = ()) -> list[Path]:
    """Write profile.csv, summary.json and report.html of the result that is reported.

    And repair.csv, if it has strokes that fill; one that was written before goes if it has none.

    A file is either put in place whole or not at all: all are complete beside their place before
    the first one moves there.

    Args:
        folder: where to; made if missing.
        log: what came of the captures; refused ones are listed in summary and report.
        provenance: where the results come from.
        figures: write figures for papers, too, into a folder ``figures``.
        formats: of other programs that the profile is written for as well.

    Returns:
        The files that were written.

    Raises:
        ValueError: no result was measured, or there is no matplotlib for the figures.
        OSError: the folder cannot be written to.
    """
    files = _contents(log, provenance, figures, formats)
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=folder) as beside:
        for name, data in files.items():
            file = Path(beside, name)
            file.parent.mkdir(exist_ok=True)
            file.write_bytes(data)
        if figures:
            (folder / FIGURES).mkdir(exist_ok=True)
        # Move the summary last: where its fingerprint is right, all the rest is in place.
        for name in sorted(files, key='summary.json'.__eq__):
            os.replace(Path(beside, name), folder / name)
    if REPAIR not in files:
        (folder / REPAIR).unlink(missing_ok=True)
    return [folder / name for name in files]


def _contents(log: PrintLog, provenance: Provenance, figures: bool,
              formats: Collection[str]) -> Mapping[str, bytes]:
    """Return the contents of the files by name."""
    result = log.reported
    if result is None or result.profile is None:
        refusals = '; '.join(log.refusals) or 'no captures'
        raise ValueError(f'expected a measured capture, found none: {refusals}')
    summary = summarize(log, provenance)
    texts = {'profile.csv': profile_csv(result.profile, result.design),
             'summary.json': json.dumps(summary, indent=2, allow_nan=False) + '\n',
             'report.html': report_page.render(log, summary, provenance.targets_of(result))}
    # A file name need not be valid Unicode; that must not cost the user the result.
    files = {name: text.encode('utf-8', 'replace') for name, text in texts.items()}
    if result.repair is not None and result.repair.fills:
        files[REPAIR] = repair_csv(result.repair).encode()
    files |= table_files('profile', result_tables(result.profile, result.design),
                         formats)
    if figures:
        # Imported late: matplotlib is an extra, and is slow to load.
        from bpc_perception.report.publication_figures import draw_figures

        files |= {f'{FIGURES}/{name}': data
                  for name, data in draw_figures(result, provenance.targets_of(
                      result)).items()}
    return files


def check_figures(wanted: bool) -> None:
    """Raise ValueError if figures are wanted and there is nothing to draw them with."""
    if wanted and find_spec('matplotlib') is None:
        raise ValueError('--figures: expected the package matplotlib, found none'
                         '; install it, as with pip, or leave out --figures')
