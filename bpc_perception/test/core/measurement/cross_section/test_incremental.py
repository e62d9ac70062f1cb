"""A growing print measured where something is new is measured as if all were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from perception_builders import (
    bed,
    capture_of,
    DOWN,
    INK,
    path_through,
    PIXEL,
    pose,
    SECOND,
    START_NS,
    surface,
)
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.cross_section import incremental
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure, MeasurementError
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

ROWS = (20, 44, 68, 92)  # of the strands' middles, each 9 pixels wide
LEFT, RIGHT = 15, 145
WIDTH_TRUE = 9 * PIXEL
CONFIG = ThicknessConfig()
LATER = START_NS + 1000 * SECOND
NOZZLE = (150, 152, 158)


def strands(count: int = len(ROWS)) -> DepositionPath:
    """A path along so many strands, there and back; a point on every pixel."""
    columns = np.arange(LEFT, RIGHT + 1.0)
    corners = []
    for number, row in enumerate(ROWS[:count]):
        along = columns if number % 2 == 0 else columns[::-1]
        corners.append(np.stack((along, np.full(len(along), row)), axis=1))
        if number + 1 < count:
            down = np.arange(row + 1.0, ROWS[number + 1])
            corners.append(np.stack((np.full(len(down), along[-1]), down), axis=1))
    return path_through(surface(np.concatenate(corners)))


PATH = strands()


def drawn(laid: int, seed: int) -> NDArray[np.uint8]:
    """An image of the print after so many path points, with a sensor's noise."""
    image = bed()
    uv = PATH.points[:laid, :2] / (PIXEL, -PIXEL) + (79.5, 59.5)
    for u, v in np.rint(uv).astype(int):
        image[v - 4:v + 5, u - (0 if v in ROWS else 4):u + (1 if v in ROWS else 5)] = INK
    return noisy(image, seed)


def noisy(image: NDArray[np.uint8], seed: int) -> NDArray[np.uint8]:
    noise = np.random.default_rng(seed).normal(0, 2, image.shape)
    return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)


def with_nozzle(capture: Capture, u: int, v: int) -> Capture:
    """The capture with something round that stands 10 mm high at a pixel."""
    rows, columns = np.mgrid[:capture.camera.height, :capture.camera.width]
    there = np.hypot(columns - u, rows - v) <= 7
    capture.image[there] = NOZZLE
    capture.cloud[there] *= 0.49 / 0.5
    return capture


