"""Colours and words for statuses and advice, the same in report, overlay, markers and terminal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.advice import RateAdvice, Reason
from bpc_perception.core.geometry import Array
from bpc_perception.core.profile import Status

# The palette of Okabe and Ito, which colour-blind eyes can tell apart, and a grey.
COLOURS = {
    Status.MEASURED: '#0072B2',
    Status.GAP: '#D55E00',
    Status.NO_DATA: '#8C8C8C',
    Status.OCCLUDED: '#000000',
    Status.JUNCTION: '#CC79A7',
    Status.LOW_CONFIDENCE: '#E69F00',
}
LEFT, RIGHT, WINDOW, TARGET = '#56B4E9', '#009E73', '#F0E442', '#333333'
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
# Of the same palette, for prints that are compared.
PRINTS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#E69F00', '#56B4E9', '#000000')
# Something is wrong that more rate does not mend.
ALARMS = {Reason.GAP_DETECTED, Reason.CLOG_SUSPECTED, Reason.PATH_OFFSET, Reason.EXTRUDER_FAULT}
# Too thin, on target, too thick; at and beyond this share off the target the colour is full.
THIN, RIGHT_ON, THICK, FULL = '#0072B2', '#EEEEEE', '#D55E00', 0.2


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


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue, 0..255, of a colour such as ``#0072B2``."""
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue


def deviation_colours(deviation: Array) -> NDArray[np.uint8]:
    """RGB (N, 3) for how far thickness (N,) is off its target, as a share of it; NaN is grey."""
    known = np.clip(np.nan_to_num(deviation) / FULL, -1, 1)[:, None]
    thin, right, thick = (np.array(rgb(colour), float) for colour in (THIN, RIGHT_ON, THICK))
    colours = right + np.abs(known) * (np.where(known < 0, thin, thick) - right)
    colours[np.isnan(deviation)] = rgb(COLOURS[Status.NO_DATA])
    return np.rint(colours).astype(np.uint8)
