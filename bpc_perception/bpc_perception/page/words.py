"""What the page says of advice, lengths and ages."""

from __future__ import annotations

from dataclasses import dataclass
import math

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.display.wording import ALARMS, REASONS

MM = 1e3


@dataclass(frozen=True)
class Advised:
    """Advice as a person reads it: what to do, or else what, why, and in which tone."""

    headline: str
    otherwise: str
    reason: str
    tone: str


def advised(advice: RateAdvice | None, now_ns: int) -> Advised:
    """What is shown of advice at a time."""
    if advice is None:
        return Advised('no advice yet', '', 'it comes with the first measured capture', 'old')
    reason = REASONS[advice.reason]
    if advice.valid and now_ns > advice.valid_until_ns:
        was = advised(advice, advice.valid_until_ns)
        return Advised('expired', f'was: {was.headline}', 'no newer capture was measured', 'old')
    if advice.reason in ALARMS:
        return Advised('alarm', reason, 'change nothing: more rate does not mend it', 'bad')
    if not advice.valid:
        return Advised('change nothing', '', reason, 'old')
    if advice.reason == Reason.ON_TARGET:
        return Advised('keep as it is', '', reason, 'good')
    return Advised(f'flow × {advice.flow_rate_scale:.2f}',
                   f'or else speed × {advice.speed_scale:.2f}', reason, 'act')


def in_mm(length: float, digits: int = 2) -> str:
    """A length [m] as a number of millimetres; a dash where it is not known."""
    return '–' if math.isnan(length) else f'{length * MM:.{digits}f}'


def in_percent(share: float, form: str) -> str:
    """A share as a number of percent; a dash where it is not known."""
    return '–' if math.isnan(share) else format(share, form)[:-1]


def age_in_words(seconds: float) -> str:
    """An age in whole seconds, or minutes from two on."""
    seconds = max(0.0, seconds)
    return f'{seconds:.0f} s' if seconds < 120 else f'{seconds / 60:.0f} min'
