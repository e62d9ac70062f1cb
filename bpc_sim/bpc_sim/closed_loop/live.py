"""What the nodes need to know for a print that goes wrong, and how it went."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.closed_loop.loop import ClosedLoop
from bpc_sim.closed_loop.rate_control import AdviceFollower, NoFeedback
from bpc_sim.printer.recording import hand_eye, parameters

MM = 1e-3


def loop_hand_eye(print_: ClosedLoopJob) -> dict[str, object]:
    """The calibration of the job's camera, wrong where that is what goes wrong."""
    calibration = hand_eye(print_.job)
    transform = calibration['transform']
    assert isinstance(transform, dict)
    # Across the strands of the meander, which run along the x axis of the bed.
    wrong = print_.job.T_base_surface[:3, 1] * print_.situation.offset
    for axis, value in zip('xyz', wrong.tolist(), strict=True):
        transform['translation'][axis] += value
    return calibration


def loop_parameters(print_: ClosedLoopJob, table: Path) -> dict[str, object]:
    """The parameters of the nodes; targets along the path are written into ``table``."""
    targets = print_.situation.targets
    rows = [f'{s / MM},{width / MM}'
            for s, width in zip(targets.arc_length, targets.thickness, strict=True)]
    table.write_text('\n'.join(('arc_length_mm,thickness_mm', *rows)) + '\n')
    values = parameters(print_.job, float(targets.thickness[0]))
    thickness = values['/**/thickness']
    assert isinstance(thickness, dict)
    thickness['ros__parameters']['advice.target_file'] = str(table)
    return values


def measured_error(print_: ClosedLoopJob, profile: ThicknessProfile) -> tuple[Array, Array]:
    """Arc lengths (N,) of the measured samples [m], and their deviation from the target."""
    measured = profile.status == Status.MEASURED
    s = profile.arc_length[measured]
    return s, profile.thickness[measured] / print_.situation.targets.at(s) - 1


def deviations(print_: ClosedLoopJob, profile: ThicknessProfile, actuator: str,
               rate: float) -> tuple[float, float, float]:
    """How far off the target a finished print is, root of the mean square [%].

    As measured; and at the same places in the fast model of the same printer, with advice and
    without feedback. ``rate`` is that of the captures [Hz].
    """
    s, error = measured_error(print_, profile)
    situation = replace(print_.situation, period=1 / rate)
    modelled = (ClosedLoop(situation, AdviceFollower(actuator), actuator).run(),
                ClosedLoop(situation, NoFeedback()).run())
    followed, without = (percent(np.interp(s, trace.s, trace.error)) for trace in modelled)
    return percent(error), followed, without


def report(print_: ClosedLoopJob, profile: ThicknessProfile, actuator: str, rate: float) -> str:
    """How far off the target a finished print is, in words."""
    measured, followed, without = deviations(print_, profile, actuator, rate)
    return (f'Off the target by {measured:.1f} % (root of the mean square of what is measured); '
            f'the model without images says {followed:.1f} %, and {without:.1f} % without '
            'feedback.')


def percent(error: Array) -> float:
    """Root of the mean square [%]; NaN = nothing measured."""
    return float(np.sqrt(np.mean(error**2)) * 100) if len(error) else np.nan
