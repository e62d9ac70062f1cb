"""A straight line with known ink, from which repairs can be worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from perception_builders import profile_of

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.config import RepairConfig, ToleranceConfig
from bpc_perception.core.inspection.verdict import judge
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.core.repair.planner import plan_repair
from bpc_perception.core.targets import WidthTargets

SPACING_M, COUNT, SPEED = 2e-4, 200, 0.01  # 40 mm
WIDTH_M, HEIGHT_M, AREA_M2 = 1e-3, 4e-4, 3e-7
TIP_M = 5e-4  # of the nozzle above the bed
TARGET = WidthTargets.constant(WIDTH_M)


def bead(delivered: float = 1.0, **others: Any) -> ThicknessProfile:
    """A bead of 1 mm all along, of which so much of the command arrives."""
    line = profile_of([WIDTH_M] * COUNT, spacing=SPACING_M, speed=SPEED)
    down = np.array((0.0, 0.0, TIP_M))
    profile = replace(
        line, left_points=line.left_points - down, right_points=line.right_points - down,
        height=np.full(COUNT, HEIGHT_M), height_sigma=np.full(COUNT, 1e-5),
        area=np.full(COUNT, AREA_M2), area_sigma=np.full(COUNT, 5e-9),
        commanded_area=np.full(COUNT, AREA_M2 / delivered))
    return replace(profile, **others)


def with_status(profile: ThicknessProfile, status: Status, *ranges: tuple[int, int],
                ) -> ThicknessProfile:
    """The same, where samples of these ranges have another status, and its numbers."""
    own = np.zeros(len(profile), bool)
    for first, end in ranges:
        own[first:end] = True
    size = 0.0 if status == Status.GAP else np.nan
    names = 'thickness', 'height', 'area'
    unknown = 'sigma', 'left', 'right', 'height_sigma', 'area_sigma'
    return replace(
        profile, status=np.where(own, status, profile.status).astype(np.uint8),
        **{name: np.where(own, size, getattr(profile, name)) for name in names},
        **{name: np.where(own, np.nan, getattr(profile, name)) for name in unknown})


def with_gap(first: int, end: int, profile: ThicknessProfile | None = None) -> ThicknessProfile:
    """A bead without ink on these samples."""
    return with_status(profile or bead(), Status.GAP, (first, end))


def plan(profile: ThicknessProfile, reason: Reason = Reason.ON_TARGET,
         targets: WidthTargets | None = TARGET, ended: bool = True, laying: bool = False,
         tolerance: ToleranceConfig | None = None, **config: Any) -> RepairPlan:
    """Plan the repair of a print."""
    tolerance = tolerance or ToleranceConfig()
    return plan_repair(profile, judge(profile, targets, tolerance, ended, laying), reason, targets,
                       tolerance, RepairConfig(**config))
