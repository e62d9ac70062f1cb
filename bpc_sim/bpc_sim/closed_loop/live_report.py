"""How near a finished print came to its target, beside the model of the same print."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.closed_loop.controllers import AdviceFollower, NoFeedback
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.closed_loop.model import ClosedLoopModel


@dataclass(frozen=True)
class Deviations:
    """Deviation of a finished print from its target, root of the mean square [%].

    Attributes:
        measured: as measured; NaN = nothing measured.
        followed: at the same places in the model of the same printer, with advice.
        without: likewise without feedback.
    """

    measured: float
    followed: float
    without: float


def deviations(print_: ClosedLoopJob, profile: ThicknessProfile, actuator: str,
               rate: float) -> Deviations:
    """Return how far off the target a finished print is; ``rate`` is that of captures [Hz]."""
    measured = profile.status == Status.MEASURED
    s = profile.arc_length[measured]
    error = profile.thickness[measured] / print_.situation.targets.at(s) - 1
    situation = replace(print_.situation, period=1 / rate)
    modelled = (ClosedLoopModel(situation, AdviceFollower(actuator), actuator).run(),
                ClosedLoopModel(situation, NoFeedback()).run())
    followed, without = (_percent(np.interp(s, trace.s, trace.error)) for trace in modelled)
    return Deviations(_percent(error), followed, without)


def report(print_: ClosedLoopJob, profile: ThicknessProfile, actuator: str, rate: float) -> str:
    """Say how far off the target a finished print is; ``rate`` is that of captures [Hz]."""
    off = deviations(print_, profile, actuator, rate)
    return (f'Off the target by {off.measured:.1f} % (root of the mean square of what is '
            f'measured); the model without images says {off.followed:.1f} %, and '
            f'{off.without:.1f} % without feedback.')


def _percent(error: Array) -> float:
    """Return the root of the mean square of errors (N,) [%]; NaN where there are none."""
    return float(np.sqrt(np.mean(error**2)) * 100) if len(error) else np.nan
