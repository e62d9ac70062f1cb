"""The measurement's speed: both methods, what others would write, and a floor beside them.

The floor is what any method that looks at edges pays for a whole image: one blur, one Canny, one
findContours. Ratios to it hold on other machines as well; milliseconds do not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_sim.benchmarks.timing import interleaved, ROUNDS, silent, Told
from bpc_sim.benchmarks.transcription import transcribed
from bpc_sim.ink.curves import archimedean, meander
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.scene.imaging import expose, Imaging, mix
from bpc_sim.scene.planar import planar_capture
from bpc_sim.scene.raster import coverage
from bpc_sim.stress.truth import SPEED, STAMP_NS, StressScene
from bpc_sim.studies.peer_methods import half_level, picture_of

Row = dict[str, object]

DEFAULT, PAPER = ThicknessConfig(), ThicknessConfig(method='paper')
PIXEL = 1e-4  # [m]
WIDTH = 2e-3  # of the bead [m]
IMAGING = Imaging(blur=1.0, noise=2.0, lamp_gradient=0.12)
SIZES = ((512, 512), (1024, 1024), (1944, 1200), (2448, 2048))
POINTS = (100, 1000, 10000)
PLAIN = 1000 * 512**2  # the loops of more points times pixels take minutes
LIMIT = {'default': 0.02, 'paper': 0.1, 'transcription': 0.1, 'path-normal': 0.1}  # MAE [mm]
ANSWERED = 0.95
ENDS = 4e-3  # within this of ends and gaps nothing is compared [m]
LENGTHS = (0.2, 2.0)  # of path already measured, when a capture is added [m]
ADDED = 3  # path points that it adds
SPACING = 2e-4  # of these [m]


@dataclass(frozen=True)
class Print:
    """A print on a plane bed and a picture of it.

    Attributes:
        deposit: the ink.
        capture: what the camera delivers.
        T_base_camera: (4, 4) its pose.
    """

    deposit: Deposit
    capture: Capture
    T_base_camera: Array

    def path(self, s: Array) -> DepositionPath:
        """The path at arc lengths (N,) [m]."""
        points = np.column_stack((self.deposit.curve.points(s), np.zeros(len(s))))
        unknown = np.full(len(s), np.nan)
        return DepositionPath('print', 0, STAMP_NS * 1e-9, True, s / SPEED, s, points, unknown,
                              unknown, np.ones(len(s), bool))

    def error(self, arc_length: Array, thickness: Array) -> float:
        """Mean absolute error of thickness (N,) away from where ink starts or ends [mm].

        Infinite where less than ANSWERED is given.
        """
        borders = np.abs(arc_length[:, None] - self.deposit.runs.ravel()).min(axis=1)
        inner = (borders > ENDS) & (self.deposit.width(arc_length) > 0)
        error = np.abs(thickness[inner] - WIDTH) * 1e3
        given = np.isfinite(error)
        return float(error[given].mean()) if given.mean() >= ANSWERED else np.inf


def run(quick: bool = False, progress: Told = silent) -> list[Row]:
    """Rows of all sizes, and of a print that grows."""
    cv2.setNumThreads(1)  # as in the nodes, whose neighbours want the other cores
    rows = []
    sizes, points = (SIZES[:1], POINTS[:1]) if quick else (SIZES, POINTS)
    done = 0
    for width, height in sizes:
        # Square images are full, a camera's picture a quarter.
        side = width if width == height else int(np.sqrt(width * height / 4))
        drawn = spiral(width, height, side)
        for count in points:
            rows += compare(drawn, count, 3 if quick else ROUNDS)
            done += 1
            progress(done, len(sizes) * len(points) + 1)  # and the print that grows
    return rows + grow(LENGTHS[:1] if quick else LENGTHS, 3 if quick else ROUNDS)


def compare(drawn: Print, count: int, rounds: int) -> list[Row]:
    """All methods on one print, each verified before it is timed."""
    capture, T_base_camera, path = drawn.capture, drawn.T_base_camera, drawn.path(
        drawn.deposit.curve.uniform(count))
    runs: dict[str, Callable[[], Array]] = {
        'default': partial(by, DEFAULT, capture, path, T_base_camera),
        'paper': partial(by, PAPER, capture, path, T_base_camera),
        'path-normal': partial(path_normal, capture, path, T_base_camera)}
    if count * capture.camera.width * capture.camera.height <= PLAIN:
        runs['transcription'] = partial(transcribed, capture, path, T_base_camera)
    errors = {name: verified(name, drawn.error(path.arc_length, run()))
              for name, run in runs.items()}
    times = interleaved({'floor': partial(floor, capture.image), **runs}, rounds)
    size = f'{capture.camera.width}x{capture.camera.height}'
    return [row(size, count, name, errors.get(name, np.nan), *times[name], times['floor'][0])
            for name in times]


def grow(lengths: tuple[float, ...], rounds: int) -> list[Row]:
    """A capture that adds little to a print of some length, all but that measured before."""
    runs: dict[str, Callable[[], Array]] = {}
    errors, counts = {}, {}
    for length in lengths:
        count = round(length / SPACING) + 1
        memory = PrintMemory()
        for points in (count, count + ADDED):
            s = np.arange(points) * np.float64(SPACING)
            drawn = long_print(s[-1], points)
            path = drawn.path(s)
            if points == count:
                measure(drawn.capture, path, drawn.T_base_camera, DEFAULT, memory=memory)
        name = f'capture after {length:g} m'
        runs[name], counts[name] = partial(again, drawn, path, memory), len(path)
        errors[name] = verified('default', drawn.error(s, runs[name]()))
    times = interleaved({'floor': partial(floor, drawn.capture.image), **runs}, rounds)
    size = f'{drawn.capture.camera.width}x{drawn.capture.camera.height}'
    return [row(size, counts[name], name, errors[name], *times[name], times['floor'][0])
            for name in runs]


def row(size: str, points: int, what: str, error: float, median: float, p95: float,
        floor_time: float) -> Row:
    """A line of the table."""
    return {'image': size, 'points': points, 'what': what, 'median_ms': median * 1e3,
            'p95_ms': p95 * 1e3, 'of_floor': median / floor_time, 'MAE_mm': error}


def verified(method: str, error: float) -> float:
    """The error [mm]; raises ValueError where the result to be timed is wrong."""
    if not error <= LIMIT[method]:
        raise ValueError(f'bench core: expected {method} to err by {LIMIT[method]} mm at most, '
                         f'found {error:.4f}')
    return error


def by(config: ThicknessConfig, capture: Capture, path: DepositionPath,
       T_base_camera: Array) -> Array:
    """Thickness (N,) by one of the product's methods, nothing remembered."""
    return measure(capture, path, T_base_camera, config).thickness


