"""Colours and words for statuses and advice, the same in report, overlay, markers and terminal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
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
# Of the same palette, for prints that are compared.
PRINTS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#E69F00', '#56B4E9', '#000000')
# Too thin, on target, too thick; at and beyond this share off the target the colour is full.
THIN, RIGHT_ON, THICK, FULL = '#0072B2', '#EEEEEE', '#D55E00', 0.2


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
