"""The recordings of a batch, and how each is measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
import logging
from pathlib import Path
from typing import Any

import cv2

from bpc_perception.batch.finding import find_bags
from bpc_perception.batch.table import failed, row
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import capture_count
from bpc_perception.recording.offline import measure_bag
from bpc_perception.report.print_results import PrintResults, Wanted
from bpc_perception.report.provenance import provenance_of
from bpc_perception.report.result_folder import (
    check_recording,
    holds_recording,
    read_summary,
    replacing,
    SUMMARY,
)
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
        others: topic to the one that is to be read in its place.
    """

    name: str
    bag: Path
    out: Path
    hand_eye: Path | None
    parameters: Path | None
    others: Mapping[str, str]


def find_jobs(folder: Path, out: Path, hand_eye: Path | None, parameters: Path | None,
              others: Mapping[str, str] | None = None) -> list[Job]:
    """Return the recordings below a folder, each with a folder of its own for the results.

    Raises:
        ValueError: there are none, or results would get into the folder of one, or beside the
            result of one.
    """
    if (out / SUMMARY).exists():
        raise ValueError(f'{out}: expected a folder without a result right in it, found {SUMMARY};'
                         ' name another folder with --out')
    bags = find_bags(folder)
    if not bags:
        raise ValueError(f'{folder}: expected recordings in it or below, found none; name one '
                         'above them')
    names = result_names(folder, bags)
    for name in names:
        if recorded := holds_recording(out / name):
            raise ValueError(f'{out}: expected a folder apart from the recordings, found '
                             f'{name}/{recorded} in it; name another folder with --out')
    return [Job(name, bag.absolute(), (out / name).absolute(), hand_eye and hand_eye.absolute(),
                parameters and parameters.absolute(), dict(others or {}))
            for name, bag in zip(names, bags, strict=True)]


def result_names(folder: Path, bags: list[Path]) -> list[str]:
    """Return a name for the results of each recording below a folder, none within another.

    A recording is named by its path. One with others below it gets a folder beside those.
    """
    names: list[str] = []
    for bag in reversed(bags):  # those below a folder before it
        name = bag.relative_to(folder)
        if bag == folder or any(bag in other.parents for other in bags):
            name /= bag.absolute().name
        while str(name) in names or any(str(name) == str(parent) for other in names
                                        for parent in Path(other).parents):
            name = name.with_name(f'{name.name}_')
        names.append(str(name))
    return names[::-1]


def measure_one(job: Job) -> tuple[list[dict[str, Any]], bool]:
    """Measure a recording, unless there is a result made from the same.

    Returns:
        A row for each of its prints; one that says why if it cannot be measured. And whether it
        had to be measured.
    """
    cv2.setNumThreads(1)  # each core has a process of its own
    held = HeldWarnings()
    logging.getLogger('bpc_perception').addHandler(held)
    try:
        recording = inputs.load(job.bag, job.hand_eye, job.parameters, job.others)
        provenance = provenance_of(recording)
        if (rows := finished(job, provenance.fingerprint)) is not None:
            return rows, False
        check_recording(job.out, job.bag)
        with replacing(job.out) as folder:
            results = PrintResults(folder, provenance, Wanted(), capture_count(recording.bag),
                                   lambda: held.texts)
            for result in measure_bag(recording.bag, recording.hand_eye, recording.thickness,
                                      recording.recorder, recording.print_id):
                results.add(result)
            results.finish()
        rows = finished(job, provenance.fingerprint)
        if rows is None:
            raise RuntimeError(f'{job.out}: expected the result just written, found another'
                               '; let one batch alone write there')
        return rows, True
    except (ValueError, OSError) as error:
        return [failed(job.name, REFUSED, '; '.join((str(error), *held.texts)))], True
    finally:
        logging.getLogger('bpc_perception').removeHandler(held)


def finished(job: Job, fingerprint: str) -> list[dict[str, Any]] | None:
    """Return the rows of a result with this fingerprint; None if there is none."""
    try:
        summary = read_summary(job.out)
        if summary['fingerprint'] != fingerprint:
            return None
        prints = summary.get('prints')
        if prints is None:
            return [row(job.name, job.out, 1, summary)]
        folders = [job.out / each['folder'] for each in prints]
        return [row(job.name, folder, each['print'], read_summary(folder))
                for folder, each in zip(folders, prints, strict=True)]
    except (OSError, ValueError, LookupError, TypeError):
        return None
