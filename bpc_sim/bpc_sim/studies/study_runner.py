"""Studies: independent tasks, run in processes, and the rows made of their results."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any, Generic, TypeVar

import cv2

Row = dict[str, Any]  # flat; units in the names
Task = TypeVar('Task')
Found = TypeVar('Found')
METHODS = ('cross_section', 'paper')


@dataclass(frozen=True)
class Study(Generic[Task, Found]):
    """A table about simulated prints of known thickness.

    Attributes:
        title: what the rows show.
        tasks: returns the tasks for a number of seeds.
        work: does one task, in a process of its own.
        rows: makes the table from the results, in the order of the tasks.
        seeds: default number of variants of each print.
        processes: how many tasks run at once; 1 where time is measured.
        axes: for a figure, the names of the column along x and of those along y.
        draw: makes a page of its own instead, which does not show the rows.
    """

    title: str
    tasks: Callable[[int], Sequence[Task]]
    work: Callable[[Task], Found]
    rows: Callable[[list[Found]], list[Row]]
    seeds: int = 1
    processes: int = 1
    axes: tuple[str, ...] = ()
    draw: Callable[[], str] | None = None

    def run(self, seeds: int | None = None, processes: int | None = None,
            progress: Callable[[int, int], None] | None = None) -> list[Row]:
        """Return the rows; ``progress`` is called with the number of tasks done and of all."""
        tasks = self.tasks(self.seeds if seeds is None else seeds)
        found = []
        for result in self._results(tasks, processes or self.processes):
            found.append(result)
            if progress is not None:
                progress(len(found), len(tasks))
        return self.rows(found)

    def _results(self, tasks: Sequence[Task], processes: int) -> Iterator[Found]:
        if processes == 1:
            yield from map(self.work, tasks)
            return
        # Spawned, since a fork would copy OpenCV without its threads.
        with ProcessPoolExecutor(processes, get_context('spawn'), cv2.setNumThreads, (1,)) as pool:
            yield from pool.map(self.work, tasks)
