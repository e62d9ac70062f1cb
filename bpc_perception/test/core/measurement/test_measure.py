"""A drawn band, measured: thickness within a pixel, and a reason wherever there is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray
from perception_builders import (
    band_image,
    BED,
    bed,
    capture_of,
    DOWN,
    INK,
    path_through,
    PIXEL,
    pixel_path,
    pose,
    SECOND,
    START_NS,
    surface,
)
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.capture.colour_space import COLOUR_SPACES, LINEAR, SRGB
from bpc_perception.core.config import CrossSectionConfig, ThicknessConfig
from bpc_perception.core.geometry import Plane, transform
from bpc_perception.core.measurement.measure import (
    expect_method_for_layers,
    measure,
    MeasurementError,
    on_bed,
)
from bpc_perception.core.parameter import parameters_of
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

METHODS = parameters_of(ThicknessConfig)['method'][0].choices
PAPER = ThicknessConfig(method='paper')
LATER = START_NS + 60 * SECOND
ROWS, MIDDLE = (50, 60), 55  # eleven pixels of ink
WIDTH_TRUE = 11 * PIXEL
START_U, END_U = 40, 120
PATH = pixel_path((START_U, MIDDLE), (END_U, MIDDLE), 81)  # a point on every pixel


def columns(path: DepositionPath) -> Array:
    """The image column of each path point."""
    return np.rint(path.points[:, 0] / PIXEL + 79.5)


class Measure(Protocol):
    """Measures with the method of the test."""

    def __call__(self, capture: Capture, path: DepositionPath = PATH,
                 T_base_camera: Array = DOWN) -> ThicknessProfile: ...


@pytest.fixture(params=METHODS)
def measured(request: pytest.FixtureRequest) -> Measure:
    """The measurement by each method."""
    config = ThicknessConfig(method=request.param)

    def run(capture: Capture, path: DepositionPath = PATH,
            T_base_camera: Array = DOWN) -> ThicknessProfile:
        return measure(capture, path, T_base_camera, config, number=5)

    return run


def noisy(image: Array | NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The image with a sensor's noise."""
    noise = np.random.default_rng(2).normal(0, 2, image.shape)
    return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)


def assert_only_measured_and_gap_have_numbers(profile: ThicknessProfile) -> None:
    known = profile.status == Status.MEASURED
    gap = profile.status == Status.GAP
    assert np.isfinite(profile.thickness[known]).all()
    assert (profile.thickness[gap] == 0).all()
    assert np.isnan(profile.thickness[~known & ~gap]).all()
    for values in (profile.sigma, profile.left, profile.right):
        np.testing.assert_array_equal(np.isfinite(values), known)
    for points in (profile.left_points, profile.right_points):
        np.testing.assert_array_equal(np.isfinite(points).all(axis=1), known)


def test_a_band_is_measured_within_a_pixel(measured: Measure) -> None:
    profile = measured(capture_of(band_image(), LATER))
    assert (profile.status == Status.MEASURED).all()
    np.testing.assert_allclose(profile.thickness, WIDTH_TRUE, atol=1.01 * PIXEL)
    np.testing.assert_allclose(profile.left, WIDTH_TRUE / 2, atol=0.51 * PIXEL)
    np.testing.assert_allclose(profile.right, WIDTH_TRUE / 2, atol=0.51 * PIXEL)
    assert_only_measured_and_gap_have_numbers(profile)


def test_side_points_lie_on_either_side_at_right_angles(measured: Measure) -> None:
    profile = measured(capture_of(band_image(), LATER))
    # Along +x, left is +y.
    np.testing.assert_allclose(profile.left_points[:, 1] - profile.points[:, 1], profile.left,
                               atol=1e-6)
    np.testing.assert_allclose(profile.points[:, 1] - profile.right_points[:, 1], profile.right,
                               atol=1e-6)
    np.testing.assert_allclose(profile.left_points[:, 0], profile.points[:, 0], atol=1e-6)


@pytest.mark.parametrize('offset', [-3, 3])
def test_left_less_right_is_twice_the_offset_of_the_deposit(measured: Measure,
                                                            offset: int) -> None:
    path = pixel_path((START_U, MIDDLE + offset), (END_U, MIDDLE + offset), 81)
    profile = measured(capture_of(band_image(), LATER), path)
    # Rows grow downwards, so the deposit lies to the left of a path below its middle.
    np.testing.assert_allclose(profile.left - profile.right, 2 * offset * PIXEL, atol=1.01 * PIXEL)


