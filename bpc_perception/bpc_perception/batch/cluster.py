"""The processes of a Dask cluster, and recordings measured on them.

Dask sees to it that what a process was doing when it died is done by another. Trying twice is
harmless: a result is put in place whole, with the fingerprint of what it is made of, and a
recording whose result carries the right one is not measured anew. The same makes an interrupted
batch go on.
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


def run(client: Client, todo: Sequence[Job],
        on_progress: Callable[[dict[str, Any], bool], None]) -> list[dict[str, Any]]:
    """Measure recordings on a cluster; their rows, in order.

    Args:
        client: of the cluster, whose processes see the same files by the same names.
        todo: what to measure.
        on_progress: is told each row as it comes, and whether it had to be measured.
    """
    futures = {client.submit(measure_one, job, pure=False): job for job in todo}
    rows = {}
    for future in as_completed(futures):
        job = futures[future]
        error = future.exception()
        # Such as KilledWorker: it has ended one process after the other.
        found, new = (future.result() if error is None else
                      (failed(job.name, DEFECT, repr(error)), True))
        rows[job.name] = found
        on_progress(found, new)
    return [rows[job.name] for job in todo]


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
