"""What is kept of a print while its captures are measured: bounded, however long it takes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from bpc_perception.core.design.comparison import compare_with_design
from bpc_perception.core.result import Result
from bpc_perception.report.entries import result_entry
from bpc_perception.report.thumbnails import Thumbnails


@dataclass
class PrintLog:
    """An entry and a small picture of each capture, and one result in full.

    A result holds its capture, which has 35 MB at full size.

    Attributes:
        wanted: number of the capture that is to be reported; None = the last that was measured.
        expected: how many captures there will be, as far as that is known.
        entries: what summary.json says of each capture, refused ones included.
        reported: the result that is reported; None as long as there is none.
        place: its position among the entries.
        thumbnails: overlays of the captures.
        warnings: what else a reader has to know about the measurement.
    """

    wanted: int | None = None
    expected: int | None = None
    entries: list[dict[str, Any]] = field(default_factory=list)
    reported: Result | None = None
    place: int = -1
    thumbnails: Thumbnails = field(init=False)
    warnings: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.thumbnails = Thumbnails(self.expected)

    @classmethod
    def of(cls, results: Iterable[Result]) -> PrintLog:
        """Return the log of these results."""
        log = cls()
        for result in results:
            log.add(result)
        return log

    def go_on(self, entries: list[dict[str, Any]]) -> None:
        """Go on with a log that was left off after these entries, which have no pictures."""
        self.entries = entries
        self.thumbnails.skip(len(entries))

    def add(self, result: Result) -> None:
        """Take note of what came of a capture."""
        if result.profile is not None and self.wanted in (None, result.profile.capture):
            self.reported, self.place = result, len(self.entries)
        self.entries.append(result_entry(result))
        self.thumbnails.add(result)

    def end(self) -> None:
        """Take note that nothing more of the print comes."""
        result = self.reported
        if result is None or result.profile is None or result.verdict is None:
            return
        design = result.design
        if design is not None and not (result.verdict.ended or result.verdict.laying):
            design = compare_with_design(result.profile, design.wanted)
        repair = result.repair
        self.reported = replace(
            result, design=design, repair=repair.at_its_end() if repair is not None else None,
            verdict=result.verdict.at_its_end(design.findings if design is not None else None))

    @property
    def refusals(self) -> list[str]:
        """The distinct reasons why captures were refused, in order."""
        return list(dict.fromkeys(
            str(entry['refusal']) for entry in self.entries if 'refusal' in entry))

    @property
    def numbers(self) -> list[int]:
        """The numbers of the captures that were measured."""
        return [entry['capture'] for entry in self.entries if isinstance(entry['capture'], int)]
