"""Words for statuses, advice and numbers, the same wherever they are shown.

Advice is said in three lengths: a line of a table, a sentence, and the headline of the live page.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.display.units import MM_PER_M

MEANINGS = {
    Status.MEASURED: 'a thickness, with its uncertainty',
    Status.GAP: 'ink was commanded, and the bed is seen without any',
    Status.NO_DATA: 'outside the image, no depth, or glare',
    Status.OCCLUDED: 'something stands in front, such as the nozzle',
    Status.JUNCTION: 'the path crosses or touches itself; no single width',
    Status.LOW_CONFIDENCE: 'seen, but not well enough to give a number',
    Status.BARE: 'travel: no ink was commanded, and none is seen',
    Status.OOZE: 'travel: no ink was commanded, and ink is seen',
}
# Why nothing is told, and what to change.
CAUSES = {
    Cause.NONE: ('no cause is on record', ''),
    Cause.OUTSIDE_IMAGE: ('outside the image, or the bead goes on beyond its border',
                          'move the camera, or print nearer to its middle'),
    Cause.NO_DEPTH: ('the cloud has no points there',
                     "change the camera's exposure or distance, or take away what shines"),
    Cause.GLARE: ('glare hides the ink or its edges',
                  'turn or soften the lamp, or tilt the camera'),
    Cause.LOW_CONTRAST: ('ink is hardly told from the bed, or the image is too noisy',
                         'more light, or a bed of another colour'),
    Cause.OVEREXPOSED: ('ink or bed is brighter than the camera can tell', 'expose for less'),
    Cause.OLD_INK: ('ink lay there before', 'clean the bed'),
    Cause.NO_EDGE: ('no edge is seen on one side', 'see that nothing of the same colour is beside '
                    'the bead, and that the whole of it is in the image'),
    Cause.FEW_PIXELS: ('the bead has too few pixels', 'take the camera nearer'),
    Cause.FAINT_EDGES: ('the edges are too faint', 'focus the camera, or more light'),
    Cause.UNSURE_FEET: ('image and cloud do not tell surely where the bead ends',
                        'look from more above, or see that the cloud shows the bead'),
    Cause.INK_ENDS: ('ink begins or ends there within half a pixel', ''),
    Cause.PARTLY_INK: ('neither ink nor bed is where the bead should be',
                       'it is thin, or beside the path: look at the calibration'),
    Cause.RAISED: ('the image shows bed, and the cloud something above it',
                   'a bed of another colour, or see what lies there'),
    Cause.ON_INK: ('image and cloud do not tell the bead from the ink below',
                   'take the camera nearer, or capture more often'),
    Cause.OVER_STROKE: ('travel over a stroke: the ink is of the stroke', ''),
    Cause.INK_UNKNOWN: ('nothing is known of the ink yet', ''),
    Cause.OBSTACLE: ('something stands among the print', 'capture when it is gone'),
    Cause.OFF_PATH: ('ink lies beside the path', 'correct the nozzle offset or the calibration'),
}
REASONS = {
    Reason.ON_TARGET: 'on target',
    Reason.UNDER_EXTRUSION: 'what is laid now comes out too thin',
    Reason.OVER_EXTRUSION: 'what is laid now comes out too thick',
    Reason.LIMITED: 'limited to the largest change allowed',
    Reason.NOT_ENOUGH_DATA: 'not enough data',
    Reason.GAP_DETECTED: 'gap detected',
    Reason.STALE_DATA: 'the newest measurement is too old',
    Reason.NO_TARGET: 'no target thickness: none is set, or its design is not found',
    Reason.CLOG_SUSPECTED: 'suddenly much less ink arrives, a clog perhaps',
    Reason.PATH_OFFSET: 'the filament lies beside the path, look at the calibration',
    Reason.EXTRUDER_FAULT: 'the extruder stopped, or says nothing',
    Reason.VOLUME_DISAGREES: 'as wide as wanted, of more or less ink than wanted',
}
# A higher or lower rate does not mend what is wrong here.
NOTHING_TO_DO = {Reason.ON_TARGET, Reason.VOLUME_DISAGREES}  # of valid advice
ALARMS = {Reason.GAP_DETECTED, Reason.CLOG_SUSPECTED, Reason.PATH_OFFSET, Reason.EXTRUDER_FAULT}
# What is said of VOLUME_DISAGREES where the width is another than wanted, by this share and more.
WIDER, NARROWER = ('wider than wanted, of no more ink than wanted',
                   'narrower than wanted, of no less ink than wanted')
OTHER_WIDTH = 0.02
KNOWN = 0.9  # share of the strokes; what is missing beyond is worth a word
MINUTES_FROM_S = 120  # ages from here on are said in minutes


def label(status: Status) -> str:
    """Return the name of a status in words; pictures show all travel without ooze as BARE."""
    return 'travel' if status == Status.BARE else status.name.replace('_', ' ').lower()


def cause_counts(profile: ThicknessProfile) -> dict[Cause, int]:
    """Return how many samples of strokes each cause left without an answer, the most first."""
    counts = np.bincount(profile.cause[profile.stroke > 0], minlength=len(Cause))
    return {Cause(cause): int(counts[cause]) for cause in np.argsort(-counts, kind='stable')
            if cause and counts[cause]}


def cause_in_words(cause: Cause) -> str:
    """Return why nothing is told, and what to change."""
    why, change = CAUSES[cause]
    return f'{why}: {change}' if change else why


def lost_in_words(profile: ThicknessProfile) -> str:
    """Return how much of the strokes is not known, and why; empty = little."""
    coverage, counts = profile.summary.coverage, cause_counts(profile)
    if not coverage < KNOWN or not counts:
        return ''
    first = next(iter(counts))
    if first == Cause.OFF_PATH:  # a warning of its own says more
        return ''
    return (f'{1 - coverage:.0%} of the strokes are not known; of these '
            f'{counts[first] / np.count_nonzero(profile.stroke > 0) / (1 - coverage):.0%}: '
            f'{cause_in_words(first)}')


def reason_in_words(advice: RateAdvice) -> str:
    """Return why advice is as it is; where volume disagrees, which way."""
    if advice.reason == Reason.VOLUME_DISAGREES:
        wide = advice.expected_thickness / advice.target_thickness
        if abs(wide - 1) > OTHER_WIDTH:
            return WIDER if wide > 1 else NARROWER
    return REASONS[advice.reason]


def spreading_in_words(advice: RateAdvice) -> str:
    """Return how much ink widens after it was laid, to be added to a reason; empty = not."""
    if not advice.spreading > 0:
        return ''
    return f'; laid ink widens by {advice.spreading:.1%} a second'


def advice_in_words(advice: RateAdvice) -> str:
    """Return what to do, and why, as a sentence."""
    reason = reason_in_words(advice)
    if advice.by_volume and advice.reason != Reason.VOLUME_DISAGREES:
        reason += ', by width and volume'
    reason += spreading_in_words(advice)
    if not advice.valid or advice.reason in NOTHING_TO_DO:
        return f'change nothing: {reason}'
    return (f'flow x {advice.flow_rate_scale:.2f}, or else speed x {advice.speed_scale:.2f}: '
            f'{reason}')


def advice_in_a_line(advice: RateAdvice) -> str:
    """Return why, and what to do, short enough for a line of a table."""
    reason, spreads = advice.reason.name.lower().replace('_', ' '), spreading_in_words(advice)
    if not advice.valid:
        return f'change nothing: {reason}{spreads}'
    if advice.reason == Reason.VOLUME_DISAGREES:
        return reason_in_words(advice) + spreads
    if advice.flow_rate_scale == 1.0:
        return reason + spreads
    return (f'{reason}: flow x {advice.flow_rate_scale:.2f} or speed x {advice.speed_scale:.2f}'
            f'{spreads}')


@dataclass(frozen=True)
class AdviceHeadline:
    """Advice in large type.

    Attributes:
        headline: what to do.
        otherwise: what else would do; empty = nothing.
        reason: why.
        tone: 'good', 'act' (change something), 'bad' or 'old' (nothing to go by).
    """

    headline: str
    otherwise: str
    reason: str
    tone: str


def advice_headline(advice: RateAdvice | None, now_ns: int) -> AdviceHeadline:
    """Return the headline of the newest advice, which may have expired, at a time [ns]."""
    if advice is None:
        return AdviceHeadline('no advice yet', '', 'it comes with the first measured capture',
                              'old')
    reason = reason_in_words(advice) + spreading_in_words(advice)
    if advice.valid and now_ns > advice.valid_until_ns:
        expired = advice_headline(advice, advice.valid_until_ns)
        return AdviceHeadline('expired', f'was: {expired.headline}',
                              'no newer capture was measured', 'old')
    if advice.reason in ALARMS:
        return AdviceHeadline('alarm', reason, 'change nothing: more rate does not mend it', 'bad')
    if not advice.valid:
        return AdviceHeadline('change nothing', '', reason, 'old')
    if advice.reason in NOTHING_TO_DO:
        return AdviceHeadline('keep as it is', '', reason, 'good')
    return AdviceHeadline(f'flow × {advice.flow_rate_scale:.2f}',
                          f'or else speed × {advice.speed_scale:.2f}', reason, 'act')


def in_mm(length: float, digits: int = 2) -> str:
    """Return a length [m] as a number of millimetres, without the unit; a dash for NaN."""
    return '–' if math.isnan(length) else f'{length * MM_PER_M:.{digits}f}'


def in_percent(share: float, form: str) -> str:
    """Return a share as a number of percent, without the unit; a dash for NaN.

    ``form`` is a format with a percent sign, such as ``.0%``.
    """
    return '–' if math.isnan(share) else format(share, form)[:-1]


def age_in_words(age_s: float) -> str:
    """Return an age [s] in whole seconds, or in minutes from two minutes on."""
    age_s = max(0.0, age_s)
    return f'{age_s:.0f} s' if age_s < MINUTES_FROM_S else f'{age_s / 60:.0f} min'
