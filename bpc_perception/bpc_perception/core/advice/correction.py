"""By how much to change flow or speed, within what is allowed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.advice.delivery_filter import Delivery, PRIOR_SIGMA
from bpc_perception.core.advice.observations import ESTABLISHED_SIGMA, Finding
from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig

# Time in which a flow behind a long lag has to be right: the longer of this time and this number
# of periods between captures.
HORIZON_S, HORIZON_PERIODS = 3.0, 1.0
DOUBT_SIGMAS = 0.5  # of the gain, that a first step leaves out
HELD_BAND = 3  # the dead band is narrower by this factor while correcting


@dataclass(frozen=True)
class Situation:
    """What a correction starts from. Amounts are logarithms.

    Attributes:
        area: wanted, as w^2 of the target thickness.
        speed: of the nozzle in the recent past.
        rate: commanded in the recent past.
        volume: commanded per length, in force now.
        lacking: to the area wanted, in the newest path that was measured.
        prior: gain for which the print was set up.
        correcting: whether the advice before asked for a change.
        followed: by how much advice has changed the flow already, where it is not recorded.
        elapsed: since the capture before [s].
        longest_period: between the newest captures [s].
        until_effect: from the capture until what the advice is going to lay [s].
        planned: least and largest factor of a schedule that comes while the advice holds.
    """

    area: float
    speed: float
    rate: float
    volume: float
    lacking: float
    prior: float
    correcting: bool
    followed: float
    elapsed: float
    longest_period: float
    until_effect: float
    planned: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Correction:
    """The factors to apply, one or the other.

    Attributes:
        flow_scale: on the flow.
        speed_scale: on the speed.
        confidence: 0 to 1.
        reason: why.
    """

    flow_scale: float
    speed_scale: float
    confidence: float
    reason: Reason


def correct(now: Situation, finding: Finding, delivery: Delivery,
            config: AdviceConfig) -> Correction:
    """Return the factors that reach the target, as far as they are allowed."""
    wanted = wanted_volumes(now, finding)
    confidence = 1 / (1 + (delivery.gain_sigma / PRIOR_SIGMA)**2)
    band = 2 * np.log1p(config.dead_band) / (HELD_BAND if now.correcting else 1)
    if not np.abs(wanted - now.volume).max() > band:
        return Correction(1.0, 1.0, confidence, Reason.ON_TARGET)
    # Ink that is laid cannot be taken back: more of it at first only as far as it is likely to be
    # missing. What another capture says again is asked for.
    missing = wanted - now.volume
    doubt = 0.0 if now.correcting else DOUBT_SIGMAS * delivery.gain_sigma
    sure = missing - np.clip(missing, 0.0, doubt)
    if not sure.any():
        return Correction(1.0, 1.0, confidence, Reason.ON_TARGET)
    # Both stay in proportion to what the print was set up with, however often advice is followed.
    # Limits hold for advice and schedule together.
    least = min(np.log(config.minimum_scale) - now.planned[0], 0.0)
    most = max(np.log(config.maximum_scale) - now.planned[1], 0.0)
    nominal = now.area - now.prior - now.volume
    believed = np.clip(sure, nominal + least, nominal + most)
    asked = confidence * believed * (1, -1)  # the speed goes against the flow
    step = config.slew_rate * now.elapsed
    followed = now.followed * np.array((1, -1))
    # The flow goes up, and the speed down, no further than by what the bead lacks, unless it is
    # well known that the bead is about to become thinner.
    lacking = max(now.lacking, 0.0) if delivery.gain_sigma > ESTABLISHED_SIGMA else np.inf
    lowest, highest = np.array((-step, -min(step, lacking))), np.array((min(step, lacking), step))
    changes = np.clip(asked, np.clip(least - followed, lowest, 0.0),
                      np.clip(most - followed, 0.0, highest))
    if (changes != asked).any() or (believed != sure).any():
        reason = Reason.LIMITED
    elif wanted[0] > now.volume:
        reason = Reason.UNDER_EXTRUSION
    else:
        reason = Reason.OVER_EXTRUSION
    flow_scale, speed_scale = np.exp(changes).tolist()
    return Correction(flow_scale, speed_scale, confidence, reason)


def wanted_volumes(now: Situation, finding: Finding) -> Array:
    """Return the logarithms (2,) of the volume per length that reaches the target.

    The first is reached by the flow at this speed, the second by the speed at this flow, which a
    lag does not delay.
    """
    horizon = max(HORIZON_S, HORIZON_PERIODS * now.longest_period)
    by_flow = finding.models.rate_for(now.area + now.speed, finding.flow, horizon) - now.speed
    by_speed = now.area + now.rate - finding.models.after(
        float(np.exp(now.rate)), finding.flow, now.until_effect)
    return np.array((by_flow, by_speed))