def test_a_tilted_base_frame_gives_the_same_thickness(measured: Measure) -> None:
    capture = capture_of(band_image(), LATER)
    T = pose((0.5, -0.2, 0.1), (40, 10, -15))
    tilted = measured(capture, replace(PATH, points=transform(T, PATH.points)), T @ DOWN)
    plain = measured(capture)
    np.testing.assert_allclose(tilted.thickness, plain.thickness, atol=1e-7)
    np.testing.assert_allclose(tilted.left_points, transform(T, plain.left_points), atol=1e-7)


def test_a_path_above_the_bed_is_measured_on_the_bed(measured: Measure) -> None:
    above = replace(PATH, points=PATH.points + np.array((0, 0, 1e-3)))
    profile = measured(capture_of(band_image(), LATER), above)
    np.testing.assert_allclose(profile.thickness, WIDTH_TRUE, atol=1.01 * PIXEL)
    np.testing.assert_allclose(profile.left_points[:, 2], 0, atol=1e-6)


def test_sigma_is_that_of_two_pixel_edges() -> None:
    profile = measure(capture_of(band_image(), LATER), PATH, DOWN, PAPER)
    # Two edges, each spread evenly over a pixel; points off the axis are a little farther.
    np.testing.assert_allclose(profile.sigma, PIXEL * np.sqrt(2 / 12), rtol=2e-3)


def test_bed_without_ink_is_a_gap(measured: Measure) -> None:
    image = band_image()
    image[:, 70:86] = BED
    profile = measured(capture_of(image, LATER))
    u = columns(PATH)
    assert (profile.status[(u >= 72) & (u <= 83)] == Status.GAP).all()
    assert (profile.status[(u <= 68) | (u >= 87)] == Status.MEASURED).all()
    assert profile.summary.gap_count == 1
    assert profile.summary.gap_length == pytest.approx(16 * PIXEL, abs=2.01 * PIXEL)
    assert_only_measured_and_gap_have_numbers(profile)


def test_nothing_is_measured_on_an_empty_bed(measured: Measure) -> None:
    # Without any ink to compare with, a method may say gap or that it cannot tell.
    profile = measured(capture_of(noisy(bed()), LATER))
    assert set(profile.status) <= {Status.GAP, Status.LOW_CONFIDENCE}
    assert_only_measured_and_gap_have_numbers(profile)


def test_for_the_published_method_an_empty_bed_is_all_gap() -> None:
    profile = measure(capture_of(bed(), LATER), PATH, DOWN, PAPER)
    assert (profile.status == Status.GAP).all()
    assert_only_measured_and_gap_have_numbers(profile)


def test_nothing_is_known_outside_the_image(measured: Measure) -> None:
    path = pixel_path((100, MIDDLE), (200, MIDDLE), 101)
    profile = measured(capture_of(band_image(columns=(30, 140)), LATER), path)
    u = columns(path)
    assert (profile.status[u > 159] == Status.NO_DATA).all()
    assert (profile.status[u < 138] == Status.MEASURED).all()
    assert_only_measured_and_gap_have_numbers(profile)


@pytest.mark.parametrize('image', [band_image(), noisy(bed())], ids=['ink', 'bed'])
def test_nothing_is_known_without_depth(measured: Measure, image: NDArray[np.uint8]) -> None:
    capture = capture_of(image, LATER)
    capture.cloud[:, 70:91] = np.nan
    profile = measured(capture)
    u = columns(PATH)
    assert (profile.status[(u >= 73) & (u <= 87)] == Status.NO_DATA).all()
    assert (profile.status[(u < 68) | (u > 92)] != Status.NO_DATA).all()
    assert_only_measured_and_gap_have_numbers(profile)


def test_a_single_missing_point_does_no_harm(measured: Measure) -> None:
    capture = capture_of(band_image(), LATER)
    capture.cloud[MIDDLE, 80] = np.nan
    assert (measured(capture).status == Status.MEASURED).all()


def bright_spot(side: int, brighter: float) -> ThicknessProfile:
    """What comes of a spot on the bed beside the band, brighter than the bed by grey levels."""
    image = np.full((*bed().shape[:2], 3), BED, float)
    image[band_image()[..., 0] == INK[0]] = INK
    image += np.random.default_rng(5).normal(0, 1, image.shape)
    image[ROWS[1] + 3:ROWS[1] + 3 + side, 80:80 + side] = np.array(BED) + brighter
    return measure(capture_of(np.rint(image).astype(np.uint8), LATER), PATH, DOWN,
                   ThicknessConfig())


