"""A progress bar with rate and time left."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import time
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

DRAW_PERIOD_S = 0.1

# Called without arguments after each step, or with the steps completed and their total.
Advance = Callable[..., None]


@contextmanager
def progress_bar(console: Console, what: str, total: int | None, shown: bool) -> Iterator[Advance]:
    """Show a bar while the block runs, and clear it at the end.

    Args:
        console: to draw on.
        what: is done; stands in front of the bar.
        total: number of steps; None = not known.
        shown: False = the bar is not drawn.
    """
    columns = (TextColumn('{task.description}'), BarColumn(), MofNCompleteColumn(), Rate(),
               TimeElapsedColumn(), TimeRemainingColumn())
    # Draw it only here: a thread that draws would disturb what is timed meanwhile.
    with Progress(*columns, console=console, transient=True, auto_refresh=False,
                  disable=not shown, redirect_stdout=False, redirect_stderr=False) as bar:
        task = bar.add_task(what, total=total)
        drawn = 0.0

        def advance(completed: int | None = None, total: int | None = None) -> None:
            nonlocal drawn
            if completed is None:
                bar.advance(task)
            else:
                bar.update(task, completed=completed, total=total)
            if shown and time.monotonic() - drawn > DRAW_PERIOD_S:
                drawn = time.monotonic()
                bar.refresh()

        yield advance


class Rate(ProgressColumn):
    """Steps per second."""

    def render(self, task: Task) -> Text:
        """Return the rate, or nothing before it is known."""
        speed: Any = task.finished_speed or task.speed
        return Text('' if speed is None else f'{speed:.3g}/s')