def until(count: int) -> DepositionPath:
    """The first so many points of the path."""
    return PATH.where(np.arange(len(PATH)) < count)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many points were measured each time."""
    counts: list[int] = []
    whole = incremental.measure_cross_sections

    def count(*arguments: object) -> object:
        index = arguments[4] if len(arguments) > 4 else arguments[1]
        counts.append(len(index))  # type: ignore[arg-type]
        return whole(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(incremental, 'measure_cross_sections', count)
    return counts


class Growing:
    """A print that is measured again and again, with memory and without."""

    def __init__(self) -> None:
        self.memory = PrintMemory()
        self.seed = 0

    def measure(self, count: int, path: DepositionPath | None = None,
                nozzle: tuple[int, int] | None = None, image: NDArray[np.uint8] | None = None,
                T_base_camera: Array = DOWN) -> tuple[ThicknessProfile, ThicknessProfile]:
        """Profiles after so many path points: with what is remembered, and all anew."""
        self.seed += 1
        capture = capture_of(drawn(count, self.seed) if image is None else image, LATER)
        if nozzle is not None:
            capture = with_nozzle(capture, *nozzle)
        path = until(count) if path is None else path
        return (measure(capture, path, T_base_camera, CONFIG, memory=self.memory),
                measure(capture, path, T_base_camera, CONFIG))


def assert_alike(one: ThicknessProfile, other: ThicknessProfile) -> None:
    """The same where both are sure: both captures had noise of their own."""
    assert (one.status == other.status).mean() > 0.98
    both = (one.status == Status.MEASURED) & (other.status == Status.MEASURED)
    off = np.abs(one.thickness - other.thickness)[both]
    assert (off <= 4 * np.hypot(one.sigma, other.sigma)[both]).all()


def test_a_growing_print_is_measured_as_if_all_were(asked: list[int]) -> None:
    growing = Growing()
    for count in range(300, len(PATH) + 1, 29):
        one, other = growing.measure(count)
        assert len(one) == count
        assert_alike(one, other)
        inner = one.status == Status.MEASURED
        assert inner.mean() > 0.8
        assert np.abs(one.thickness[inner] - WIDTH_TRUE).mean() < 0.1 * PIXEL
    with_memory = np.array(asked[::2])
    assert with_memory[0] == 300
    assert (with_memory[1:] < 0.6 * np.array(asked[1::2])[1:]).mean() > 0.7


def test_the_same_picture_again_costs_nothing_and_gives_the_same(asked: list[int]) -> None:
    growing = Growing()
    image = drawn(len(PATH), 1)
    first, _ = growing.measure(len(PATH), image=image)
    second, _ = growing.measure(len(PATH), image=image)
    assert asked == [len(PATH)] * 2 + [len(PATH)]
    np.testing.assert_array_equal(first.thickness, second.thickness)
    np.testing.assert_array_equal(first.left_points, second.left_points)
    np.testing.assert_array_equal(first.status, second.status)


def test_noise_alone_changes_nothing(asked: list[int]) -> None:
    growing = Growing()
    growing.measure(len(PATH))
    asked.clear()
    growing.measure(len(PATH))
    assert asked == [len(PATH)]  # that without memory


def test_two_runs_over_the_same_captures_agree_to_the_bit() -> None:
    profiles = []
    for _ in range(2):
        growing = Growing()
        profiles.append([growing.measure(count, nozzle=(60 + count % 40, 80))[0]
                         for count in range(300, 420, 30)])
    for one, other in zip(*profiles, strict=True):
        np.testing.assert_array_equal(one.thickness, other.thickness)
        np.testing.assert_array_equal(one.sigma, other.sigma)
        np.testing.assert_array_equal(one.status, other.status)


def test_where_the_nozzle_moves_away_the_print_is_measured() -> None:
    growing = Growing()
    count = len(PATH)
    hidden, _ = growing.measure(count, nozzle=(60, ROWS[1]))
    assert (hidden.status == Status.OCCLUDED).sum() >= 14
    one, other = growing.measure(count, nozzle=(110, ROWS[2]))
    # What the nozzle hides now was seen before, and is still known.
    covered = other.status == Status.OCCLUDED
    assert covered.sum() >= 14
    assert (one.status[covered] == Status.MEASURED).all()
    np.testing.assert_array_equal(one.thickness[covered], hidden.thickness[covered])
    assert_alike(one, replace(other, status=np.where(covered, one.status, other.status),
                              thickness=np.where(covered, one.thickness, other.thickness),
                              sigma=np.where(covered, one.sigma, other.sigma)))
    was = hidden.status == Status.OCCLUDED
    assert (one.status[was] == Status.MEASURED).all()
    gone, _ = growing.measure(count)
    assert not (gone.status == Status.OCCLUDED).any()


def test_ink_laid_beside_is_noticed() -> None:
    # A drop runs into the bead's side: over its length the bead is wider.
    growing = Growing()
    before, _ = growing.measure(len(PATH))
    image = drawn(len(PATH), 7)
    image[ROWS[1] + 5:ROWS[1] + 8, 70:90] = INK
    after, other = growing.measure(len(PATH), image=image)
    assert_alike(after, other)
    u = np.rint(PATH.points[:, 0] / PIXEL + 79.5)
    v = np.rint(59.5 - PATH.points[:, 1] / PIXEL)
    wider = (v == ROWS[1]) & (u > 73) & (u < 86)
    np.testing.assert_allclose(before.thickness[wider], WIDTH_TRUE, atol=0.5 * PIXEL)
    np.testing.assert_allclose(after.thickness[wider], WIDTH_TRUE + 3 * PIXEL, atol=0.7 * PIXEL)


def test_a_strand_laid_against_another_makes_a_junction() -> None:
    # The path comes back along its second strand, 6 pixels beside it: ink on ink.
    back = surface(np.stack((np.arange(RIGHT, 60.0, -1), np.full(85, ROWS[1] + 6.0)), axis=1))
    growing = Growing()
    first = strands(2)
    image = bed()
    for row in ROWS[:2]:
        image[row - 4:row + 5, LEFT:RIGHT + 1] = INK
    growing.measure(0, first, image=noisy(image, 1))
    image[ROWS[1] + 2:ROWS[1] + 11, 61:RIGHT + 1] = INK
    path = path_through(np.concatenate((first.points, back)))
    one, other = growing.measure(0, path, image=noisy(image, 2))
    assert_alike(one, other)
    assert (one.status == Status.JUNCTION).sum() > 100


def test_when_the_camera_has_moved_all_is_measured(asked: list[int]) -> None:
    growing = Growing()
    growing.measure(len(PATH))
    T = pose((0.02, -0.01, 0.03), (5, 0, 0))
    moved = replace(PATH, points=PATH.points @ T[:3, :3].T + T[:3, 3])
    asked.clear()
    growing.measure(len(PATH), moved, T_base_camera=T @ DOWN)
    growing.measure(len(PATH), moved, T_base_camera=T @ DOWN @ pose((0.001, 0, 0)))
    assert asked == [len(PATH)] * 4


def test_another_print_begins_anew(asked: list[int]) -> None:
    growing = Growing()
    growing.measure(len(PATH))
    asked.clear()
    growing.measure(len(PATH), replace(PATH, print_id='other'))
    assert asked == [len(PATH)] * 2


def test_a_path_that_has_changed_is_measured_there(asked: list[int]) -> None:
    growing = Growing()
    growing.measure(len(PATH))
    asked.clear()
    shifted = PATH.points.copy()
    shifted[:20, 1] += 0.2 * PIXEL
    one, other = growing.measure(len(PATH), replace(PATH, points=shifted))
    assert asked[0] < asked[1] == len(PATH)
    assert_alike(one, other)


def test_where_no_more_ink_is_laid_a_gap_is_a_gap(asked: list[int]) -> None:
    growing, laid = Growing(), 330
    for count in range(laid, len(PATH) + 1, 29):
        one, other = growing.measure(count, image=drawn(laid, count))
        assert_alike(one, other)
        assert (one.status[laid + 10:] == Status.GAP).all()
    assert min(asked) < len(PATH) / 2


def test_a_capture_that_is_refused_in_between_does_no_harm(asked: list[int]) -> None:
    growing = Growing()
    growing.measure(400)
    blind = capture_of(drawn(410, 3), LATER)
    blind.cloud[:] = np.nan
    with pytest.raises(MeasurementError, match='cloud: expected'):
        measure(blind, until(410), DOWN, CONFIG, memory=growing.memory)
    asked.clear()
    one, other = growing.measure(420)
    assert asked[0] < asked[1]
    assert_alike(one, other)


def test_slow_changes_add_up_until_they_are_noticed() -> None:
    # A bead widens by less than is noticed from one capture to the next.
    growing = Growing()
    for share in np.linspace(0, 1, 9):
        image = drawn(len(PATH), 5).astype(float)
        rim = image[ROWS[1] + 5, LEFT:RIGHT + 1]
        image[ROWS[1] + 5, LEFT:RIGHT + 1] = share * np.array(INK) + (1 - share) * rim
        one, _ = growing.measure(len(PATH), image=np.rint(image).astype(np.uint8))
    v = np.rint(59.5 - PATH.points[:, 1] / PIXEL)
    u = np.rint(PATH.points[:, 0] / PIXEL + 79.5)
    wider = (v == ROWS[1]) & (u > LEFT + 10) & (u < RIGHT - 10)
    assert np.median(one.thickness[wider]) > WIDTH_TRUE + 0.7 * PIXEL