def test_a_pixel_that_is_brighter_by_noise_hides_nothing() -> None:
    # 1 grey level of noise in each of three colours makes a sigma of 0.6 in brightness.
    profile = bright_spot(1, 4.5)
    assert (profile.status == Status.MEASURED).all()
    np.testing.assert_allclose(profile.thickness, WIDTH_TRUE, atol=0.3 * PIXEL)


def test_a_spot_that_is_little_brighter_is_bed() -> None:
    # 5 grey levels are no noise, but little beside the 106 between ink and bed.
    assert (bright_spot(3, 5.0).status == Status.MEASURED).all()


@pytest.mark.parametrize(('side', 'brighter'), [(1, 45.0), (3, 25.0)], ids=['bright', 'large'])
def test_beside_glare_nothing_is_told(side: int, brighter: float) -> None:
    assert (bright_spot(side, brighter).status == Status.LOW_CONFIDENCE).any()


def test_a_mottled_bed_is_no_glare() -> None:
    rng = np.random.default_rng(3)
    mottle = cv2.GaussianBlur(rng.normal(0, 1, bed().shape[:2]), (0, 0), 4)
    image = band_image() + (5 * mottle / mottle.std())[..., None] + rng.normal(0, 1, bed().shape)
    profile = measure(capture_of(np.clip(np.rint(image), 0, 255).astype(np.uint8), LATER), PATH,
                      DOWN, ThicknessConfig())
    assert (profile.status == Status.MEASURED).mean() >= 0.99
    assert np.nanmax(np.abs(profile.thickness - WIDTH_TRUE)) < 0.3 * PIXEL


def strands(rows: Array, width: float, ink: tuple[int, int, int] = INK) -> NDArray[np.uint8]:
    """The bed with strands along these rows, of a width [pixels], through lens and sensor."""
    fine = 8  # parts of a pixel
    row = (np.arange(120 * fine) + 0.5) / fine - 0.5
    inked = (np.abs(row[:, None] - rows) < width / 2).any(axis=1).astype(float)
    blurred = cv2.GaussianBlur(inked[:, None], (1, 0), sigmaX=1, sigmaY=0.8 * fine)
    share = blurred.reshape(120, fine).mean(axis=1)[:, None, None]
    image = np.array(BED) * (1 - share) + np.array(ink) * share
    return noisy(np.broadcast_to(image, bed().shape))


