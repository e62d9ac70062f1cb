"""Small worlds with truth that can be checked by hand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.geometry import transform
from bpc_perception.core.measurement.cross_section.sections.sections import Sections
from bpc_perception.core.path.assembler import PathAssembler
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.core.path.tracker import PrintTracker
from bpc_perception.core.profile import Status, ThicknessProfile

START_NS = 1_700_000_000 * 10**9
SECOND = 10**9
BED, INK = (205, 205, 200), (40, 80, 170)
PIXEL = 2e-4  # [m] on the surface
SPEED = 0.01  # of a nozzle [m/s]
WIDTH, HEIGHT = 160, 120


def pose(xyz: Sequence[float] = (0, 0, 0), angles: Sequence[float] = (0, 0, 0)) -> Array:
    """A 4x4 transform of a position [m] and zyx Euler angles [degrees]."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler('zyx', angles, degrees=True).as_matrix()
    matrix[:3, 3] = xyz
    return matrix


def camera(width: int = WIDTH, height: int = HEIGHT, pixel: float = PIXEL) -> PinholeCamera:
    """A pinhole 0.5 m away from a surface on which a pixel has this size [m]."""
    focal = 0.5 / pixel
    K = np.array(((focal, 0, (width - 1) / 2), (0, focal, (height - 1) / 2), (0, 0, 1.0)))
    return PinholeCamera(K, np.zeros(5), width, height)


def surface(points: Array) -> Array:
    """Points (..., 2) as pixels (u, v) put on the plane z = 0 of the base frame [m]."""
    centre = np.array(((WIDTH - 1) / 2, (HEIGHT - 1) / 2))
    xy = (np.asarray(points, float) - centre) * (PIXEL, -PIXEL)
    return np.concatenate((xy, np.zeros((*xy.shape[:-1], 1))), axis=-1)


# Pose of a camera that looks straight down at the base frame's origin from 0.5 m above.
DOWN = np.diag((1.0, -1.0, -1.0, 1.0))
DOWN[2, 3] = 0.5


def bed() -> NDArray[np.uint8]:
    """An image (H, W, 3) of the empty bed."""
    return np.full((HEIGHT, WIDTH, 3), BED, np.uint8)


def capture_of(image: NDArray[np.uint8], stamp_ns: int = START_NS) -> Capture:
    """A capture of the plane z = 0 from above, its cloud exactly on it."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    base = surface(np.stack((u, v), axis=-1))
    cloud = transform(np.linalg.inv(DOWN), base).astype(np.float32)
    return Capture(stamp_ns, 'camera_optical_frame', image, cloud, camera())


def band_image(rows: tuple[int, int] = (50, 60), columns: tuple[int, int] = (30, 130),
               ) -> NDArray[np.uint8]:
    """The bed with a band of ink whose pixels are these rows and columns, ends included."""
    image = bed()
    image[rows[0]:rows[1] + 1, columns[0]:columns[1] + 1] = INK
    return image


def path_through(points: Array, start_ns: int = START_NS, speed: float = 0.01,
                 print_id: str = 'print', extruding: Iterable[bool] | None = None,
                 finished: bool = True) -> DepositionPath:
    """A path through points (N, 3), passed at constant speed from start_ns on."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    arc = np.concatenate(([0.0], np.cumsum(steps)))
    on = np.ones(len(points), bool) if extruding is None else np.array(list(extruding), bool)
    time = arc / speed
    return DepositionPath(
        print_id=print_id, start_ns=start_ns, complete_until=float(time[-1]) if len(time) else 0.0,
        finished=finished, time=time, arc_length=arc, points=np.asarray(points, float),
        plunger_velocity=np.full(len(points), 1e-4), flow_rate=np.full(len(points), 1e-8),
        extruding=on, extruder_known=np.ones(len(points), bool))


def pixel_path(start: Sequence[float], end: Sequence[float], count: int = 41,
               **keywords: object) -> DepositionPath:
    """A straight path on the plane z = 0 between two pixels (u, v)."""
    points = surface(np.linspace(start, end, count))
    return path_through(points, **keywords)  # type: ignore[arg-type]


def profile_of(thickness: Sequence[float], status: Sequence[int] | None = None, *,
               spacing: float = 1e-3, extruding: Sequence[bool] | None = None,
               speed: float = 0.01, delay: float = 1.0) -> ThicknessProfile:
    """A profile along the x axis, captured ``delay`` seconds after its last sample was laid."""
    count = len(thickness)
    arc = spacing * np.arange(count)
    time = arc / speed
    statuses = np.array([Status.MEASURED] * count if status is None else status, np.uint8)
    values = np.array(thickness, float)
    points = np.column_stack((arc, np.zeros((count, 2))))
    side = np.array((0.0, 0.5, 0.0)) * values[:, None]
    last = float(time[-1]) if count else 0.0
    return ThicknessProfile(
        stamp_ns=START_NS + round((last + delay) * SECOND), print_id='print',
        print_start_ns=START_NS, capture=3, method='paper', time=time, arc_length=arc,
        points=points, extruding=np.ones(count, bool) if extruding is None
        else np.array(extruding, bool), extruder_known=np.ones(count, bool),
        stroke=np.ones(count, np.intp), status=statuses, thickness=values,
        sigma=np.full(count, 1e-5), left=values / 2, right=values / 2, left_points=points + side,
        right_points=points - side, **on_one_layer(count), processing_time=0.25)


