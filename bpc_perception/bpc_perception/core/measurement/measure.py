"""From one capture and the path to a thickness profile."""

from __future__ import annotations

from collections.abc import Callable
import time

import numpy as np

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.bed import find_bed
from bpc_perception.core.measurement.cross_section.incremental import (
    measure_across_path,
    PrintMemory,
)
from bpc_perception.core.measurement.paper.method import measure_as_published
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import tangents
from bpc_perception.core.profile import Status, ThicknessProfile

STEEPEST_RISE = 0.5  # of the path above the bed, per length, where ink is laid

# By the names of ``ThicknessConfig.method``. The published method measures everything each time.
METHODS: dict[str, Callable[
    [View, DepositionPath, Plane, ThicknessConfig, PrintMemory], Samples]] = {
    'cross_section': measure_across_path,
    'paper': lambda view, path, bed, config, _: measure_as_published(
        view, path.points, bed, config),
}


class MeasurementError(ValueError):
    """Nothing can be measured in a capture; the message says why."""


def measure(capture: Capture, path: DepositionPath, T_base_camera: Array,
            config: ThicknessConfig, number: int = 0,
            memory: PrintMemory | None = None) -> ThicknessProfile:
    """Measure the thickness along the path that the nozzle had passed when captured.

    Path points where the nozzle was lifted off the bed get no sample.

    Args:
        capture: image and organized cloud of one moment.
        path: the print's path, in the robot base frame.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame.
        config: how to measure.
        number: number of the capture within the print.
        memory: of the print's captures before, which saves measuring again what is as it was.

    Raises:
        MeasurementError: the path is too short, or the camera does not see where it is.
    """
    started = time.perf_counter()
    view = View(capture, T_base_camera)
    path = path_before(capture, path)
    bed = bed_around(view, path)
    path = path_on_bed(path, bed, config.maximum_tip_height)
    samples = METHODS[config.method](view, path, bed, config, memory or PrintMemory())
    return profile_of(samples, capture, path, config.method, number, started)


def path_before(capture: Capture, path: DepositionPath) -> DepositionPath:
    """Return the path up to a capture. Raises MeasurementError if that is less than 2 points."""
    path = path.until(capture.stamp_ns)
    if len(path) < 2:
        raise MeasurementError('path: expected 2 points or more before the capture, '
                               f'found {len(path)}')
    return path


def bed_around(view: View, path: DepositionPath) -> Plane:
    """Return the bed around the path. Raises MeasurementError where the camera does not see it."""
    try:
        return find_bed(view, path.points)
    except ValueError as error:
        raise MeasurementError(str(error)) from error


def path_on_bed(path: DepositionPath, bed: Plane, maximum_height: float) -> DepositionPath:
    """Return the path without the points at which the nozzle was lifted, or was lifting, [m].

    Raises MeasurementError if nothing, or a single place, is left.
    """
    low = on_bed(path.points, bed, maximum_height)
    path = path if low.all() else path.where(low)
    if len(path) < 2:
        raise MeasurementError('path: expected the nozzle at the bed, found it lifted all along')
    if (path.points == path.points[0]).all():
        raise MeasurementError('path: expected a way along the bed, found one place')
    return path


def on_bed(points: Array, bed: Plane, maximum_height: float) -> Flags:
    """Return which path points (N, 3) the nozzle passed along the bed, no higher than this [m]."""
    rising = np.abs(tangents(points) @ bed.normal)  # NaN where the path turns back on itself
    kept: Flags = (bed.height(points) <= maximum_height) & ~(rising >= STEEPEST_RISE)
    return kept


def profile_of(samples: Samples, capture: Capture, path: DepositionPath, method: str,
               number: int, started: float) -> ThicknessProfile:
    """Return the samples of a path as a profile; ``started`` is when measuring began [s]."""
    measured = samples.status == Status.MEASURED
    left, right, left_distance, right_distance, sigma = (
        np.where(measured.reshape(-1, *(1,) * (values.ndim - 1)), values, np.nan)
        for values in (*samples.sides.arrays(), samples.sigma))
    thickness = np.linalg.norm(left - right, axis=1)
    thickness[samples.status == Status.GAP] = 0.0
    return ThicknessProfile(
        stamp_ns=capture.stamp_ns, print_id=path.print_id, print_start_ns=path.start_ns,
        capture=number, method=method, time=path.time, arc_length=path.arc_length,
        points=path.points, extruding=path.extruding, status=samples.status.copy(),
        thickness=thickness, sigma=sigma, left=left_distance, right=right_distance,
        left_points=left, right_points=right, processing_time=time.perf_counter() - started)
