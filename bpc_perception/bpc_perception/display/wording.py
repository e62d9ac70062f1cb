"""Words for statuses and advice, the same in report, overlay, markers, page and terminal."""

from __future__ import annotations

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.profile import Status

MEANINGS = {
    Status.MEASURED: 'a thickness, with its uncertainty',
    Status.GAP: 'the bed is seen and carries no ink',
    Status.NO_DATA: 'outside the image, no depth, or glare',
    Status.OCCLUDED: 'something stands in front, such as the nozzle',
    Status.JUNCTION: 'the path crosses or touches itself; no single width',
    Status.LOW_CONFIDENCE: 'seen, but not well enough to give a number',
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
# Something is wrong that more rate does not mend.
ALARMS = {Reason.GAP_DETECTED, Reason.CLOG_SUSPECTED, Reason.PATH_OFFSET, Reason.EXTRUDER_FAULT}


def advice_in_words(advice: RateAdvice) -> str:
    """What to do, and why."""
    reason = REASONS[advice.reason]
    if not advice.valid or advice.reason == Reason.ON_TARGET:
        return f'change nothing: {reason}'
    return (f'flow x {advice.flow_rate_scale:.2f}, or else speed x {advice.speed_scale:.2f}: '
            f'{reason}')


def label(status: Status) -> str:
    """The name of a status in words."""
    return status.name.replace('_', ' ').lower()
