"""What a measurement leaves behind: profile.csv, summary.json and report.html.

People read these files, so lengths are in millimetres here, and nowhere else but in the
report's figures.
"""

from __future__ import annotations

from importlib.util import find_spec
import json
import math
import os
from pathlib import Path
import tempfile
from typing import Any

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.report import html
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance
from bpc_perception.report.summary import advice_entry, MM, NS, plain
from bpc_perception.report.uniformity import uniformity

COLUMNS = ('arc_length_mm', 'time_s', 'x_mm', 'y_mm', 'z_mm', 'thickness_mm', 'sigma_mm',
           'left_mm', 'right_mm', 'status')


def write_outputs(folder: Path, log: PrintLog, provenance: Provenance,
                  figures: bool = False) -> list[Path]:
    """Write profile.csv, summary.json and report.html of the result that is reported.

    A file is either put in place whole or not at all: all are complete beside their place before
    the first one moves there.

    Args:
        folder: where to; made if missing.
        log: what came of the captures; refused ones are listed in summary and report.
        provenance: where the results come from.
        figures: write figures for papers, too, into a folder ``figures``.

    Raises:
        ValueError: no result was measured, or there is no matplotlib for the figures.
        OSError: the folder cannot be written to.
    """
    result = log.reported
    if result is None or result.profile is None:
        refusals = '; '.join(log.refusals) or 'no captures'
        raise ValueError(f'expected a measured capture, found none: {refusals}')
    summary = summarize(log, provenance)
    # A file name need not be valid Unicode; that must not cost the user the result.
    files = {name: text.encode('utf-8', 'replace') for name, text in (
        ('profile.csv', profile_csv(result.profile)),
        ('summary.json', json.dumps(summary, indent=2, allow_nan=False) + '\n'),
        ('report.html', html.render(log, summary, provenance.targets)))}
    if figures:
        # Imported late: matplotlib is an extra, and takes its time.
        from bpc_perception.report.paper_figures import draw_figures

        files |= {f'figures/{name}': data
                  for name, data in draw_figures(result, provenance.targets).items()}

    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=folder) as beside:
        for name, data in files.items():
            file = Path(beside, name)
            file.parent.mkdir(exist_ok=True)
            file.write_bytes(data)
        if figures:
            (folder / 'figures').mkdir(exist_ok=True)
        # The summary comes last: where its fingerprint is right, so is all the rest.
        for name in sorted(files, key='summary.json'.__eq__):
            os.replace(Path(beside, name), folder / name)
    return [folder / name for name in files]


def profile_csv(profile: ThicknessProfile) -> str:
    """The profile as a table, one sample a line; an empty cell = unknown.

    Numbers have as many digits as it takes to read the same number back.
    """
    known = np.isin(profile.status, (Status.MEASURED, Status.GAP))
    columns = (
        _cells(profile.arc_length * MM),
        [_seconds(profile.print_start_ns + round(time * NS)) for time in profile.time.tolist()],
        *(_cells(axis * MM) for axis in profile.points.T),
        _cells(np.where(known, profile.thickness, np.nan) * MM),
        *(_cells(values * MM) for values in (profile.sigma, profile.left, profile.right)),
        [Status(value).name for value in profile.status])
    rows = (COLUMNS, *zip(*columns, strict=True))
    return ''.join(','.join(row) + '\n' for row in rows)


def summarize(log: PrintLog, provenance: Provenance) -> dict[str, Any]:
    """The content of summary.json: the result reported, every capture, the provenance."""
    result = log.reported
    assert result is not None
    profile = result.profile
    assert profile is not None
    assert result.advice is not None
    statistics = profile.summary
    even = uniformity(profile, provenance.targets)
    content = {
        **log.entries[log.place],
        'method': profile.method,
        'thickness_q1_mm': statistics.thickness_q1 * MM,
        'thickness_median_mm': statistics.thickness_median * MM,
        'thickness_q3_mm': statistics.thickness_q3 * MM,
        'thickness_variation': even.variation,
        'within_10_percent': even.within,
        'gaps': [{'start_mm': start, 'end_mm': end}
                 for start, end in (profile.gaps * MM).tolist()],
        'offset_mean_mm': statistics.offset_mean * MM,
        'offset_rms_mm': statistics.offset_rms * MM,
        'warnings': [*log.warnings, *([result.warning] if result.warning else [])],
        'advice': advice_entry(result.advice),
        'captures': log.entries,
        'bag': provenance.bag,
        'hand_eye': provenance.hand_eye,
        'settings': provenance.settings,
        'versions': provenance.versions,
        'fingerprint': provenance.fingerprint,
    }
    made: dict[str, Any] = plain(content)
    return made


def _cells(values: Array) -> list[str]:
    return ['' if math.isnan(value) else repr(value) for value in values.tolist()]


def _seconds(stamp_ns: int) -> str:
    """Nanoseconds as seconds, to the last digit."""
    whole, rest = divmod(stamp_ns, NS)
    return f'{whole}.{rest:09d}'


def check_figures(wanted: bool) -> None:
    """Raise ValueError if figures are wanted and there is nothing to draw them."""
    if wanted and find_spec('matplotlib') is None:
        raise ValueError('--figures: expected the package matplotlib, found none')


def check_out(folder: Path) -> None:
    """Raise ValueError unless outputs can go to this folder, made if missing."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise ValueError(f'{folder}: expected a folder for the outputs, '
                         f'found that {existing} is a file')
