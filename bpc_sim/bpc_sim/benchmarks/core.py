"""Speed of the measurement: both methods and what others would write, beside a floor.

The floor is what any method that looks for edges pays for a whole image: one blur, one Canny, one
findContours. Ratios to the floor hold on other machines as well; milliseconds do not.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_sim.benchmarks.core_prints import DrawnPrint, long_print, PIXEL_M, spiral
from bpc_sim.benchmarks.paper_transcription import measure_as_in_the_paper
from bpc_sim.benchmarks.timing import no_progress, Progress, ROUNDS, time_interleaved, Timing
from bpc_sim.stress.stress_scene import StressScene
from bpc_sim.studies.peers.methods import half_level
from bpc_sim.studies.peers.picture import picture_of

Row = dict[str, object]

DEFAULT, PAPER = ThicknessConfig(), ThicknessConfig(method='paper')
IMAGE_SIZES_PX = ((512, 512), (1024, 1024), (1944, 1200), (2448, 2048))
POINT_COUNTS = (100, 1000, 10000)  # of path points
QUICK_ROUNDS = 3
TRANSCRIBED_WORK = 1000 * 512**2  # points times pixels; the loops take minutes for more
MAX_MAE_MM = {'default': 0.02, 'paper': 0.1, 'transcription': 0.1, 'path-normal': 0.1}
MEASURED_LENGTHS_M = (0.2, 2.0)  # of path already measured, when a capture is added
ADDED_POINTS = 3  # of the path, with that capture
PATH_SPACING_M = 2e-4


def run(quick: bool = False, progress: Progress = no_progress) -> list[Row]:
    """Return rows of all sizes, and of a print that grows."""
    cv2.setNumThreads(1)  # as in the nodes, which leave the other cores to others
    rows = []
    sizes, counts = (IMAGE_SIZES_PX[:1], POINT_COUNTS[:1]) if quick else (
        IMAGE_SIZES_PX, POINT_COUNTS)
    rounds = QUICK_ROUNDS if quick else ROUNDS
    done = 0
    for width, height in sizes:
        # A square image is full; in a camera's image the print covers a quarter.
        side = width if width == height else int(np.sqrt(width * height / 4))
        drawn = spiral(width, height, side)
        for count in counts:
            rows += time_methods(drawn, count, rounds)
            done += 1
            progress(done, len(sizes) * len(counts) + 1)  # and the print that grows
    return rows + time_growth(MEASURED_LENGTHS_M[:1] if quick else MEASURED_LENGTHS_M, rounds)


def time_methods(drawn: DrawnPrint, count: int, rounds: int) -> list[Row]:
    """Time all methods on one print with a number of path points; verify each before."""
    capture, T_base_camera = drawn.capture, drawn.T_base_camera
    path = drawn.path(drawn.deposit.curve.uniform(count))
    runs: dict[str, Callable[[], Array]] = {
        'default': partial(measure_thickness, DEFAULT, capture, path, T_base_camera),
        'paper': partial(measure_thickness, PAPER, capture, path, T_base_camera),
        'path-normal': partial(measure_path_normal, capture, path, T_base_camera)}
    if count * capture.camera.width * capture.camera.height <= TRANSCRIBED_WORK:
        runs['transcription'] = partial(measure_as_in_the_paper, capture, path, T_base_camera)
    errors = {name: verified(name, drawn.error_mm(path.arc_length, run()))
              for name, run in runs.items()}
    times = time_interleaved({'floor': partial(floor, capture.image), **runs}, rounds)
    return [row(capture, count, name, errors.get(name, np.nan), times[name], times['floor'])
            for name in times]


def time_growth(lengths: tuple[float, ...], rounds: int) -> list[Row]:
    """Time a capture that adds little to a print of each length [m] that is measured already."""
    runs: dict[str, Callable[[], Array]] = {}
    errors, counts = {}, {}
    for length in lengths:
        count = round(length / PATH_SPACING_M) + 1
        memory = PrintMemory()
        before, path = _print_with_points(count)
        measure(before.capture, path, before.T_base_camera, DEFAULT, memory=memory)
        drawn, path = _print_with_points(count + ADDED_POINTS)
        name = f'capture after {length:g} m'
        runs[name], counts[name] = partial(measure_again, drawn, path, memory), len(path)
        errors[name] = verified('default', drawn.error_mm(path.arc_length, runs[name]()))
    times = time_interleaved({'floor': partial(floor, drawn.capture.image), **runs}, rounds)
    return [row(drawn.capture, counts[name], name, errors[name], times[name], times['floor'])
            for name in runs]


def _print_with_points(count: int) -> tuple[DrawnPrint, DepositionPath]:
    """Return the long print up to a number of path points, and its path."""
    s = np.arange(count) * np.float64(PATH_SPACING_M)
    drawn = long_print(s[-1], count)
    return drawn, drawn.path(s)


def row(capture: Capture, points: int, what: str, error_mm: float, timing: Timing,
        floor_timing: Timing) -> Row:
    """Return a row of the table."""
    return {'image': f'{capture.camera.width}x{capture.camera.height}', 'points': points,
            'what': what, 'median_ms': timing.median * 1e3, 'p95_ms': timing.p95 * 1e3,
            'of_floor': timing.median / floor_timing.median, 'MAE_mm': error_mm}


def verified(method: str, error_mm: float) -> float:
    """Return the error [mm]. Raises ValueError if the result that is to be timed is wrong."""
    if not error_mm <= MAX_MAE_MM[method]:
        raise ValueError(f'bench core: expected {method} to err by {MAX_MAE_MM[method]} mm at '
                         f'most, found {error_mm:.4f}')
    return error_mm


def measure_thickness(config: ThicknessConfig, capture: Capture, path: DepositionPath,
                      T_base_camera: Array) -> Array:
    """Return the thickness (N,) [m] by one of our methods, without memory of other captures."""
    return measure(capture, path, T_base_camera, config).thickness


def measure_again(drawn: DrawnPrint, path: DepositionPath, memory: PrintMemory) -> Array:
    """Return the thickness (N,) [m] with memory of the print as it was before."""
    copy = PrintMemory()
    copy.last, copy.layers = memory.last, memory.layers
    return measure(drawn.capture, path, drawn.T_base_camera, DEFAULT, memory=copy).thickness


def measure_path_normal(capture: Capture, path: DepositionPath, T_base_camera: Array) -> Array:
    """Return the thickness (N,) [m] at half the level across the path, as others write it."""
    known = np.zeros(len(path))
    scene = StressScene('', capture, T_base_camera, path.points, path.arc_length, known,
                        known.astype(np.uint8), PIXEL_M)
    return half_level(picture_of(scene)) * PIXEL_M


def floor(image: NDArray[np.uint8]) -> object:
    """Run one blur, one Canny and one findContours."""
    edges = cv2.Canny(cv2.GaussianBlur(image, (5, 5), 0), 50, 150)
    return cv2.findContours(edges, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
