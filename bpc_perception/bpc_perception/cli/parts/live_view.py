"""The live view in the terminal: the newest profile in a line, its numbers, the advice."""

from __future__ import annotations

import math

import numpy as np
from rich.console import Group
from rich.text import Text

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.inspection.verdict import PrintVerdict, Verdict
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.display.legend import (
    as_shown,
    deviation_colours,
    STATUS_COLOURS,
    STATUS_SIGNS,
)
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.verdict_words import verdict_in_words
from bpc_perception.display.wording import advice_in_a_line, label

VERDICT_COLOURS = {Verdict.PASS: 'green', Verdict.FAIL: 'bold red', Verdict.NOT_ENOUGH_SEEN: ''}
BLOCKS = '▁▂▃▄▅▆▇█'


def view(profile: ThicknessProfile, advice: RateAdvice, verdict: PrintVerdict, width: int,
         age: float) -> Group:
    """Return lines of ``width`` letters about a capture that came ``age`` [s] ago."""
    return Group(
        profile_line(profile, advice, width),
        Text(_numbers(profile, advice)),
        Text(f'print {verdict_in_words(verdict)}',
             VERDICT_COLOURS[verdict.verdict]),
        Text(f'{advice_in_a_line(advice)};  capture {profile.capture}, {age:.0f} s ago'))


def _numbers(profile: ThicknessProfile, advice: RateAdvice) -> str:
    """Return the numbers of a profile in words, with the statuses that it has."""
    summary = profile.summary
    mean = ('nothing measured' if math.isnan(summary.thickness_mean) else
            f'{summary.thickness_mean * MM_PER_M:.3f} ± '
            f'{summary.thickness_std * MM_PER_M:.3f} mm')
    target = (f', target {advice.target_thickness * MM_PER_M:.3f} mm'
              if advice.target_thickness > 0 else '')
    length_mm = profile.arc_length[-1] * MM_PER_M if len(profile) else 0.0
    shown = as_shown(profile).status
    statuses = ', '.join(f'{STATUS_SIGNS[status]} {label(status)}' for status in STATUS_SIGNS
                         if (shown == status).any())
    return (f'0 to {length_mm:.1f} mm: {mean}{target}, {summary.coverage:.0%} known'
            + (f';  {statuses}' if statuses else ''))


def profile_line(profile: ThicknessProfile, advice: RateAdvice, width: int) -> Text:
    """Return thickness along the path in ``width`` letters: blocks, of half height on target.

    Blocks are coloured by the deviation from the target, or from the median without one. Where
    most samples of a stretch are not measured there is the sign of their most frequent status.
    """
    line = Text()
    target = advice.target_thickness
    reference = target if target > 0 else profile.summary.thickness_median
    profile = as_shown(profile)
    for part in np.array_split(np.arange(len(profile)), max(1, min(width, len(profile)))):
        if not len(part):
            continue
        status = Status(int(np.bincount(profile.status[part]).argmax()))
        if status != Status.MEASURED:
            line.append(STATUS_SIGNS[status], STATUS_COLOURS[status])
            continue
        ratio = np.nanmedian(profile.thickness[part]) / reference
        height = int(np.clip(np.rint(ratio * len(BLOCKS) / 2), 1, len(BLOCKS)))
        red, green, blue = deviation_colours(np.array([ratio - 1]))[0].tolist()
        line.append(BLOCKS[height - 1], f'rgb({red},{green},{blue})')
    return line
