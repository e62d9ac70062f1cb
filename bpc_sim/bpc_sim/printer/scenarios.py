"""Named prints. Every builder takes the robot's speed: tests print fast, demonstrations as real.

The bed lies in front of the robot and is not quite level. The camera stands beside the robot and
looks down at the bed from 25 degrees off its normal, as far away as a Zivid 2 M70 can focus.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import transform
from bpc_sim.ink.curves import (
    archimedean as archimedean_curve,
    Curve,
    fermat as fermat_curve,
    line as line_curve,
    meander as meander_curve,
    polyline,
    ring as ring_curve,
)
from bpc_sim.ink.deposit import constant_width, Deposit, knot_width, WidthProfile
from bpc_sim.printer.layers import Strands
from bpc_sim.printer.motion import Travel
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.scene.camera import look_at, View, zivid_m70
from bpc_sim.scene.surfaces import Cylinder, Plane, Surface

PRINT_SPEED_M_PER_S = 3e-3  # the paper's
POSE_RATE_HZ = 100.0  # as the LBR stack's controller manager
CAMERA_DISTANCE_M = 0.34  # 0.19 mm per pixel
CAMERA_TILT_RAD = np.radians(25.0)


def bed_pose() -> Array:
    """Return T_base_surface (4, 4): in front of the robot, 1.2 degrees off level."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler('zyx', (20.0, 0.7, -1.0), degrees=True).as_matrix()
    pose[:3, 3] = (0.55, 0.05, 0.02)
    return pose


def camera_view(width: int = 304, height: int = 228, scale: float = 1.0,
                tilt: float = CAMERA_TILT_RAD) -> View:
    """Return the camera of the scenarios, which looks at the middle of the bed.

    Args:
        width: width of the image [pixels].
        height: height of the image [pixels].
        scale: scale of the camera's full image.
        tilt: angle between the view and the bed's normal [rad].
    """
    T_base_surface = bed_pose()
    eye = transform(T_base_surface,
                    CAMERA_DISTANCE_M * np.array((0.0, -np.sin(tilt), np.cos(tilt))))
    return View(zivid_m70(width, height, scale),
                look_at(eye, T_base_surface[:3, 3], T_base_surface[:3, 0]))


