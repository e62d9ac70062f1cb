"""The live view in the terminal: the newest profile in a line, its numbers, the advice."""

from __future__ import annotations

import math

import numpy as np
from rich.console import Group
from rich.text import Text

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.display.legend import deviation_colours, STATUS_COLOURS
from bpc_perception.display.wording import advice_in_a_line, label

BLOCKS = '▁▂▃▄▅▆▇█'
MM = 1e3  # [mm/m]
# What stands for a stretch of which nothing is measured.
SIGNS = {Status.GAP: '_', Status.NO_DATA: '·', Status.OCCLUDED: 'o', Status.JUNCTION: 'x',
         Status.LOW_CONFIDENCE: '?'}


def view(profile: ThicknessProfile, advice: RateAdvice, width: int, age: float) -> Group:
    """Three lines about a capture; ``age`` is how long ago it came [s]."""
    found = profile.summary
    mean = ('nothing measured' if math.isnan(found.thickness_mean) else
            f'{found.thickness_mean * MM:.3f} ± {found.thickness_std * MM:.3f} mm')
    wanted = (f', target {advice.target_thickness * MM:.3f} mm' if advice.target_thickness > 0
              else '')
    length = profile.arc_length[-1] * MM if len(profile) else 0.0
    missing = ', '.join(f'{SIGNS[status]} {label(status)}' for status in SIGNS
                        if (profile.status == status).any())
    return Group(
        profile_line(profile, advice, width),
        Text(f'0 to {length:.1f} mm: {mean}{wanted}, {found.coverage:.0%} known'
             + (f';  {missing}' if missing else '')),
        Text(f'{advice_in_a_line(advice)};  capture {profile.capture}, {age:.0f} s ago'))


def profile_line(profile: ThicknessProfile, advice: RateAdvice, width: int) -> Text:
    """Thickness along the path in so many letters: blocks, of half height where it is as wanted.

    Coloured by deviation from the target, or from the median without one; where most samples of
    a stretch are not measured there is the sign of their most frequent status.
    """
    line = Text()
    target = advice.target_thickness
    usual = target if target > 0 else profile.summary.thickness_median
    for part in np.array_split(np.arange(len(profile)), max(1, min(width, len(profile)))):
        if not len(part):
            continue
        status = Status(int(np.bincount(profile.status[part]).argmax()))
        if status != Status.MEASURED:
            line.append(SIGNS[status], STATUS_COLOURS[status])
            continue
        off = np.nanmedian(profile.thickness[part]) / usual
        height = int(np.clip(np.rint(off * len(BLOCKS) / 2), 1, len(BLOCKS)))
        red, green, blue = deviation_colours(np.array([off - 1]))[0].tolist()
        line.append(BLOCKS[height - 1], f'rgb({red},{green},{blue})')
    return line
