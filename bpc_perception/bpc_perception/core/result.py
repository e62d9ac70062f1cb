"""What came of a capture."""

from __future__ import annotations

from dataclasses import dataclass

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.design.comparison import DesignComparison
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.learning.layer_schedule import LayerSchedule
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.repair.plan import RepairPlan


@dataclass(frozen=True)
class Result:
    """The result of a capture: profile and advice, or the reason why there is none.

    Attributes:
        capture: what was measured.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame [m]; None = not
            known.
        profile: thickness along the path; None = refused.
        advice: what to change; None = refused.
        verdict: whether the print is good; None = refused.
        design: the print beside its design; None = none is told, or refused.
        repair: what is to be filled, and whether the next layer can be laid; None = refused.
        schedule: factors along the layer that is printed, or the next; None = refused.
        refusal: why there is no profile; empty = there is one.
        premature: whether there is none because the print has not begun, or only just: no fault.
        warning: about a result that is right as it is, but may not be what was meant.
    """

    capture: Capture
    T_base_camera: Array | None = None
    profile: ThicknessProfile | None = None
    advice: RateAdvice | None = None
    verdict: PrintVerdict | None = None
    design: DesignComparison | None = None
    repair: RepairPlan | None = None
    schedule: LayerSchedule | None = None
    refusal: str = ''
    premature: bool = False
    warning: str = ''
