"""The design of a simulated print, in the robot base frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.comparison import WantedDesign
from bpc_perception.core.design.design import Design, DesignStroke
from bpc_perception.core.design.registration import place_at
from bpc_sim.printer.print_job import PrintJob

STEP_S = 0.02


def design_of(job: PrintJob) -> Design:
    """Return where a job commands ink, and how wide."""
    times = np.arange(job.dwell_before, job.end_of_path, STEP_S)
    laid = job.extruding(times)
    borders = np.flatnonzero(np.diff(laid, prepend=False, append=False))
    return Design(tuple(_stroke(job, times[one:two])
                        for one, two in borders.reshape(-1, 2).tolist() if two - one > 1))


def _stroke(job: PrintJob, times: Array) -> DesignStroke:
    points = job.tip(times)
    moves = np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))
    widths = job.commanded.profile(job.laid(times[moves]))
    return DesignStroke(points[moves], widths[1:])


def wanted(design: Design, shift: Array | None = None) -> WantedDesign:
    """Return a design that lies where it says, or so far beside (3,) [m]."""
    away = np.zeros(3) if shift is None else shift
    moved = replace(design, strokes=tuple(
        replace(stroke, points=stroke.points + away) for stroke in design.strokes))
    return WantedDesign('design.csv', moved, place_at(0, 0, 0, 0))
