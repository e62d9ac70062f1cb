"""The processes of a Dask cluster, and recordings measured on them.

When a process dies Dask gives its work to another one. To measure twice is harmless: a result is
put in place whole, with the fingerprint of what it is made from, and a recording whose result has
the right fingerprint is not measured again. For the same reason an interrupted batch can go on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
import logging
import tempfile
from typing import Any

import dask.config
from distributed import as_completed, Client, LocalCluster

from bpc_perception.batch.jobs import Job, measure_one
from bpc_perception.batch.table import failed
from bpc_perception.runtime.exit_status import DEFECT

LOOPBACK = '127.0.0.1'
CONNECT_TIMEOUT_S = 10


def run(client: Client, jobs: Sequence[Job],
        on_progress: Callable[[dict[str, Any], bool], None]) -> list[dict[str, Any]]:
    """Measure recordings on a cluster; return their rows in order.

    Args:
        client: of the cluster, whose processes see the same files by the same names.
        jobs: what to measure.
        on_progress: is called with the row of each print as it comes, and whether it had to be
            measured.
    """
    futures = {client.submit(measure_one, job, pure=False): job for job in jobs}
    rows = {}
    for future in as_completed(futures):
        job = futures[future]
        error = future.exception()
        if error is None:
            rows[job.name], new = future.result()
        else:  # such as KilledWorker: the recording has ended one process after the other
            rows[job.name], new = [failed(job.name, DEFECT, repr(error))], True
        for row in rows[job.name]:
            on_progress(row, new)
    return [row for job in jobs for row in rows[job.name]]


@contextmanager
def cluster(scheduler: str | None, workers: int) -> Iterator[Client]:
    """Give the block the client of a cluster, one on this computer unless a scheduler is named.

    Args:
        scheduler: address of a running cluster; None = start one, which ends with the block.
        workers: number of processes to start.

    Raises:
        OSError: nobody answers at the scheduler's address.
    """
    if scheduler is not None:
        with Client(scheduler, timeout=CONNECT_TIMEOUT_S) as client:
            yield client
        return
    silence()
    with (tempfile.TemporaryDirectory(prefix='bpc-batch-') as folder,
          # Serve no dashboard, and nothing in its place.
          dask.config.set({f'distributed.{side}.http.routes': []
                           for side in ('scheduler', 'worker')}),
          LocalCluster(workers, threads_per_worker=1, host=LOOPBACK,
                       dashboard_address=f'{LOOPBACK}:0', scheduler_kwargs={'dashboard': False},
                       local_directory=folder) as local,
          Client(local) as client):
        client.register_worker_callbacks(silence)
        yield client


def silence() -> None:
    """Let a process of a cluster say nothing: failures are in the table."""
    logging.getLogger('distributed').setLevel(logging.CRITICAL)