def on_one_layer(count: int) -> dict[str, NDArray[Any]]:
    """Samples on the bed, found in the first capture, of which no height is known."""
    unknown = np.full(count, np.nan)
    return {'layer': np.zeros(count, np.intp), 'seen_in': np.zeros(count, np.intp),
            'height': unknown, 'height_sigma': unknown, 'area': unknown, 'area_sigma': unknown,
            'commanded_area': unknown, 'cause': np.zeros(count, np.uint8),
            'shift': np.full(3, np.nan), 'tip_height': np.nan}


def one_piece(count: int) -> Index:
    """The numbers of the pieces of a path that is unbroken."""
    return np.zeros(count, np.intp)


def sections_of(height: Array, offset: Array, pixel: float, spacing: float) -> Sections:
    """Sections along +y, seen from straight above, of a surface.

    Args:
        height: (N, M) of it at each sample [m].
        offset: (M,) of the samples [m].
        pixel: length of a pixel's side [m].
        spacing: between sections [m].
    """
    count, no = len(height), np.zeros(height.shape, bool)
    along = np.arange(count) * spacing
    return Sections(
        piece=one_piece(count), along=along,
        foot=np.column_stack((along, np.zeros((count, 2)))),
        lateral=np.tile((0.0, 1.0, 0.0), (count, 1)), lean=np.zeros(count),
        in_row=np.zeros(count), offset=offset, pixel=pixel, spacing=spacing, inside=~no,
        hidden=no, depth=np.ones(count, bool), raised=np.ones(count, bool), beside=no,
        clearance=np.zeros((2, count)), foreign=no, nearing=no,
        colour=np.zeros((*height.shape, 3), np.float32), height=height.astype(np.float32),
        place=np.tile(offset, (count, 1)).astype(np.float32))


def along_x(times: Array, speed: float = SPEED) -> Array:
    """Positions (N, 3) of a nozzle that moves along the x axis, at times (N,) [s]."""
    return np.column_stack((speed * times, np.zeros((len(times), 2))))


def at_ns(time: float) -> int:
    """The stamp of a time [s after START_NS]."""
    return START_NS + round(time * SECOND)


def path_bytes(path: DepositionPath, count: int | None = None) -> list[bytes]:
    """The arrays of the first ``count`` points to the last bit."""
    return [array[:count].tobytes() for array in (
        path.time, path.arc_length, path.points, path.plunger_velocity, path.flow_rate,
        path.extruding, path.extruder_known)]


def advice_of(reason: Reason, valid: bool = True, **others: float) -> RateAdvice:
    """Advice at 0 s that holds until 5 s, with other values where they are named."""
    made = RateAdvice(
        stamp_ns=0, print_id='print', valid=valid, reason=reason, target_thickness=2e-3,
        measured_thickness=2.2e-3, window=(0.0, 0.02), sample_count=100, flow_rate_scale=0.83,
        speed_scale=1.2, confidence=1.0, measurement_age=0.0, valid_until_ns=5 * 10**9)
    return replace(made, **others)


def state(time: float, extruding: bool = True, start_ns: int = START_NS) -> ExtruderSample:
    """The extruder at a time [s after start_ns]; velocity and flow tell the time."""
    return ExtruderSample(start_ns + round(time * SECOND), extruding, time, 2 * time)


def states_until(end: float, period: float = 0.1) -> list[ExtruderSample]:
    """States of an extruder that pushes ink out from time 0 to an end [s]."""
    return [state(time) for time in np.arange(0, end, period)]


def feed(target: PathAssembler | PrintTracker, times: Array, tips: Array,
         states: Iterable[ExtruderSample]) -> None:
    """Hand over positions (N, 3) at times (N,) [s] and extruder states, in order of time."""
    poses = [(START_NS + round(time * SECOND), tip)
             for time, tip in zip(times, tips, strict=True)]
    left = sorted(states, key=lambda sample: sample.stamp_ns)
    for stamp_ns, tip in poses:
        while left and left[0].stamp_ns <= stamp_ns:
            target.add_extruder(left.pop(0))
        target.add_pose(stamp_ns, tip)
    for sample in left:
        target.add_extruder(sample)


def assemble(times: Array, tips: Array, states: Iterable[ExtruderSample],
             config: PathConfig | None = None) -> PathAssembler:
    """A print from positions (N, 3) at times (N,) [s], and extruder states."""
    assembler = PathAssembler(GrowingPath('print', START_NS),
                              config or PathConfig(smoothing_time=0))
    feed(assembler, times, tips, states)
    return assembler
