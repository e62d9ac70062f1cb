"""Results in the terminal, a line each as they come."""

from __future__ import annotations

import math

from rich.console import Console

from bpc_perception.core.advice import RateAdvice
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.session import Result

HEADER = ('capture', 'path mm', 'known', 'thickness mm', 'gaps', 'advice')
WIDTHS = (7, 8, 6, 15, 14, 0)


class ResultTable:
    """Prints one line a capture under a header."""

    def __init__(self) -> None:
        self._console = Console(highlight=False)
        self._headed = False

    def add(self, result: Result) -> None:
        """Print what came of a capture."""
        if result.profile is None or result.advice is None:
            self._print(('-', '', '', '', '', f'refused: {result.refusal}'))
            return
        self.add_profile(result.profile, result.advice)

    def add_profile(self, profile: ThicknessProfile, advice: RateAdvice) -> None:
        """Print a profile and the advice that came of it."""
        summary = profile.summary
        length = profile.arc_length[-1] * 1e3 if len(profile) else 0.0
        self._print((
            str(profile.capture), f'{length:.1f}', f'{summary.coverage:.0%}',
            '-' if math.isnan(summary.thickness_mean) else
            f'{summary.thickness_mean * 1e3:.3f} ± {summary.thickness_std * 1e3:.3f}',
            f'{summary.gap_count} ({summary.gap_length * 1e3:.1f} mm)', in_words(advice)))

    def _print(self, cells: tuple[str, ...]) -> None:
        if not self._headed:
            self._headed = True
            self._print(HEADER)
        line = '  '.join(f'{cell:<{width}}' for cell, width in zip(cells, WIDTHS, strict=True))
        self._console.print(line.rstrip(), soft_wrap=True, markup=False)


def in_words(advice: RateAdvice) -> str:
    """What the advice says, for people."""
    reason = advice.reason.name.lower().replace('_', ' ')
    if not advice.valid:
        return f'change nothing: {reason}'
    if advice.flow_rate_scale == 1.0:
        return reason
    return f'{reason}: flow x {advice.flow_rate_scale:.2f} or speed x {advice.speed_scale:.2f}'
