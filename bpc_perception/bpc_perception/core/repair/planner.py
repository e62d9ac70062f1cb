"""Plan the repair of a print: what to fill in each layer, and whether the next can be laid."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.config import RepairConfig, ToleranceConfig
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.repair.fills import Filling
from bpc_perception.core.repair.next_layer import layer_states
from bpc_perception.core.repair.plan import Fill, LayerRepair, RepairPlan, Unfilled
from bpc_perception.core.targets import WidthTargets

CONTRADICTIONS = frozenset((Reason.PATH_OFFSET, Reason.EXTRUDER_FAULT))


def plan_repair(profile: ThicknessProfile, verdict: PrintVerdict, reason: Reason,
                targets: WidthTargets | None, tolerance: ToleranceConfig,
                config: RepairConfig) -> RepairPlan:
    """Return what is proposed for a print.

    Args:
        profile: what is known of it.
        verdict: on it.
        reason: of the advice: where inputs contradict each other, nothing is proposed.
        targets: widths wanted along the path; None = none.
        tolerance: how far it may be off.
        config: what is filled, and what hinders the next layer.
    """
    contradiction = reason in CONTRADICTIONS
    stretches = sorted(Filling(profile, verdict.defects, targets, tolerance, config).find(
        contradiction), key=lambda each: each.start)
    laid = profile.layer >= 0
    layers = []
    for number, state in layer_states(profile, tolerance, config, contradiction):
        last = int(np.flatnonzero(profile.layer == number)[-1])
        own = [each for each in stretches if each.layer == number]
        layers.append(LayerRepair(
            number, verdict.ended or bool((profile.layer[last:][laid[last:]] > number).any()),
            state, tuple(each for each in own if isinstance(each, Fill)),
            tuple(each for each in own if isinstance(each, Unfilled))))
    return RepairPlan(profile.stamp_ns, profile.print_id, verdict.laying, tuple(layers))