def to_and_fro(rows: Array) -> DepositionPath:
    """A path of strokes along these rows, with travel between them."""
    count = 2 * len(rows)
    ends = np.where((np.arange(count) + 1) // 2 % 2 == 0, START_U, END_U)
    corners = np.column_stack((ends, np.repeat(rows, 2)))
    legs = [np.linspace(start, end, 81)[1:] for start, end in pairwise(corners)]
    on = np.repeat(np.arange(len(legs)) % 2 == 0, 80)
    return path_through(surface(np.concatenate(legs)), extruding=on)


@pytest.mark.parametrize('brighter', [1.3, 2.0, 3.0])
@pytest.mark.parametrize('ink', [INK, (250, 250, 250)], ids=['dark', 'bright'])
def test_beside_what_is_overexposed_nothing_is_told(brighter: float,
                                                    ink: tuple[int, int, int]) -> None:
    image = strands(np.array((MIDDLE,)), 11, ink)
    image = np.clip(image * brighter, 0, 255).astype(np.uint8)
    profile = measure(capture_of(image, LATER), PATH, DOWN, ThicknessConfig())
    assert (profile.status == Status.LOW_CONFIDENCE).all()


def test_a_channel_that_is_overexposed_is_left_out() -> None:
    image = strands(np.array((MIDDLE,)), 11).astype(float)
    image[..., 0] = np.clip(image[..., 0] * 2, 0, 255)
    profile = measure(capture_of(image.astype(np.uint8), LATER), PATH, DOWN, ThicknessConfig())
    assert (profile.status == Status.MEASURED).mean() > 0.95
    assert np.nanmax(np.abs(profile.thickness - WIDTH_TRUE)) < 0.5 * PIXEL
    assert abs(np.nanmean(profile.thickness) - WIDTH_TRUE) < 0.15 * PIXEL


@pytest.mark.parametrize('between', [2.5, 3.0, 4.0])
@pytest.mark.parametrize('ink', [INK, (250, 250, 250)], ids=['dark', 'bright'])
def test_a_few_pixels_of_bed_between_strands_are_enough(between: float,
                                                        ink: tuple[int, int, int]) -> None:
    """Through a lens that blurs them: no level is read on the strand next to them."""
    width = 7.0
    rows = MIDDLE + (np.arange(5) - 2) * (width + between)
    profile = measure(capture_of(strands(rows, width, ink), LATER), to_and_fro(rows), DOWN,
                      ThicknessConfig())
    inner = (profile.stroke > 1) & (profile.stroke < 5)
    inner &= np.abs(profile.points[:, 0]) < (END_U - START_U - 10) / 2 * PIXEL
    assert (profile.status[inner] == Status.MEASURED).mean() >= 0.98
    error = profile.thickness[inner] - width * PIXEL
    assert np.nanmax(np.abs(error)) < 0.6 * PIXEL
    # Blur from both strands darkens the bed, or brightens it: by 0.25 pixels at 2.5.
    assert abs(np.nanmean(error)) < 0.3 * PIXEL


@pytest.mark.parametrize('between_rows', [0.0, 0.25, 0.5])
@pytest.mark.parametrize('width', [4.5, 5.0, 5.5, 6.0])
def test_a_bead_a_few_pixels_wide_that_keeps_to_their_rows(width: float,
                                                           between_rows: float) -> None:
    """All along, both edges lie at one place between two rows: no mean cancels what that does."""
    rows = np.array((MIDDLE + between_rows,))
    profile = measure(capture_of(strands(rows, width), LATER), to_and_fro(rows), DOWN,
                      ThicknessConfig())
    assert (profile.status == Status.MEASURED).mean() > 0.95
    assert abs(np.nanmean(profile.thickness) - width * PIXEL) < 0.1 * PIXEL


@pytest.mark.parametrize('ink', [INK, (250, 250, 250)], ids=['dark', 'bright'])
def test_between_strands_of_another_print_there_is_no_gap(ink: tuple[int, int, int]) -> None:
    """Their ink is where bed is to be expected, and a strand between them is no bed."""
    rows = np.array((15.0, 55.0, 95.0))
    image = strands(np.append(rows, (39.0, 71.0)), 11, ink)
    profile = measure(capture_of(image, LATER), to_and_fro(rows), DOWN, ThicknessConfig())
    assert (profile.status[profile.stroke == 2] != Status.GAP).all()
    for alone in (1, 3):
        assert (profile.status[profile.stroke == alone] == Status.MEASURED).mean() > 0.95


@pytest.mark.parametrize('image', [band_image(), noisy(bed())], ids=['ink', 'bed'])
def test_what_stands_in_front_occludes(measured: Measure, image: NDArray[np.uint8]) -> None:
    image = image.copy()
    image[:80, 78:83] = 90
    capture = capture_of(image, LATER)
    capture.cloud[:80, 78:83, 2] -= 0.03
    profile = measured(capture)
    u = columns(PATH)
    assert (profile.status[(u >= 78) & (u <= 82)] == Status.OCCLUDED).all()
    assert_only_measured_and_gap_have_numbers(profile)
    # A wrong number is worse than none: beside it either the truth or nothing.
    numbers = profile.thickness[profile.status == Status.MEASURED]
    np.testing.assert_allclose(numbers, WIDTH_TRUE, atol=1.01 * PIXEL)


def test_the_published_method_measures_nothing_while_something_stands_among_the_print() -> None:
    # Its outline joins the print's, and then any width may be wrong.
    capture = capture_of(band_image(), LATER)
    capture.cloud[:80, 78:83, 2] -= 0.03
    profile = measure(capture, PATH, DOWN, PAPER)
    assert set(profile.status) == {Status.OCCLUDED, Status.LOW_CONFIDENCE}


def test_where_the_nozzle_was_lifted_there_is_no_sample(measured: Measure) -> None:
    lifted = PATH.points.copy()
    lifted[:20, 2] = 0.05
    profile = measured(capture_of(band_image(), LATER), replace(PATH, points=lifted))
    assert 60 <= len(profile) <= 61
    np.testing.assert_array_equal(profile.points, lifted[-len(profile):])
    for values in (profile.thickness, profile.left_points, profile.extruding, profile.status,
                   profile.extruder_known, profile.stroke):
        assert len(values) == len(profile)


def layers_of_path(count: int, height: float, known: bool = True) -> DepositionPath:
    """A stroke to and fro, each time higher by a layer [m], and a purge high above at the end."""
    there = np.linspace(0.0, 0.03, 31)
    x = np.concatenate([there if number % 2 == 0 else there[::-1] for number in range(count)])
    z = np.repeat(1e-3 + height * np.arange(count), len(there))
    points = np.column_stack((x, np.zeros(len(x)), z))
    purge = points[-31:] + np.array((0.0, 0.0, 0.05))
    path = path_through(np.concatenate((points, purge)))
    return replace(path, extruder_known=np.full(len(path), known))


def test_ink_is_laid_on_ink_as_high_as_it_gets() -> None:
    """A wall of 40 layers: the nozzle is 17 mm above the bed, and never far above ink."""
    path = layers_of_path(40, 0.4e-3)
    low = on_bed(path, Plane(np.array((0.0, 0.0, 1.0)), 0.0), 5e-3)
    # Between two layers the path may rise too steeply to lay anything.
    assert low[:40 * 31].mean() > 0.9
    assert not low[40 * 31:].any()


def test_who_does_not_know_of_the_extruder_knows_of_no_ink_to_lay_on() -> None:
    low = on_bed(layers_of_path(40, 0.4e-3, known=False), Plane(np.array((0.0, 0.0, 1.0)), 0.0),
                 5e-3)
    assert low[:10 * 31].mean() > 0.9
    assert not low[11 * 31:].any()


def test_only_what_was_laid_before_the_capture_is_measured(measured: Measure) -> None:
    # A point each 0.2 mm at 10 mm/s: 0.02 s.
    profile = measured(capture_of(band_image(), START_NS + 1_005_000_000))
    assert len(profile) == 51
    np.testing.assert_array_equal(profile.time, PATH.time[:51])


@pytest.mark.parametrize('method', METHODS)
def test_a_profile_tells_where_it_comes_from(method: str) -> None:
    path = replace(PATH, extruding=np.arange(81) % 2 == 0)
    profile = measure(capture_of(band_image(), LATER), path, DOWN,
                      ThicknessConfig(method=method), number=5)
    assert (profile.stamp_ns, profile.print_id, profile.print_start_ns, profile.capture,
            profile.method) == (LATER, 'print', START_NS, 5, method)
    np.testing.assert_array_equal(profile.arc_length, PATH.arc_length)
    np.testing.assert_array_equal(profile.extruding, path.extruding)
    np.testing.assert_array_equal(profile.extruder_known, path.extruder_known)
    assert profile.stroke.tolist() == [1] * 81  # what is so short is no travel
    assert profile.processing_time > 0


@pytest.mark.parametrize('stamp_ns', [START_NS - 1, START_NS])
def test_fewer_than_two_points_are_refused(measured: Measure, stamp_ns: int) -> None:
    with pytest.raises(MeasurementError, match=r'^path: expected 2 points or more .*found [01]; '):
        measured(capture_of(band_image(), stamp_ns))


@pytest.mark.parametrize('points', [surface(np.linspace((400, 10), (500, 10), 20)),
                                    np.linspace((0, 0, 0.7), (0.01, 0, 0.7), 20)],
                         ids=['beside the image', 'behind the camera'])
def test_a_path_that_the_camera_does_not_see_is_refused(measured: Measure,
                                                        points: Array) -> None:
    with pytest.raises(MeasurementError, match=r'^cloud: expected points around the path'):
        measured(capture_of(band_image(), LATER), path_through(points))


def test_a_capture_without_any_depth_is_refused(measured: Measure) -> None:
    capture = capture_of(band_image(), LATER)
    capture.cloud[:] = np.nan
    with pytest.raises(MeasurementError, match=r'^cloud: expected '):
        measured(capture)


@pytest.mark.parametrize('focal', [0.95, 1.05, 1.2, 2.0])
def test_a_focal_length_that_contradicts_the_cloud_is_refused(focal: float) -> None:
    capture = capture_of(band_image(), LATER)
    K = capture.camera.K * np.array(((focal, 1, 1), (1, focal, 1), (1, 1, 1)))
    with pytest.raises(MeasurementError, match=r'^camera_info: expected intrinsics that put the '
                                               'cloud onto its own pixels, found it'):
        measure(replace(capture, camera=replace(capture.camera, K=K)), PATH, DOWN,
                ThicknessConfig())


@pytest.mark.parametrize('change', [
    lambda cloud: cloud[::-1], lambda cloud: cloud[:, ::-1],
    lambda cloud: np.roll(cloud, 6, axis=1)], ids=['rows', 'columns', 'shifted'])
def test_a_cloud_in_another_order_is_refused(
        change: Callable[[NDArray[np.float32]], NDArray[np.float32]]) -> None:
    capture = capture_of(band_image(), LATER)
    with pytest.raises(MeasurementError, match=r'^camera_info: expected '):
        measure(replace(capture, cloud=change(capture.cloud)), PATH, DOWN, ThicknessConfig())


def test_a_cut_is_at_right_angles_to_a_slanted_strand(measured: Measure) -> None:
    # A strand at 45 degrees, 20 rows high: 20 / sqrt(2) pixels wide.
    v, u = np.mgrid[0:120, 0:160]
    image = bed()
    image[(np.abs((v - 60) - (u - 80)) <= 10) & (np.abs(u - 80) < 45)] = INK
    path = pixel_path((60, 40), (100, 80), 41)
    profile = measured(capture_of(image, LATER), path)
    assert (profile.status == Status.MEASURED).all()
    np.testing.assert_allclose(profile.thickness, 21 / np.sqrt(2) * PIXEL, atol=1.01 * PIXEL)


@pytest.mark.parametrize('seed', range(4))
def test_whatever_comes_is_measured_or_refused(seed: int) -> None:
    """Images, clouds and paths of all kinds give a profile or the documented error."""
    rng = np.random.default_rng(seed)
    for _ in range(40):
        image = bed()
        height, width = image.shape[:2]
        image[height // 3:height // 2] = rng.choice((40, 200, 255))
        image = np.clip(image + rng.normal(0, rng.choice((0, 5, 60)), image.shape), 0, 255)
        capture = capture_of(image.astype(np.uint8), START_NS)
        capture.cloud[rng.random((height, width)) < rng.choice((0, 0.5, 0.99, 1))] = np.nan
        capture.cloud[rng.integers(height):, :, 2] -= rng.choice((0, 0.001, 0.05))
        count = int(rng.choice((0, 1, 2, 3, 5, 50)))
        points = np.zeros((count, 3))
        points[:, 0] = np.linspace(-1, 1, count) * width * 5e-5 * rng.choice((0, 0.01, 1, 5))
        points += rng.normal(0, rng.choice((0, 1e-3, 0.1)), points.shape)
        points[count // 2:] = points[:count - count // 2][::-1]
        unknown = np.full(count, np.nan)
        path = DepositionPath('any', 0, 1e3, True, np.arange(count) * 0.1,
                              np.arange(count) * 1e-4, points, unknown, unknown,
                              rng.random(count) < 0.5, rng.random(count) < 0.5)
        for method in ('cross_section', 'paper'):
            try:
                profile = measure(capture, path, DOWN, ThicknessConfig(method=method))
            except MeasurementError:
                continue
            known = np.isfinite(profile.thickness)
            assert (known == np.isin(profile.status, (Status.MEASURED, Status.GAP))).all()


def test_a_method_that_knows_one_layer_refuses_a_second() -> None:
    expect_method_for_layers(np.array((-1, 0, 0)), 'paper')
    expect_method_for_layers(np.array((0, 1)), 'cross_section')
    with pytest.raises(MeasurementError, match='expected cross_section for a print in layers'):
        expect_method_for_layers(np.array((0, 1)), 'paper')


@pytest.mark.parametrize('colour_space', COLOUR_SPACES)
def test_an_edge_lies_where_half_of_the_light_is_reached(colour_space: str) -> None:
    """Dark ink on a bright bed, behind a lens that blurs; coded for a screen it looks narrower."""
    light = np.full(bed().shape, 0.8)
    light[50:61, 30:131] = 0.03
    light = cv2.GaussianBlur(light, (0, 0), 1.2)
    coded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light**(1 / 2.4) - 0.055)
    image = np.rint(255 * (coded if colour_space == SRGB else light)).astype(np.uint8)
    widths = {space: np.nanmedian(measure(capture_of(image, LATER), PATH, DOWN, ThicknessConfig(
        cross_section=CrossSectionConfig(color_space=space))).thickness) / PIXEL
        for space in COLOUR_SPACES}
    assert widths[colour_space] == pytest.approx(11.0, abs=0.1)
    if colour_space == SRGB:
        assert widths[LINEAR] < 10.7