def spiral_gaps(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return the sample print: a spiral of slowly varying width, two planned gaps and a fault."""
    curve = archimedean_curve(1e-3, np.pi, 6 * np.pi)
    return _job(curve, speed, printed=_slow_variation(curve, 2e-3, 0.12),
                gaps=((0.055, 0.061), (0.118, 0.123)), faults=((0.088, 0.092),))


def line(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return a line of 50 mm; extrusion stops half-way."""
    return _job(line_curve(0.05), speed, gaps=((0.025, 0.05),))


def ring(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return a closed circle of 15 mm radius."""
    return _job(ring_curve(0.015), speed)


def meander(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return five strands of 36 mm, 6 mm apart."""
    curve = meander_curve(6e-3, 0.036, 5)
    return _job(curve, speed, printed=_slow_variation(curve, 2e-3, 0.1))


def archimedean(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return an Archimedean spiral, 6.3 mm from turn to turn."""
    return _job(archimedean_curve(1e-3, np.pi, 6 * np.pi), speed)


def fermat(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return both branches of a Fermat spiral, 38 mm across."""
    return _job(fermat_curve(7.5e-3, 2 * np.pi), speed)


def strokes(speed: float = PRINT_SPEED_M_PER_S, hop: float = 2e-3) -> PrintJob:
    """Return five parallel lines of 36 mm, 5 mm apart, each begun at the same side."""
    return stroke_job(parallel_lines(5, 5e-3, 0.036), speed, Travel(0, 0, hop))


def dense(speed: float = PRINT_SPEED_M_PER_S, hop: float = 0.3e-3) -> PrintJob:
    """Return nine lines of 36 mm, to and fro, with 0.6 mm of bed between them.

    The plunger is drawn back for each travel, by a tenth of what a line takes.
    """
    lines = parallel_lines(9, 2.6e-3, 0.036)
    lines[1::2] = lines[1::2, ::-1]
    return stroke_job(lines, speed, Travel(0, 0, hop, retraction=0.02e-3))


def purge(speed: float = PRINT_SPEED_M_PER_S, away: float = 0.15) -> PrintJob:
    """Return the dense lines, after a line ``away`` from them [m], out of view."""
    lines = np.concatenate((parallel_lines(1, 0.0, 0.02) - np.array((0.0, away)),
                            parallel_lines(9, 2.6e-3, 0.036)))
    return stroke_job(lines, speed, Travel(0, 0, speed=0.1))


def stack(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return three lines of 30 mm, 6 mm apart, and two layers more on top of them."""
    lines = parallel_lines(3, 6e-3, 0.03)
    return layer_job([lines, lines, lines], speed, width=2e-3, layer_height=0.5e-3)


def wall(speed: float = PRINT_SPEED_M_PER_S, pause: float = 20.0) -> PrintJob:
    """Return a wall of ten strokes of 30 mm on top of each other, with pauses between."""
    there = parallel_lines(1, 0.0, 0.03)
    return layer_job([there, there[:, ::-1]] * 5, speed, width=2e-3, layer_height=0.4e-3,
                     travel=Travel(0, 0, 0.02, pause=pause))


def lattice(speed: float = PRINT_SPEED_M_PER_S, layers: int = 4,
            surface: Surface | None = None) -> PrintJob:
    """Return a lattice of strands of 1.3 mm, 4 mm apart, that cross from layer to layer."""
    along = parallel_lines(5, 4e-3, 0.021)
    across = along[..., ::-1]
    return layer_job([along, across] * (layers // 2), speed, width=1.3e-3, layer_height=0.35e-3,
                     sag=0.1e-3, surface=surface)


def crosshatch(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return the first two layers of the lattice."""
    return lattice(speed, layers=2)


def lattice_curved(speed: float = PRINT_SPEED_M_PER_S) -> PrintJob:
    """Return the lattice on a cylinder of 60 mm radius."""
    return lattice(speed, surface=Cylinder(0.06))


def parallel_lines(count: int, pitch: float, length: float) -> Array:
    """Return lines (count, 2, 2) along x from start to end, ``pitch`` apart, about the origin."""
    lines = np.empty((count, 2, 2))
    lines[..., 0] = -length / 2, length / 2
    lines[..., 1] = ((np.arange(count) - (count - 1) / 2) * pitch)[:, None]
    return lines


def stroke_job(lines: Array, speed: float, travel: Travel, width: float = 2e-3) -> PrintJob:
    """Return a job that lays straight strokes.

    Args:
        lines: (S, 2, 2) start and end of each [m].
        speed: along them [m/s].
        travel: how the nozzle goes from one to the next.
        width: of the ink [m].
    """
    curve = polyline(lines.reshape(-1, 2)[_distinct(lines.reshape(-1, 2))])
    legs = np.linalg.norm(np.diff(lines.reshape(-1, 2), axis=0), axis=1)
    arcs = np.concatenate(([0.0], np.cumsum(legs)))
    ways = arcs[1:-1].reshape(-1, 2)
    job = _job(curve, speed, width, gaps=tuple(map(tuple, ways.tolist())))
    return replace(job, travels=tuple(
        replace(travel, start=start, end=end) for start, end in ways.tolist()))


def layer_job(layers: Sequence[Array], speed: float, width: float, layer_height: float,
              sag: float = 0.0, travel: Travel | None = None,
              surface: Surface | None = None) -> PrintJob:
    """Return a job that lays straight strokes in layers.

    Args:
        layers: (S, 2, 2) start and end of the strokes of each [m].
        speed: along them [m/s].
        width: of the ink [m].
        layer_height: from one layer to the next [m].
        sag: how far ink hangs down between two strokes below [m].
        travel: how the nozzle goes from one to the next.
        surface: shape of the bed; None = a plane.
    """
    number = np.repeat(np.arange(len(layers)), [len(lines) for lines in layers])
    strands = Strands(np.concatenate(layers), number, layer_height, sag)
    job = stroke_job(strands.lines, speed, travel or Travel(0, 0), width)
    rising = tuple(replace(each, rise=rise) for each, rise in zip(
        job.travels, strands.rises.tolist(), strict=True))
    ink = replace(job.commanded, base=strands.feet())
    return replace(job, commanded=ink, travels=rising, layers=strands.layer_arcs,
                   filament=2 / 3 * ink.height_ratio, surface=surface or Plane())


def _distinct(points: Array) -> NDArray[np.bool_]:
    """Return which points (N, 2) differ from the one before."""
    return np.concatenate(([True], (np.diff(points, axis=0) != 0).any(axis=1)))


SCENARIOS: dict[str, Callable[[float], PrintJob]] = {
    'spiral_gaps': spiral_gaps,
    'line': line,
    'ring': ring,
    'meander': meander,
    'archimedean': archimedean,
    'fermat': fermat,
    'strokes': strokes,
    'dense': dense,
    'purge': purge,
    'stack': stack,
    'wall': wall,
    'lattice': lattice,
    'crosshatch': crosshatch,
    'lattice_curved': lattice_curved,
}


def _job(curve: Curve, speed: float, width: float = 2e-3, printed: WidthProfile | None = None,
         gaps: tuple[tuple[float, float], ...] = (),
         faults: tuple[tuple[float, float], ...] = ()) -> PrintJob:
    """Return a job of a constant commanded width [m], on the common bed."""
    return PrintJob(Deposit(curve, constant_width(width), np.reshape(gaps, (-1, 2))),
                    bed_pose(), camera_view(), printed, np.reshape(faults, (-1, 2)), speed)


def _slow_variation(curve: Curve, width: float, amplitude: float) -> WidthProfile:
    """Return a width that varies around ``width`` [m] by a fraction; it is always the same."""
    knots = curve.uniform(9)
    return knot_width(knots, width * (1 + amplitude * np.cos(1.3 * np.arange(9)**1.5)))
