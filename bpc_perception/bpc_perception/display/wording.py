"""Words for statuses, advice and numbers, the same wherever they are shown.

Advice is said in three lengths: a line of a table, a sentence, and the headline of the live page.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.profile import Status
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
REASONS = {
    Reason.ON_TARGET: 'on target',
    Reason.UNDER_EXTRUSION: 'what is laid now comes out too thin',
    Reason.OVER_EXTRUSION: 'what is laid now comes out too thick',
    Reason.LIMITED: 'limited to the largest change allowed',
    Reason.NOT_ENOUGH_DATA: 'not enough data',
    Reason.GAP_DETECTED: 'gap detected',
    Reason.STALE_DATA: 'the newest measurement is too old',
    Reason.NO_TARGET: 'no target thickness set',
    Reason.CLOG_SUSPECTED: 'suddenly much less ink arrives, a clog perhaps',
    Reason.PATH_OFFSET: 'the filament lies beside the path, look at the calibration',
    Reason.EXTRUDER_FAULT: 'the extruder stopped, or says nothing',
}
# A higher or lower rate does not mend what is wrong here.
ALARMS = {Reason.GAP_DETECTED, Reason.CLOG_SUSPECTED, Reason.PATH_OFFSET, Reason.EXTRUDER_FAULT}
MINUTES_FROM_S = 120  # ages from here on are said in minutes


def label(status: Status) -> str:
    """Return the name of a status in words; pictures show all travel without ooze as BARE."""
    return 'travel' if status == Status.BARE else status.name.replace('_', ' ').lower()


def advice_in_words(advice: RateAdvice) -> str:
    """Return what to do, and why, as a sentence."""
    reason = REASONS[advice.reason] + (', by width and volume' if advice.by_volume else '')
    if not advice.valid or advice.reason == Reason.ON_TARGET:
        return f'change nothing: {reason}'
    return (f'flow x {advice.flow_rate_scale:.2f}, or else speed x {advice.speed_scale:.2f}: '
            f'{reason}')


def advice_in_a_line(advice: RateAdvice) -> str:
    """Return why, and what to do, short enough for a line of a table."""
    reason = advice.reason.name.lower().replace('_', ' ')
    if not advice.valid:
        return f'change nothing: {reason}'
    if advice.flow_rate_scale == 1.0:
        return reason
    return f'{reason}: flow x {advice.flow_rate_scale:.2f} or speed x {advice.speed_scale:.2f}'


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
    reason = REASONS[advice.reason]
    if advice.valid and now_ns > advice.valid_until_ns:
        expired = advice_headline(advice, advice.valid_until_ns)
        return AdviceHeadline('expired', f'was: {expired.headline}',
                              'no newer capture was measured', 'old')
    if advice.reason in ALARMS:
        return AdviceHeadline('alarm', reason, 'change nothing: more rate does not mend it', 'bad')
    if not advice.valid:
        return AdviceHeadline('change nothing', '', reason, 'old')
    if advice.reason == Reason.ON_TARGET:
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
