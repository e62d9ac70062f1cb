"""From one capture and the path to a thickness profile."""

from __future__ import annotations

from collections.abc import Callable
import time

import numpy as np

from bpc_perception.core.amounts import commanded_area
from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.capture.capture import Capture, pixel_deviation
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.bed import find_bed
from bpc_perception.core.measurement.cross_section.incremental import (
    look_across_travel,
    measure_across_path,
    PrintMemory,
)
from bpc_perception.core.measurement.ground import Ground
from bpc_perception.core.measurement.kept import Kept
from bpc_perception.core.measurement.layered import measure_layers, Places
from bpc_perception.core.measurement.paper.method import measure_as_published
from bpc_perception.core.measurement.registration import (
    register,
    Registration,
    without_misplaced,
)
from bpc_perception.core.measurement.samples import Samples, unseen
from bpc_perception.core.measurement.track import Track, track_along
from bpc_perception.core.measurement.travel import as_travel, look_at_travel
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.layers import ON_TRAVEL
from bpc_perception.core.path.strokes import stroke_numbers
from bpc_perception.core.path.tangents import tangents
from bpc_perception.core.profile import Status, ThicknessProfile

# With intrinsics farther off, widths and places are: 2 pixels are 1 % of the distance between the
# middle of a small picture and its corners.
LARGEST_DEVIATION_PX = 2.0
STEEPEST_RISE = 0.5  # of the path above the bed, per length, where ink is laid
# So far outside the image, in lengths of a section to one side, path still plays a part: as other
# ink, and as what is steady along the path.
VIEW_MARGIN = 3.0

# By the names of ``ThicknessConfig.method``. The published method measures everything each time.
METHODS: dict[str, Callable[[View, Track, Plane, ThicknessConfig, PrintMemory], Samples]] = {
    'cross_section': measure_across_path,
    'paper': lambda view, track, bed, config, _: measure_as_published(view, track, bed, config),
}
# By the same names: whether ink is seen at an index of travel points of a track.
LOOKS: dict[str, Callable[
    [View, Track, Index, Plane, ThicknessConfig, PrintMemory], Verdicts]] = {
    'cross_section': look_across_travel,
    'paper': lambda view, track, index, bed, config, _: as_travel(measure_as_published(
        view, track.of(index), bed, config).verdicts),
}


LAYERED = 'cross_section'  # the method that measures ink on ink


class MeasurementError(ValueError):
    """Nothing can be measured in a capture; the message says why."""


class TooEarlyError(MeasurementError):
    """Nothing is laid yet."""


def measure(capture: Capture, path: DepositionPath, T_base_camera: Array,
            config: ThicknessConfig, number: int = 0,
            memory: PrintMemory | None = None, ground: Ground | None = None) -> ThicknessProfile:
    """Measure the thickness along the path that the nozzle had passed when captured.

    Path points where the nozzle was lifted off the bed get no sample. Measured are the strokes;
    along travel near the bed it is only looked for ink.

    Args:
        capture: image and organized cloud of one moment.
        path: the print's path, in the robot base frame.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame.
        config: how to measure.
        number: number of the capture within the print.
        memory: of the print's captures before, which saves measuring again what is as it was.
        ground: what they show where ink was laid since.

    Raises:
        MeasurementError: the path is too short, the camera does not see where it is, or the method
            does not know layers.
    """
    started = time.perf_counter()
    expect_own_pixels(capture)
    view = View(capture, T_base_camera, number, config.cross_section.color_space)
    path = path_before(capture, path)
    shown = view.surrounds(path.points, config.cross_section.reach * VIEW_MARGIN)
    bed = bed_around(view, path.points[shown] if shown.any() else path.points)
    low = on_bed(path, bed, config.maximum_tip_height)
    height = bed.height(path.points)
    stroke = stroke_numbers(path, height, low)
    path, stroke, shown = path_on_bed(path, low, float(np.median(height))), stroke[low], shown[low]
    memory = memory or PrintMemory()
    layer = memory.layers.layers(path, stroke, bed).layer
    expect_method_for_layers(layer, config.method)
    places = Places(stroke, layer, shown)
    if (layer > 0).any():
        samples = measure_layers(view, path, places, bed, config, memory)
        if ground is not None:
            samples = ground.without_doubted(samples, path)
    else:
        samples = measure_one_layer(view, path, places, bed, config, memory, ground)
        if memory.kept is not None:
            samples = memory.kept.at(path).where_unseen(samples)
        memory.kept = Kept.of(path, samples)
    layer = np.where(stroke > 0, layer, ON_TRAVEL)
    registration = register(view, path.points, layer, samples, bed)
    samples = without_misplaced(samples, stroke > 0, registration.shift)
    return profile_of(samples, places, view, path, config.method, registration, started)


def measure_one_layer(view: View, path: DepositionPath, places: Places, bed: Plane,
                      config: ThicknessConfig, memory: PrintMemory,
                      ground: Ground | None) -> Samples:
    """Measure strokes that all lie on the bed, and look at what lies between and below them."""
    stroke, shown = places.stroke, places.shown
    samples = measure_strokes(view, path, stroke, shown, bed, config, memory)
    samples = look_at_travel(
        view, path, stroke, shown, samples, bed,
        lambda track, index: LOOKS[config.method](view, track, index, bed, config, memory))
    if ground is None:
        return samples
    return ground.judge(
        view, path, stroke, shown, samples, bed, lambda view, track, index:
        LOOKS[config.method](view, track, index, bed, config, memory))


