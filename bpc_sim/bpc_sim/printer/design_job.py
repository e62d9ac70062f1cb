"""A print of a design: its strokes with their flows and speeds, by an extruder with faults."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.design import Design, DesignError
from bpc_perception.core.geometry import transform
from bpc_perception.core.testprints.plan import Part, StrokePlan
from bpc_perception.core.testprints.setup import round_width, way_through
from bpc_sim.ink.curves import polyline
from bpc_sim.ink.deposit import Deposit, ON_BED, WidthProfile
from bpc_sim.ink.extrusion import ExtruderBehaviour, Extrusion
from bpc_sim.ink.laid_bead import laid_bead
from bpc_sim.ink.layered_bead import with_room
from bpc_sim.printer.layers import Strands
from bpc_sim.printer.motion import Motion
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import bed_pose, CAMERA_DISTANCE_M
from bpc_sim.scene.camera import (
    look_at,
    M70_FOCAL_LENGTH_PX,
    M70_HEIGHT_PX,
    M70_WIDTH_PX,
    View,
    zivid_m70,
)

HOP_M, TRAVEL_M_S, LIFT_M_S = 6e-3, 0.05, 0.025
STEP_S, STEP_M = 2e-3, 2e-5  # of the extruder's lag, and of where beads begin and end
AROUND_M = 12e-3  # the print, that the camera sees: its view leans
LEAST_WIDTH_PX, LEAST_HEIGHT_PX = 304, 228
TURN_RAD = np.radians(10.0)  # of the camera about the bed's normal
TILT_RAD = np.radians(15.0)  # at which both edges of steep beads are seen, up to the borders


def plans_of(design: Design, speed: float) -> tuple[StrokePlan, ...]:
    """Return flow and speed [m/s] of each stroke of a design by the width that it wants.

    Raises DesignError where it wants none.
    """
    plans = []
    for number, stroke in enumerate(design.strokes, 1):
        width = float(np.mean(stroke.widths))
        if np.isnan(width):
            raise DesignError(f'stroke {number}: expected a width, found none; fill in width_mm, '
                              'or print a test print, whose table of strokes has flows')
        plans.append(StrokePlan(Part.STRAND, np.pi / 4 * width**2 * speed, speed,
                                (0.0, stroke.length)))
    return tuple(plans)


def design_job(design: Design, plans: Sequence[StrokePlan], behaviour: ExtruderBehaviour,
               sag: float = 0.0) -> PrintJob:
    """Return a print of a design in the middle of the bed.

    Args:
        design: its strokes; on others they have to be straight.
        plans: flow, speed, and ways without ink of each.
        behaviour: of extruder and ink.
        sag: how far ink hangs down between two strokes below [m].

    Raises:
        DesignError: strokes in layers are not straight, or a flow is not known.
    """
    ways = [way_through(stroke, plan) for stroke, plan in zip(design.strokes, plans, strict=True)]
    places = np.concatenate(ways)[:, :2]
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    ways = [way - np.append(middle, 0.0) for way in ways]
    planar = np.concatenate(ways)[:, :2]
    kept = np.append(True, np.linalg.norm(np.diff(planar, axis=0), axis=1) > 1e-9)
    curve = polyline(planar[kept])
    legs = np.linalg.norm(np.diff(planar, axis=0), axis=1)
    arcs = np.split(np.append(0.0, np.cumsum(legs)), np.cumsum([len(way) for way in ways])[:-1])
    strokes = np.array([(arc[1], arc[-2]) for arc in arcs])
    commanded = Deposit(
        curve, _widths(strokes, plans), _between(strokes, curve.length),
        height_ratio=behaviour.height_ratio, base=_feet(design, ways, plans, sag))
    job = PrintJob(commanded, bed_pose(), _view(np.ptp(planar, axis=0)),
                   motion=_motion(ways, arcs, plans), tip_height=float(ways[0][0, 2]),
                   layers=_layers(design, strokes, curve.length))
    return replace(job, ink=_laid(job, behaviour))


def _widths(strokes: Array, plans: Sequence[StrokePlan]) -> WidthProfile:
    """Return the width of a round filament of each stroke's flow, over arc length."""
    widths = np.array([round_width(plan.flow, plan.speed) for plan in plans])
    if np.isnan(widths).any():
        raise DesignError('stroke table: expected a flow for each stroke, found an empty one'
                          '; fill in flow_mm3_s')
    borders = (strokes[1:, 0] + strokes[:-1, 1]) / 2
    return lambda s: widths[np.searchsorted(borders, s)]


