"""What a command says: lines for people, JSON for scripts, or nothing but errors.

Everything goes to stdout, errors to stderr. Bars, live views and colours are for a terminal only,
and colours for one without NO_COLOR, which rich sees to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
import json
from pathlib import Path
import sys
import time
from typing import Any

from rich.console import Console, RenderableType
from rich.live import Live
from rich.measure import Measurement
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

from bpc_perception.report.entries import plain
from bpc_perception.runtime.held_warnings import HeldWarnings

WIDEST = 1000  # of a table [characters]
VIEW_PERIOD = 0.2  # of a live view [s]

Advance = Callable[..., None]


WARNINGS = HeldWarnings()


class Terminal:
    """How a command talks.

    With ``json_lines`` everything is an object of its own line, with what it is about under
    ``event``; with ``quiet`` there is nothing.
    """

    newest: Terminal | None = None  # that of the running command, which says what was kept

    def __init__(self, quiet: bool = False, json_lines: bool = False) -> None:
        if quiet and json_lines:
            raise ValueError('expected --quiet or --json, found both')
        self._quiet, self._json = quiet, json_lines
        self._console = Console(highlight=False)
        self._live: Live | None = None
        self._drawn = 0.0
        Terminal.newest = self

    @property
    def lively(self) -> bool:
        """Whether somebody looks at bars and views."""
        return self._console.is_terminal and not (self._quiet or self._json)

    @property
    def width(self) -> int:
        """Letters in a line."""
        return self._console.width

    def say(self, text: str) -> None:
        """A line for people, who are told nothing else by it than by the events."""
        if not (self._quiet or self._json):
            self._console.print(text, soft_wrap=True, markup=False)

    def show(self, table: RenderableType) -> None:
        """A table for people, rather wider than the terminal than with numbers cut short."""
        if not (self._quiet or self._json):
            wide = Console(width=WIDEST)
            least = Measurement.get(wide, wide.options, table).maximum
            Console(width=max(self._console.width, least)).print(table)

    def tell(self, event: str, text: str, /, **values: object) -> None:
        """Something that scripts want to know; the text, if any, is for people."""
        if text:
            self.say(text)
        if self._json:
            # ASCII only: a file name need not be valid Unicode.
            print(json.dumps({'event': event, **plain(values)}, allow_nan=False), flush=True)

    def warn(self, text: str) -> None:
        """Something to look into, which does not stop the command."""
        if self._json:
            self.tell('warning', '', text=text)
        elif not self._quiet:
            print(f'bpc: {text}', file=sys.stderr)

    def files(self, paths: Iterable[Path]) -> None:
        """The files that were written."""
        for path in paths:
            self.tell('file', str(path), path=str(path))

    @contextmanager
    def progress(self, what: str, total: int | None) -> Iterator[Advance]:
        """A bar with rate and time left while the block runs; call what it gives after each step.

        It may also be called with ``completed`` and ``total``, where these are found out on the
        way.
        """
        # Output that goes into a file leaves the other stream to look at.
        console = self._console if self._console.is_terminal else Console(stderr=True)
        shown = console.is_terminal and not (self._quiet or self._json)
        columns = (TextColumn('{task.description}'), BarColumn(), MofNCompleteColumn(), Rate(),
                   TimeElapsedColumn(), TimeRemainingColumn())
        # Drawn by nobody but us: a thread that draws would be timed with what is timed.
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
                if shown and time.monotonic() - drawn > VIEW_PERIOD / 2:
                    drawn = time.monotonic()
                    bar.refresh()

            yield advance

    @contextmanager
    def view(self) -> Iterator[None]:
        """A view below the lines, kept up to date by ``draw`` while the block runs."""
        if not self.lively:
            yield
            return
        with Live(console=self._console, auto_refresh=False, transient=True,
                  redirect_stdout=False, redirect_stderr=False) as self._live:
            try:
                yield
            finally:
                self._live = None

    def draw(self, make: Callable[[], RenderableType]) -> None:
        """Draw the view anew, if there is one and the last is of some time ago."""
        if self._live is not None and time.monotonic() - self._drawn > VIEW_PERIOD:
            self._drawn = time.monotonic()
            self._live.update(make(), refresh=True)


def tell_warnings(held: HeldWarnings = WARNINGS) -> None:
    """Say all warnings that were kept, as the command's terminal says warnings."""
    terminal = Terminal.newest or Terminal()
    for text in held.texts:
        terminal.warn(text)


class Rate(ProgressColumn):
    """Steps a second."""

    def render(self, task: Task) -> Text:
        """The rate, or nothing before it is known."""
        speed: Any = task.finished_speed or task.speed
        return Text('' if speed is None else f'{speed:.3g}/s')
