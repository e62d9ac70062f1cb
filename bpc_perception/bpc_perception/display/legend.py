"""Colours and signs of statuses, sides and deviations, the same wherever results are shown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile

# The palette of Okabe and Ito, which colour-blind people can tell apart, and a grey.
STATUS_COLOURS = {
    Status.MEASURED: '#0072B2',
    Status.GAP: '#D55E00',
    Status.NO_DATA: '#8C8C8C',
    Status.OCCLUDED: '#000000',
    Status.JUNCTION: '#CC79A7',
    Status.LOW_CONFIDENCE: '#E69F00',
    Status.BARE: '#C8C8C8',
    Status.OOZE: '#8E5BD0',
}
# Where there is room for a letter only: what stands for a stretch in which nothing is measured.
STATUS_SIGNS = {
    Status.GAP: '_',
    Status.NO_DATA: '·',
    Status.OCCLUDED: 'o',
    Status.JUNCTION: 'x',
    Status.LOW_CONFIDENCE: '?',
    Status.BARE: ' ',
    Status.OOZE: '~',
}
LEFT_COLOUR, RIGHT_COLOUR = '#56B4E9', '#009E73'
WINDOW_COLOUR = '#F0E442'
HEIGHT_COLOUR = '#009E73'
TARGET_COLOUR = '#333333'
# From the same palette, for prints that are compared.
PRINT_COLOURS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#E69F00', '#56B4E9', '#000000')
# The scale of deviations.
TOO_THIN_COLOUR, ON_TARGET_COLOUR, TOO_THICK_COLOUR = '#0072B2', '#EEEEEE', '#D55E00'
FULL_COLOUR_DEVIATION = 0.2  # share of the target at which the scale ends


def as_shown(profile: ThicknessProfile) -> ThicknessProfile:
    """Return a profile to draw, in which all travel without ooze looks alike.

    Nothing is wrong with a print where the nozzle travels over ink, or out of the picture.
    """
    travel = (profile.stroke == 0) & (profile.status != Status.OOZE)
    return replace(profile, status=np.where(travel, Status.BARE, profile.status).astype(np.uint8))


def rgb(colour: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of a colour such as ``#0072B2``."""
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue


def deviation_colours(deviation: Array) -> NDArray[np.uint8]:
    """Return the colours of deviations from the target.

    Args:
        deviation: (N,) thickness relative to its target, less 1; NaN = not known.

    Returns:
        RGB (N, 3); grey where the deviation is not known.
    """
    known = np.clip(np.nan_to_num(deviation) / FULL_COLOUR_DEVIATION, -1, 1)[:, None]
    thin, right, thick = (np.array(rgb(colour), float) for colour in (
        TOO_THIN_COLOUR, ON_TARGET_COLOUR, TOO_THICK_COLOUR))
    colours = right + np.abs(known) * (np.where(known < 0, thin, thick) - right)
    colours[np.isnan(deviation)] = rgb(STATUS_COLOURS[Status.NO_DATA])
    return np.rint(colours).astype(np.uint8)