def _between(strokes: Array, length: float) -> Array:
    """Return the arc lengths (S + 1, 2) without ink, between strokes (S, 2) [m]."""
    borders = np.concatenate(([0.0], strokes.ravel(), [length])).reshape(-1, 2)
    return borders[borders[:, 1] > borders[:, 0]]


def _feet(design: Design, ways: list[Array], plans: Sequence[StrokePlan],
          sag: float) -> WidthProfile:
    """Return the height of what each stroke lies on, over arc length."""
    if design.layers == 1:
        return ON_BED
    if any(len(way) != 4 for way in ways) or any(plan.lead_in + plan.run_out for plan in plans):
        raise DesignError('layers: expected straight strokes, without ways before and behind '
                          'them, found others; print designs of one layer with these')
    layer = np.array([stroke.layer for stroke in design.strokes])
    height = np.array([stroke.points[0, 2] for stroke in design.strokes])
    above = layer > 0
    rise = float(np.mean((height[above] - height[~above].min()) / layer[above]))
    return Strands(np.array([way[1:3, :2] for way in ways]), layer, rise, sag).feet()


def _motion(ways: list[Array], arcs: list[Array], plans: Sequence[StrokePlan]) -> Motion:
    """Return the motion along ways, lifted between them."""
    first = float(ways[0][0, 2])
    lifted = max(float(way[:, 2].max()) for way in ways) - first + HOP_M
    nodes, strokes = [(0.0, 0.0, 0.0, 0.0)], []

    def go(time: float, arc: float, height: float) -> None:
        nodes.append((nodes[-1][0] + time, arc, height, 0.0))

    for number, (way, arc, plan) in enumerate(zip(ways, arcs, plans, strict=True)):
        if number:
            _, before, low, _ = nodes[-1]
            go((lifted - low) / LIFT_M_S, before, lifted)
            go((arc[0] - before) / TRAVEL_M_S, arc[0], lifted)
            go((lifted - (way[0, 2] - first)) / LIFT_M_S, arc[0], way[0, 2] - first)
        times = []
        for place, height in zip(arc[1:].tolist(), way[1:, 2].tolist(), strict=True):
            times.append(nodes[-1][0] + (place - nodes[-1][1]) / plan.speed)
            go((place - nodes[-1][1]) / plan.speed, place, height - first)
        strokes.append((times[0], times[-2]))
    return Motion(np.array(nodes), np.array(strokes))


def _layers(design: Design, strokes: Array, length: float) -> Array:
    """Return the arc lengths (L, 2) in which layers are laid; empty = there is one [m]."""
    if design.layers == 1:
        return np.empty((0, 2))
    layer = np.array([stroke.layer for stroke in design.strokes])
    if (np.diff(layer) < 0).any():
        raise DesignError('layers: expected them one after the other, found one that goes on '
                          'later; put the strokes in order')
    begins = [float(strokes[layer == number, 0][0]) for number in np.unique(layer)]
    return np.column_stack((begins, [*begins[1:], length]))


def _view(extent: Array) -> View:
    """Return a camera that sees a print of this size along x and y [m].

    It is turned, so that no line runs along the rows of pixels.
    """
    cos, sin = np.cos(TURN_RAD), np.sin(TURN_RAD)
    seen = np.array(((cos, sin), (sin, cos))) @ extent + AROUND_M
    width, height = np.ceil(seen * M70_FOCAL_LENGTH_PX / CAMERA_DISTANCE_M).astype(int).tolist()
    bed = bed_pose()
    eye = CAMERA_DISTANCE_M * np.array((
        np.sin(TILT_RAD) * sin, -np.sin(TILT_RAD) * cos, np.cos(TILT_RAD)))
    camera = zivid_m70(int(np.clip(width, LEAST_WIDTH_PX, M70_WIDTH_PX)),
                       int(np.clip(height, LEAST_HEIGHT_PX, M70_HEIGHT_PX)))
    return View(camera, look_at(transform(bed, eye), bed[:3, 3],
                                bed[:3, :3] @ np.array((cos, sin, 0.0))))


def _laid(job: PrintJob, behaviour: ExtruderBehaviour) -> Deposit:
    """Return the ink that really comes out."""
    times = np.arange(0.0, job.duration + STEP_S, STEP_S)
    extrusion = Extrusion(behaviour, job.length)
    flows = job.flow_rate(times - STEP_S / 2)
    for time, s, flow in zip(times.tolist(), job.laid(times).tolist(), flows.tolist(),
                             strict=True):
        extrusion.advance(time, s, flow)
    return with_room(laid_bead(job.commanded, extrusion, STEP_M), job.layers)
