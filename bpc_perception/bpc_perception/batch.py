"""Many recordings measured at once, by the processes of a Dask cluster.

Dask sees to it that what a process was doing when it died is done by another. Trying twice is
harmless: a result is put in place whole, with the fingerprint of what it is made of, and a
recording whose result carries the right one is not measured anew. The same makes an interrupted
batch go on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
import json
import logging
import os
from pathlib import Path
import shutil
import tempfile
from typing import Any

import cv2
import dask.config
from distributed import as_completed, Client, LocalCluster
import pyarrow
from pyarrow import csv, parquet

from bpc_perception.cli import inputs
from bpc_perception.cli.terminal import HeldWarnings
from bpc_perception.exit_status import DEFECT, REFUSED
from bpc_perception.offline import measure_bag
from bpc_perception.outputs import write_outputs
from bpc_perception.print_log import PrintLog
from bpc_perception.recording import capture_count

LOOPBACK = '127.0.0.1'
NUMBERS = ('path_length_mm', 'thickness_mean_mm', 'thickness_std_mm', 'thickness_q1_mm',
           'thickness_median_mm', 'thickness_q3_mm', 'thickness_variation', 'within_10_percent',
           'coverage', 'gap_length_mm', 'offset_mean_mm', 'offset_rms_mm')
COUNTS = ('capture', 'samples', 'gap_count')
TEXTS = ('print_id', 'method', 'hand_eye', 'fingerprint')
SCHEMA = pyarrow.schema([
    ('bag', pyarrow.string()), ('exit_status', pyarrow.int32()), ('reason', pyarrow.string()),
    ('results', pyarrow.string()), *((name, pyarrow.string()) for name in TEXTS),
    *((name, pyarrow.int64()) for name in COUNTS), ('captures', pyarrow.int64()),
    ('refused_captures', pyarrow.int64()), ('warnings', pyarrow.string()),
    *((name, pyarrow.float64()) for name in NUMBERS)])


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


def jobs(folder: Path, out: Path, hand_eye: Path | None, parameters: Path | None) -> list[Job]:
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
        provenance = given.provenance
        if (summary := finished(job.out, provenance.fingerprint)) is not None:
            return row(job, summary), False
        for left in job.out.glob('.bpc-*'):  # of a process that was killed
            shutil.rmtree(left, ignore_errors=True)
        log = PrintLog(expected=capture_count(given.bag))
        for result in measure_bag(given.bag, given.hand_eye, given.thickness, given.recorder):
            log.add(result)
        log.warnings = list(held.texts)
        write_outputs(job.out, log, provenance)
        return row(job, finished(job.out, provenance.fingerprint)), True
    except (ValueError, OSError) as error:
        return failed(job, REFUSED, '; '.join((str(error), *held.texts))), True
    finally:
        logging.getLogger('bpc_perception').removeHandler(held)


def finished(out: Path, fingerprint: str) -> dict[str, Any] | None:
    """The summary of a result made of just this; None if there is none."""
    try:
        summary: dict[str, Any] = json.loads((out / 'summary.json').read_text('utf-8'))
        return summary if summary['fingerprint'] == fingerprint else None
    except (OSError, ValueError, LookupError, TypeError):
        return None


def row(job: Job, summary: dict[str, Any] | None) -> dict[str, Any]:
    """A measured recording in the table."""
    if summary is None:
        raise RuntimeError(f'{job.out}: expected the result just written, found another')
    captures = summary['captures']
    return {'bag': job.name, 'exit_status': 0, 'reason': '', 'results': str(job.out),
            **{name: summary[name] for name in (*TEXTS, *COUNTS, *NUMBERS)},
            'captures': len(captures),
            'refused_captures': sum('refusal' in each for each in captures),
            'warnings': '; '.join(summary['warnings'])}


def failed(job: Job, status: int, reason: str) -> dict[str, Any]:
    """A recording in the table that was not measured, and why."""
    return {**dict.fromkeys(SCHEMA.names), 'bag': job.name, 'exit_status': status,
            'reason': ' '.join(reason.split())}


def run(client: Client, todo: Sequence[Job],
        told: Callable[[dict[str, Any], bool], None]) -> list[dict[str, Any]]:
    """Measure recordings on a cluster; their rows, in order.

    Args:
        client: of the cluster, whose processes see the same files by the same names.
        todo: what to measure.
        told: is told each row as it comes, and whether it had to be measured.
    """
    futures = {client.submit(measure_one, job, pure=False): job for job in todo}
    rows = {}
    for future in as_completed(futures):
        job = futures[future]
        error = future.exception()
        # Such as KilledWorker: it has ended one process after the other.
        found, new = (future.result() if error is None else
                      (failed(job, DEFECT, repr(error)), True))
        rows[job.name] = found
        told(found, new)
    return [rows[job.name] for job in todo]


def write_table(out: Path, rows: list[dict[str, Any]]) -> list[Path]:
    """Write the rows as prints.csv and prints.parquet, each put in place whole."""
    table = pyarrow.Table.from_pylist(rows, SCHEMA)
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix='.bpc-', dir=out) as beside:
        csv.write_csv(table, Path(beside, 'prints.csv'))
        parquet.write_table(table, Path(beside, 'prints.parquet'))
        for name in ('prints.csv', 'prints.parquet'):
            os.replace(Path(beside, name), out / name)
    return [out / 'prints.csv', out / 'prints.parquet']


@contextmanager
def cluster(scheduler: str | None, workers: int) -> Iterator[Client]:
    """A running cluster's client, or that of one on this computer, which ends with the block.

    Raises:
        OSError: nobody answers at the scheduler's address.
    """
    if scheduler is not None:
        with Client(scheduler, timeout=10) as client:
            yield client
        return
    logging.getLogger('distributed').setLevel(logging.CRITICAL)  # what fails is in the table
    with (tempfile.TemporaryDirectory(prefix='bpc-batch-') as folder,
          # No dashboard, and what answers instead has nothing to tell.
          dask.config.set({f'distributed.{side}.http.routes': []
                           for side in ('scheduler', 'worker')}),
          LocalCluster(workers, threads_per_worker=1, host=LOOPBACK,
                       dashboard_address=f'{LOOPBACK}:0', scheduler_kwargs={'dashboard': False},
                       local_directory=folder) as local,
          Client(local) as client):
        yield client
