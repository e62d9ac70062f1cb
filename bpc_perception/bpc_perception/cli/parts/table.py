"""Results as they come, a line each."""

from __future__ import annotations

import math

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.session import Result
from bpc_perception.display.wording import advice_in_a_line
from bpc_perception.report.entries import advice_entry, profile_entry, result_entry

HEADER = ('capture', 'path mm', 'known', 'thickness mm', 'gaps', 'advice')
WIDTHS = (7, 8, 6, 15, 14, 0)


class ResultTable:
    """One line a capture under a header, or one JSON object."""

    def __init__(self, terminal: Terminal) -> None:
        self._terminal = terminal
        self._headed = False

    def add(self, result: Result) -> None:
        """Tell what came of a capture."""
        if result.profile is None or result.advice is None:
            self._tell(('-', '', '', '', '', f'refused: {result.refusal}'),
                       **result_entry(result))
            return
        self.add_profile(result.profile, result.advice)

    def add_profile(self, profile: ThicknessProfile, advice: RateAdvice) -> None:
        """Tell a profile and the advice that came of it."""
        summary = profile.summary
        length = profile.arc_length[-1] * 1e3 if len(profile) else 0.0
        self._tell((
            str(profile.capture), f'{length:.1f}', f'{summary.coverage:.0%}',
            '-' if math.isnan(summary.thickness_mean) else
            f'{summary.thickness_mean * 1e3:.3f} ± {summary.thickness_std * 1e3:.3f}',
            f'{summary.gap_count} ({summary.gap_length * 1e3:.1f} mm)', advice_in_a_line(advice)),
            **profile_entry(profile), advice=advice_entry(advice))

    def _tell(self, cells: tuple[str, ...], **values: object) -> None:
        if not self._headed:
            self._headed = True
            self._terminal.say(_line(HEADER))
        self._terminal.tell('capture', _line(cells), **values)


def _line(cells: tuple[str, ...]) -> str:
    return '  '.join(
        f'{cell:<{width}}' for cell, width in zip(cells, WIDTHS, strict=True)).rstrip()