def expect_own_pixels(capture: Capture) -> None:
    """Raise MeasurementError where camera info and cloud contradict each other."""
    deviation = pixel_deviation(capture.cloud, capture.camera)
    if deviation > LARGEST_DEVIATION_PX:
        raise MeasurementError(
            'camera_info: expected intrinsics that put the cloud onto its own pixels, found it '
            f'{deviation:.1f} pixels beside them; are they of another resolution or camera?')


def expect_method_for_layers(layer: Index, method: str) -> None:
    """Raise MeasurementError where ink lies on ink (N,) and the method knows one layer only."""
    if method != LAYERED and (layer > 0).any():
        raise MeasurementError(
            f'method: expected {LAYERED} for a print in layers, found {method}, which takes ink '
            'below for the bead; set the method, or measure the first layer only')


def path_before(capture: Capture, path: DepositionPath) -> DepositionPath:
    """Return the path up to a capture. Raises MeasurementError if that is less than 2 points."""
    path = path.until(capture.stamp_ns)
    if len(path) < 2:
        raise TooEarlyError('path: expected 2 points or more before the capture, '
                               f'found {len(path)}; capture later')
    return path


def bed_around(view: View, points: Array) -> Plane:
    """Return the bed around path points (N, 3).

    Raises MeasurementError where the camera does not see it.
    """
    try:
        return find_bed(view, points)
    except ValueError as error:
        raise MeasurementError(str(error)) from error


def path_on_bed(path: DepositionPath, low: Flags, height: float) -> DepositionPath:
    """Return the path without the points (N,) at which the nozzle was lifted, or was lifting.

    For the message, ``height`` is how high it usually was [m].

    Raises MeasurementError if nothing, or a single place, is left.
    """
    path = path if low.all() else path.where(low)
    if len(path) < 2:
        raise MeasurementError('path: expected the nozzle at the bed, found it '
                               f'{1e3 * height:.0f} mm above all along; do z of nozzle_offset, '
                               'base frame and calibration fit?')
    if (path.points == path.points[0]).all():
        raise TooEarlyError('path: expected a way along the bed, found one place'
                               '; capture when the nozzle has moved')
    return path


def on_bed(path: DepositionPath, bed: Plane, maximum_height: float) -> Flags:
    """Return which points (N,) of a path the nozzle passed near enough to lay ink.

    That is no higher than this above the bed, or above where ink was laid before [m].
    """
    height = bed.height(path.points)
    rising = np.abs(tangents(path.points) @ bed.normal)  # NaN where the path turns back on itself
    level = ~(rising >= STEEPEST_RISE)
    laid = level & path.extruding & path.extruder_known
    low, lower = height <= maximum_height, np.zeros(len(path), bool)
    while (low != lower).any():
        built = np.maximum.accumulate(np.where(laid & low, height, 0.0))
        low, lower = height <= maximum_height + np.append(0.0, built[:-1]), low
    return np.asarray(low & level)


def measure_strokes(view: View, path: DepositionPath, stroke: Index, shown: Flags, bed: Plane,
                    config: ThicknessConfig, memory: PrintMemory) -> Samples:
    """Measure the strokes of a path as far as they are in view; the rest is NO_DATA.

    Args:
        view: the capture.
        path: N points.
        stroke: (N,) number of the stroke of each; 0 = travel.
        shown: (N,) whether each is in the image, or so near to it that it plays a part.
        bed: plane of the bed.
        config: how to measure.
        memory: of the captures before.
    """
    samples = unseen(len(path))
    chosen = np.flatnonzero(shown & (stroke > 0))
    if len(chosen) < 2:
        return samples
    track = track_along(path, stroke, chosen)
    return samples.with_part(chosen, METHODS[config.method](view, track, bed, config, memory))


def profile_of(samples: Samples, places: Places, view: View, path: DepositionPath, method: str,
               registration: Registration, started: float) -> ThicknessProfile:
    """Return the samples of a path as a profile; ``started`` is when measuring began [s]."""
    measured = samples.status == Status.MEASURED
    left, right, left_distance, right_distance, sigma, *sizes = (
        np.where(measured.reshape(-1, *(1,) * (values.ndim - 1)), values, np.nan)
        for values in (*samples.sides.arrays(), samples.sigma, *samples.sizes.arrays()))
    _, _, height, height_sigma, area, area_sigma = sizes
    thickness = np.full(len(path), np.nan)
    thickness[measured] = np.linalg.norm(left[measured] - right[measured], axis=1)
    gap = samples.status == Status.GAP
    thickness[gap] = height[gap] = area[gap] = 0.0
    return ThicknessProfile(
        stamp_ns=view.capture.stamp_ns, print_id=path.print_id, print_start_ns=path.start_ns,
        capture=view.number, method=method, time=path.time, arc_length=path.arc_length,
        points=path.points, extruding=path.extruding, extruder_known=path.extruder_known,
        stroke=places.stroke, status=samples.status.copy(), cause=samples.verdicts.cause.copy(),
        thickness=thickness, sigma=sigma, left=left_distance, right=right_distance,
        left_points=left, right_points=right,
        layer=np.where(places.stroke > 0, places.layer, ON_TRAVEL),
        height=height, height_sigma=height_sigma, area=area, area_sigma=area_sigma,
        commanded_area=commanded_area(path, places.stroke),
        seen_in=np.where(samples.status == Status.NO_DATA, -1, samples.seen_in),
        shift=registration.shift, tip_height=registration.tip_height,
        processing_time=time.perf_counter() - started)
