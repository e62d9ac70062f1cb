"""The path of a simulated print, as a recorder would give it."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tracker import PrintTracker
from bpc_sim.printer.print_job import PrintJob

LEAD_S = 0.02  # by which a print that is started by hand is early


def recorded_path(job: PrintJob, start_ns: int, known: bool = True,
                  auto: bool = True) -> DepositionPath:
    """Return the path of a job from 100 poses and 50 extruder states a second.

    Args:
        job: the print.
        start_ns: stamp of the job's start [ns].
        known: whether the extruder says anything.
        auto: whether the print starts when ink is pushed out.
    """
    tracker = PrintTracker(PathConfig(auto=auto))
    events = [(t, 0) for t in np.arange(0, job.duration, 0.01)]
    events += [(t, 1) for t in np.arange(0.003, job.duration, 0.02) if known]
    if not auto:
        tracker.start(start_ns + round((job.dwell_before - LEAD_S) * 1e9))
    for t, is_state in sorted(events):
        stamp_ns = start_ns + round(t * 1e9)
        if is_state:
            tracker.add_extruder(ExtruderSample(
                stamp_ns, bool(job.extruding(t)), float(job.plunger_velocity(t)),
                float(job.flow_rate(t))))
        else:
            tracker.add_pose(stamp_ns, job.tip(t))
    path = tracker.path()
    assert path is not None
    return path
