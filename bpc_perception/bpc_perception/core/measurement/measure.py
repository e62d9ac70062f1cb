"""From one capture and the path to a thickness profile."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.bed import bed_plane
from bpc_perception.core.measurement.incremental import measure_incrementally, PrintMemory
from bpc_perception.core.measurement.paper.method import measure_as_published
from bpc_perception.core.measurement.scale import pixel_size
from bpc_perception.core.measurement.side_points import between, nearest
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import tangents, typical_spacing
from bpc_perception.core.profile import Status, ThicknessProfile


class MeasurementError(ValueError):
    """Nothing can be measured in a capture; the message says why."""


def measure(capture: Capture, path: DepositionPath, T_base_camera: Array,
            config: ThicknessConfig, number: int = 0,
            memory: PrintMemory | None = None) -> ThicknessProfile:
    """Thickness along the path that the nozzle had passed when captured.

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
    path = path.until(capture.stamp_ns)
    if len(path) < 2:
        raise MeasurementError('path: expected 2 points or more before the capture, '
                               f'found {len(path)}')
    try:
        bed = bed_plane(capture, path.points, T_base_camera)
    except ValueError as error:
        raise MeasurementError(str(error)) from error
    kept = on_bed(path.points, bed, config.maximum_tip_height)
    path = path if kept.all() else path.where(kept)
    if len(path) < 2:
        raise MeasurementError('path: expected the nozzle at the bed, found it lifted all along')
    if (path.points == path.points[0]).all():
        raise MeasurementError('path: expected a way along the bed, found one place')
    if config.method == 'paper':
        sides, status, sigma = measure_as_published(
            capture, path.points, T_base_camera, bed, config)
    else:
        # Sections closer together than pixels see the same.
        step = min(int(pixel_size(capture, path.points, T_base_camera)
                       / typical_spacing(path.points)), len(path) // 3)
        sides, status, sigma = measure_incrementally(
            capture, path.every(step) if step > 1 else path, T_base_camera, bed, config,
            memory or PrintMemory())
        if step > 1:
            place = np.arange(len(path)) / step
            sides, sigma = sides.between(place), between(sigma, place)
            status = status[nearest(place, len(status))]

    measured = status == Status.MEASURED
    for values in (sides.left, sides.right, sides.left_distance, sides.right_distance, sigma):
        values[~measured] = np.nan
    thickness = np.linalg.norm(sides.left - sides.right, axis=1)
    thickness[status == Status.GAP] = 0.0
    return ThicknessProfile(
        stamp_ns=capture.stamp_ns, print_id=path.print_id, print_start_ns=path.start_ns,
        capture=number, method=config.method, time=path.time, arc_length=path.arc_length,
        points=path.points, extruding=path.extruding, status=status, thickness=thickness,
        sigma=sigma, left=sides.left_distance, right=sides.right_distance,
        left_points=sides.left, right_points=sides.right,
        processing_time=time.perf_counter() - started)


def on_bed(points: Array, bed: Plane, maximum_height: float) -> NDArray[np.bool_]:
    """Which path points (N, 3) the nozzle passed low and along the bed, not lifted or lifting."""
    rising = np.abs(tangents(points) @ bed.normal)  # NaN where the path turns back on itself
    kept: NDArray[np.bool_] = (bed.height(points) <= maximum_height) & ~(rising >= 0.5)
    return kept
