"""The recordings of a batch, and what is done with each."""

from __future__ import annotations

from dataclasses import dataclass
import json
import logging
import os
from pathlib import Path
import shutil
from typing import Any

import cv2

from bpc_perception.batch.table import failed, row
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import capture_count
from bpc_perception.recording.offline import measure_bag
from bpc_perception.report.outputs import write_outputs
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import provenance_of
from bpc_perception.runtime.exit_status import REFUSED
from bpc_perception.runtime.held_warnings import HeldWarnings


@dataclass(frozen=True)
class Job:
    """A recording to measure.

    Attributes:
        name: path of the recording below the folder that is searched.
        bag: the recording.
        out: folder for its results.
        hand_eye, parameters: files for it; None = those beside it.
    """

    name: str
    bag: Path
    out: Path
    hand_eye: Path | None
    parameters: Path | None


def find_bags(folder: Path) -> list[Path]:
    """All recordings in a folder and below, in order.

    A folder is one if it has a metadata.yaml, or files called like it, as a killed recorder leaves
    them. Other .mcap and .db3 files are recordings each by itself.
    """
    found = []
    for place, folders, names in os.walk(folder):
        folders.sort()
        path = Path(place)
        files = [path / name for name in sorted(names) if name.endswith(('.mcap', '.db3'))]
        if files and ('metadata.yaml' in names or all(
                file.name.startswith(f'{path.absolute().name}_') for file in files)):
            found.append(path)
        else:
            found += files
    return found


def find_jobs(folder: Path, out: Path, hand_eye: Path | None,
              parameters: Path | None) -> list[Job]:
    """The recordings below a folder, each with a folder of its own for the results.

    Raises:
        ValueError: there are none.
    """
    bags = find_bags(folder)
    if not bags:
        raise ValueError(f'{folder}: expected recordings in it or below, found none')
    names = [str(bag.relative_to(folder)) if bag != folder else folder.absolute().name
             for bag in bags]
    return [Job(name, bag.absolute(), (out / name).absolute(), hand_eye and hand_eye.absolute(),
                parameters and parameters.absolute())
            for name, bag in zip(names, bags, strict=True)]


def measure_one(job: Job) -> tuple[dict[str, Any], bool]:
    """Measure a recording, unless that is done; its row, and whether it had to be measured.

    What cannot be measured has a row that says why.
    """
    cv2.setNumThreads(1)  # the other cores have processes of their own
    held = HeldWarnings()
    logging.getLogger('bpc_perception').addHandler(held)
    try:
        given = inputs.load(job.bag, job.hand_eye, job.parameters)
        provenance = provenance_of(given)
        if (summary := finished(job.out, provenance.fingerprint)) is not None:
            return row(job.name, job.out, summary), False
        for left in job.out.glob('.bpc-*'):  # of a process that was killed
            shutil.rmtree(left, ignore_errors=True)
        log = PrintLog(expected=capture_count(given.bag))
        for result in measure_bag(given.bag, given.hand_eye, given.thickness, given.recorder):
            log.add(result)
        log.warnings = list(held.texts)
        write_outputs(job.out, log, provenance)
        return row(job.name, job.out, finished(job.out, provenance.fingerprint)), True
    except (ValueError, OSError) as error:
        return failed(job.name, REFUSED, '; '.join((str(error), *held.texts))), True
    finally:
        logging.getLogger('bpc_perception').removeHandler(held)


def finished(out: Path, fingerprint: str) -> dict[str, Any] | None:
    """The summary of a result made of just this; None if there is none."""
    try:
        summary: dict[str, Any] = json.loads((out / 'summary.json').read_text('utf-8'))
        return summary if summary['fingerprint'] == fingerprint else None
    except (OSError, ValueError, LookupError, TypeError):
        return None
