"""Profiles of test prints whose ink follows a law that can be checked by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from perception_builders import START_NS

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import transform
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.testprints.plan import StrokePlan, TestPrint
from bpc_perception.core.testprints.setup import way_through

MM = 1e-3
SPACING = 0.05 * MM
SIGMA = 0.02 * MM
PERIOD = 1e-6  # between states of the extruder: it is known when it was told [s]


@dataclass(frozen=True)
class Ink:
    """How an ink prints.

    Attributes:
        width: of the bead, of each stroke or of all [m].
        start_lag, stop_lag: of the extruder [s].
        height: of the bead over its width.
        torn: part of a stroke's length, from its middle on, where it is bare.
    """

    width: Callable[[StrokePlan], float] | float
    start_lag: float = 0.0
    stop_lag: float = 0.0
    height: float = 0.5
    torn: float = 0.0


def printed(test: TestPrint, ink: Ink, T_base_design: Array | None = None,
            left_out: tuple[int, ...] = (), spacing: float = SPACING) -> ThicknessProfile:
    """A test print of an ink, whose design lies at a place; some strokes are not printed.

    Samples are so far apart [m].
    """
    rows, points, number, begins = [], [], 0, 0.0
    arc_begins = 0.0
    for index, (stroke, plan) in enumerate(zip(test.design.strokes, test.plans, strict=True)):
        if index in left_out:
            continue
        number += 1
        way = way_through(stroke, plan)
        arcs = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))))
        # Between two samples each the extruder is told.
        s = np.arange(spacing / 2, arcs[-1], spacing)
        along = s - plan.lead_in
        on = (along > 0) & (along < stroke.length)
        inked = ((along > plan.speed * ink.start_lag)
                 & (along < stroke.length + plan.speed * ink.stop_lag))
        inked &= ~((along > stroke.length / 2)
                   & (along < stroke.length * (0.5 + ink.torn)))
        status = np.where(on, np.where(inked, Status.MEASURED, Status.GAP),
                          np.where(inked, Status.OOZE, Status.BARE))
        width = ink.width(plan) if callable(ink.width) else ink.width
        rows.append(np.stack((begins + s / plan.speed, arc_begins + s, number * on, status,
                              np.full(len(s), width), np.full(len(s), stroke.layer)), axis=1))
        points.append(np.stack([np.interp(s, arcs, axis) for axis in way.T], axis=1))
        begins, arc_begins = rows[-1][-1, 0] + 1.0, rows[-1][-1, 1] + 0.02
    time, arc, number_of, status, widths, layer = np.concatenate(rows).T
    place = np.concatenate(points)
    place = place if T_base_design is None else transform(T_base_design, place)
    return _profile(time, arc, place, number_of.astype(np.intp), status.astype(np.uint8), widths,
                    layer.astype(np.intp), ink.height)


def _profile(time: Array, arc: Array, points: Array, stroke: Array, status: Array, width: Array,
             layer: Array, ratio: float) -> ThicknessProfile:
    count = len(time)
    measured = np.where(status == Status.MEASURED, 1.0, np.nan)
    thickness = np.where(status == Status.GAP, 0.0, width * measured)
    height, no_places = ratio * thickness, np.full((count, 3), np.nan)
    return ThicknessProfile(
        stamp_ns=START_NS + round(1e9 * (time[-1] + 5)), print_id='test', print_start_ns=START_NS,
        capture=0, method='', time=time, arc_length=arc, points=points, extruding=stroke > 0,
        extruder_known=np.ones(count, bool), stroke=stroke, status=status, thickness=thickness,
        sigma=SIGMA * measured, left=width / 2 * measured, right=width / 2 * measured,
        left_points=no_places, right_points=no_places, layer=np.where(stroke > 0, layer, -1),
        height=height, height_sigma=SIGMA * measured, area=2 / 3 * thickness * height,
        area_sigma=0.01 * thickness * height, seen_in=np.zeros(count, np.intp),
        commanded_area=np.full(count, np.nan), cause=np.zeros(count, np.uint8),
        shift=np.full(3, np.nan), tip_height=np.nan, processing_time=0.0)
