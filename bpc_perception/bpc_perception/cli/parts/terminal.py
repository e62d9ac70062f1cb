"""What a command says: lines for people, JSON for scripts, or nothing but errors.

Everything goes to stdout, errors go to stderr. Bars, live views and colours are for a terminal
only, and colours only without NO_COLOR, which rich takes care of.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
import json
from pathlib import Path
import sys
import time

from rich.console import Console, RenderableType
from rich.live import Live
from rich.measure import Measurement

from bpc_perception.cli.parts.progress import Advance, progress_bar
from bpc_perception.display.plain_json import plain
from bpc_perception.display.plain_text import one_line, printable
from bpc_perception.runtime.held_warnings import HeldWarnings

WIDEST_TABLE = 1000  # letters
VIEW_PERIOD_S = 0.2

WARNINGS = HeldWarnings()


class Terminal:
    """The output of a command.

    With ``json_lines`` everything is a JSON object in a line of its own, with what it is about
    under ``event``; with ``quiet`` there is nothing.

    Raises:
        ValueError: both are wanted.
    """

    newest: Terminal | None = None  # that of the running command, for warnings that were held

    def __init__(self, quiet: bool = False, json_lines: bool = False) -> None:
        if quiet and json_lines:
            raise ValueError('expected --quiet or --json, found both; give one of them')
        self._for_people = not (quiet or json_lines)
        self._quiet, self._json = quiet, json_lines
        self._console = Console(highlight=False, emoji=False)
        self._live: Live | None = None
        self._drawn = 0.0
        Terminal.newest = self

    @property
    def lively(self) -> bool:
        """Whether a person looks at bars and views."""
        return self._console.is_terminal and self._for_people

    @property
    def width(self) -> int:
        """Letters in a line."""
        return self._console.width

    def say(self, text: str) -> None:
        """Print a line for people; scripts have to learn the same from events."""
        if self._for_people:
            self._console.print(printable(text), soft_wrap=True, markup=False)

    def show(self, table: RenderableType) -> None:
        """Print a table for people; it may get wider than the terminal, but no number is cut."""
        if self._for_people:
            wide = Console(width=WIDEST_TABLE)
            least = Measurement.get(wide, wide.options, table).maximum
            Console(width=max(self._console.width, least)).print(table)

    def emit(self, event: str, text: str, /, **values: object) -> None:
        """Print an event for scripts, or its text, if any, for people."""
        if text:
            self.say(text)
        if self._json:
            # ASCII only: a file name need not be valid Unicode.
            print(json.dumps({'event': event, **plain(values)}, allow_nan=False), flush=True)

    def warn(self, text: str) -> None:
        """Print a warning: something to look into, which does not stop the command."""
        if self._json:
            self.emit('warning', '', text=text)
        elif not self._quiet:
            print(f'bpc: {one_line(text)}', file=sys.stderr)

    def files(self, paths: Iterable[Path]) -> None:
        """Print the files that were written."""
        for path in paths:
            self.emit('file', str(path), path=str(path))

    def progress(self, what: str, total: int | None) -> AbstractContextManager[Advance]:
        """Show a bar while the block runs; call the function that it yields after each step.

        The function may also be called with ``completed`` and ``total``, if these become known
        only on the way.
        """
        # Where stdout goes into a file a person may still look at stderr.
        console = self._console if self._console.is_terminal else Console(stderr=True)
        return progress_bar(console, what, total, console.is_terminal and self._for_people)

    @contextmanager
    def view(self) -> Iterator[None]:
        """Show a view below the lines while the block runs; ``draw`` keeps it up to date."""
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
        """Draw the view anew, if there is one and it is not too soon after the last time."""
        if self._live is not None and time.monotonic() - self._drawn > VIEW_PERIOD_S:
            self._drawn = time.monotonic()
            self._live.update(make(), refresh=True)


def show_held_warnings(held: HeldWarnings = WARNINGS) -> None:
    """Print all warnings that were held, as the command's terminal prints warnings."""
    terminal = Terminal.newest or Terminal()
    for text in held.texts:
        terminal.warn(text)
