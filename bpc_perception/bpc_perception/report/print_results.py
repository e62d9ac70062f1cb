"""The results of all prints of a recording: each in a folder of its own if there are several."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import json
import os
from pathlib import Path
from typing import Any

from bpc_perception.core.result import Result
from bpc_perception.display.plain_json import plain
from bpc_perception.report.outputs import write_outputs
from bpc_perception.report.pages import prints_page
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance
from bpc_perception.report.result_folder import read_summary, SUMMARY


@dataclass(frozen=True)
class Wanted:
    """What of a recording is to be reported.

    Attributes:
        capture: number of the capture of each print; None = the last that was measured.
        every_capture: whether each capture gets a folder of its own as well.
        print_number: number of the only print, from 1; None = all.
        figures: whether there are to be figures for papers.
        formats: of other programs that the profile is to be written for as well.
    """

    capture: int | None = None
    every_capture: bool = False
    print_number: int | None = None
    figures: bool = False
    formats: tuple[str, ...] = ()


class PrintResults:
    """Takes the results of captures in order, and writes those of a print when it has ended.

    Attributes:
        number: of the newest print, from 1; 0 = none was measured.
        reported: the results that are reported, one a print.
    """

    def __init__(self, folder: Path, provenance: Provenance, wanted: Wanted,
                 expected: int | None = None,
                 warnings: Callable[[], Iterable[str]] = tuple) -> None:
        """Take results from now on.

        Args:
            folder: an empty one to write into.
            provenance: where the results come from.
            wanted: what is to be reported.
            expected: how many captures there will be, if that is known.
            warnings: returns what else a reader has to know by now.
        """
        self._folder = folder
        self._provenance = provenance
        self._wanted = wanted
        self._expected = expected
        self._warnings = warnings
        self._log = self._new_log()
        self._print_id = ''
        self._written: list[dict[str, Any]] = []
        self._missing: list[int] = []  # prints without the capture that is wanted
        self.number = 0
        self.reported: list[Result] = []

    def add(self, result: Result) -> None:
        """Take what came of a capture."""
        profile = result.profile
        if profile is not None and profile.print_id != self._print_id:
            if self.number:
                self._write()
            self._print_id, self.number = profile.print_id, self.number + 1
        self._log.add(result)
        if self._wanted.every_capture and profile is not None and self._is_wanted():
            write_outputs(self._place() / f'capture_{profile.capture:04d}',
                          PrintLog.of([result]), self._provenance, self._wanted.figures,
                          self._wanted.formats)

    def finish(self) -> list[Path]:
        """Write what is left; return the files of the reports, relative to the folder.

        Raises ValueError if there is nothing to report, or not what is wanted.
        """
        bag = self._provenance.bag
        if not self.number:
            reasons = '; '.join(sorted(self._log.refusals)) or 'no capture'
            raise ValueError(f'{bag}: expected a capture that can be measured, found: {reasons}')
        self._write()
        if self._missing:
            raise ValueError(f'{bag}: expected capture {self._wanted.capture}, found '
                             f'{", ".join(map(str, self._missing))}'
                             '; name one of these with --capture')
        if not self._written:
            raise ValueError(f'{bag}: expected print {self._wanted.print_number}, '
                             f'found {self.number}; name one of these with --print')
        if len(self._written) == 1:
            place = self._folder / self._written[0]['folder']
            for path in place.iterdir():
                os.replace(path, self._folder / path.name)
            place.rmdir()
        else:
            self._write_overview()
        return sorted(path.relative_to(self._folder) for path in self._folder.rglob('*')
                      if path.is_file() and not path.parent.name.startswith('capture_'))

    def _new_log(self) -> PrintLog:
        return PrintLog(self._wanted.capture, self._expected)

    def _is_wanted(self) -> bool:
        return self._wanted.print_number in (None, self.number)

    def _place(self) -> Path:
        return self._folder / f'print_{self.number}'

    def _write(self) -> None:
        """Write the print that has ended."""
        log, self._log = self._log, self._new_log()
        if not self._is_wanted():
            return
        if log.reported is None:
            self._missing += log.numbers
            return
        log.warnings = list(self._warnings())
        if self._wanted.capture is None:
            log.end()
        write_outputs(self._place(), log, self._provenance, self._wanted.figures,
                      self._wanted.formats)
        summary = read_summary(self._place())
        self._written.append({'print': self.number, 'folder': self._place().name, **summary})
        self.reported.append(log.reported)

    def _write_overview(self) -> None:
        """Write a summary and a page that list all prints."""
        first = self._written[0]
        made_from = ('bag', 'hand_eye', 'settings', 'versions', 'fingerprint')
        prints = [{key: value for key, value in each.items() if key not in made_from}
                  for each in self._written]
        for each in prints:
            each['captures'] = len(each['captures'])
        overview = plain({'prints': prints, 'warnings': list(self._warnings()),
                          **{key: first[key] for key in made_from}})
        (self._folder / 'report.html').write_text(prints_page.render(overview), 'utf-8')
        (self._folder / SUMMARY).write_text(
            json.dumps(overview, indent=2, allow_nan=False) + '\n', 'utf-8')
