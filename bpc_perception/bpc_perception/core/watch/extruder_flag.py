"""An extruder whose plunger and ``extruding`` contradict each other."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Flags
from bpc_perception.core.path.deposition_path import DepositionPath

LEAST_M = 5e-3  # of path; less is a state that comes late, or a push before a stroke
LEAST_SHARE = 0.2  # of the path on which ink is said to be pushed out


def extruder_contradiction(path: DepositionPath) -> str:
    """Return how plunger and ``extruding`` contradict each other; empty = they do not.

    Where one of both is wrong nobody knows where strokes are, or how much ink was commanded.
    """
    length = np.diff(path.arc_length, prepend=path.arc_length[:1])
    known = path.extruder_known & np.isfinite(path.plunger_velocity)
    moving = known & (path.plunger_velocity > 0)
    still = known & (path.plunger_velocity <= 0) & ~(path.flow_rate > 0)
    said = float(length[path.extruding & known].sum())

    def common(flags: Flags) -> float:
        """Return the length of a contradiction (N,); 0 = too short to be one [m]."""
        found = float(length[flags].sum())
        return found if found > max(LEAST_M, LEAST_SHARE * said) else 0.0

    unsaid, idle = common(moving & ~path.extruding), common(still & path.extruding)
    if unsaid:
        return ('extrusion_state: expected the plunger not to push where extruding is false, '
                f'found it moving along {1e3 * unsaid:.0f} mm of the path; set extruding where '
                'ink is pushed out, or look at the sign of plunger_velocity')
    if idle:
        return ('extrusion_state: expected the plunger to push where extruding is true, found it '
                f'standing or going back along {1e3 * idle:.0f} mm of the path; is it jammed, is '
                'the sign of plunger_velocity right, or does another source say extruding?')
    return ''