def again(drawn: Print, path: DepositionPath, memory: PrintMemory) -> Array:
    """Thickness (N,) when the print as it was before is remembered."""
    copy = PrintMemory()
    copy.last = memory.last
    return measure(drawn.capture, path, drawn.T_base_camera, DEFAULT, memory=copy).thickness


def path_normal(capture: Capture, path: DepositionPath, T_base_camera: Array) -> Array:
    """Thickness (N,) at half the level across the path, as others would write it."""
    known = np.zeros(len(path))
    scene = StressScene('', capture, T_base_camera, path.points, path.arc_length, known,
                        known.astype(np.uint8), PIXEL)
    return half_level(picture_of(scene)) * PIXEL


def floor(image: NDArray[np.uint8]) -> object:
    """One blur, one Canny, one findContours."""
    edges = cv2.Canny(cv2.GaussianBlur(image, (5, 5), 0), 50, 150)
    return cv2.findContours(edges, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)


def spiral(width: int, height: int, side: int) -> Print:
    """A spiral with two gaps in the middle ``side`` x ``side`` pixels of a picture."""
    curve = archimedean(12 * PIXEL * side / 512, np.pi, 6 * np.pi)
    gaps = np.array(((0.2, 0.22), (0.6, 0.63))) * curve.length
    deposit = Deposit(curve, constant_width(WIDTH), gaps)
    return photograph(deposit, width, height, side)


def long_print(length: float, seed: int) -> Print:
    """The first so many metres of a meander of 2 m on 0.1 m x 0.1 m."""
    curve = meander(4e-3, 0.088, 22)
    deposit = replace(Deposit(curve, constant_width(WIDTH)), laid=length)
    return photograph(deposit, 1000, 1000, 1000, seed)


def photograph(deposit: Deposit, width: int, height: int, side: int, seed: int = 0) -> Print:
    """A picture, of which the middle ``side`` x ``side`` pixels may have ink."""
    covered = np.zeros((height, width))
    v, u = (height - side) // 2, (width - side) // 2
    covered[v:v + side, u:u + side] = coverage(lambda places: deposit.locate(places).margin,
                                               side, PIXEL, 4)
    # The path's origin is the middle of that square, half a pixel off the image's if odd.
    image = expose(mix(IMAGING.ink, IMAGING.bed, covered), covered, IMAGING,
                   np.random.default_rng(seed))
    capture, T_base_camera = planar_capture(image, PIXEL, STAMP_NS)
    return Print(deposit, capture, T_base_camera)
