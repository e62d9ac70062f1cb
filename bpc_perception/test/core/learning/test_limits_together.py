"""Limits hold over advice and schedule together, whatever is measured."""

from __future__ import annotations

from dataclasses import replace

from layer_builders import FLOW, SPACING, TARGET
import numpy as np
from perception_builders import path_through, profile_of, SECOND, START_NS

from bpc_perception.core.advice.advisor import Advisor
from bpc_perception.core.advice.planned import Planned
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.profile import Status

SEQUENCES, CAPTURES = 700, 3
STEP, COUNT, SPEED = 60, 240, 0.01
CONFIG = AdviceConfig(target_thickness=TARGET, slew_rate=100, acquisition_time=0)


def test_no_sequence_of_inputs_drives_the_product_past_the_limits() -> None:
    rng = np.random.default_rng(25)
    points = np.column_stack((SPACING * np.arange(COUNT), np.zeros((COUNT, 2))))
    whole, least, most = path_through(points, finished=False), np.inf, 0.0
    for _ in range(SEQUENCES):
        advisor, factor = Advisor(), 1.0
        planned = np.exp(np.interp(np.arange(COUNT), np.linspace(0, COUNT, 6),
                                   rng.uniform(*np.log((0.5, 2.0)), 6)))
        planned = np.clip(planned, CONFIG.minimum_scale, CONFIG.maximum_scale)
        flow = np.zeros(0)
        for capture in range(CAPTURES):
            count = STEP * (capture + 1)
            flow = np.append(flow, FLOW * factor * planned[count - STEP:count])
            path = replace(whole.until(START_NS + round(
                (whole.time[count - 1] + 1e-6) * SECOND)), flow_rate=flow)
            width = TARGET * np.exp(rng.normal(0, 0.7)) * np.exp(rng.normal(0, 0.1, count))
            status = np.where(rng.random(count) < rng.choice((0, 0.3)), Status.NO_DATA,
                              Status.MEASURED)
            profile = replace(profile_of(width.tolist(), status.tolist(), spacing=SPACING),
                              stamp_ns=START_NS + round((path.time[-1] + 0.01) * SECOND))
            coming = planned[count - 1:]
            advice = advisor.advise(profile, replace(path, complete_until=1e3), CONFIG, planned=(
                Planned(planned[:count], 0.0, (coming.min(), coming.max()), 0.1)))
            raised = factor * advice.flow_rate_scale
            # Where a schedule begins anew advice cannot undo it: it must not make it worse.
            if advice.flow_rate_scale > 1:
                assert raised * coming.max() <= CONFIG.maximum_scale * 1.001
            if advice.flow_rate_scale < 1:
                assert raised * coming.min() >= CONFIG.minimum_scale / 1.001
            factor = raised
            least, most = min(least, advice.flow_rate_scale), max(most, advice.flow_rate_scale)
    assert least < 0.8 < 1.2 < most  # advice did act
