"""What width and volume agree on.

A bead that is wide and low holds no more ink than a narrow, high one: its width alone tells
spreading from too much ink no more than a squashed first layer from a round second one. Where the
area of the cross-section is known, and the commanded flow is a volume that can be compared with
it, both have to ask for a change. Of ink that is seen to spread, the area alone tells how much
there is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.advice.correction import Correction
from bpc_perception.core.advice.rate_advice import Reason


def agreed(by_width: Correction, by_area: Correction, spreads: bool = False) -> Correction:
    """Return the smaller of two corrections, or none where one goes up and the other down.

    Of ink that spreads, that by its area is returned.
    """
    if spreads:
        by_width = replace(by_area, reason=by_width.reason)
    flow = _smaller(by_width.flow_scale, by_area.flow_scale)
    speed = _smaller(by_width.speed_scale, by_area.speed_scale)
    confidence = min(by_width.confidence, by_area.confidence)
    if flow == speed == 1.0:
        same = by_width.reason == by_area.reason == Reason.ON_TARGET
        return Correction(1.0, 1.0, confidence,
                          Reason.ON_TARGET if same else Reason.VOLUME_DISAGREES)
    kept = by_area if flow == by_area.flow_scale else by_width
    return Correction(flow, speed, confidence, kept.reason)


def _smaller(one: float, other: float) -> float:
    """Return the factor nearer to 1; 1 if they lie on different sides of it."""
    first, second = np.log((one, other))
    if first * second <= 0:
        return 1.0
    return one if abs(first) < abs(second) else other
