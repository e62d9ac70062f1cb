"""Beads of any size, sharp corners, short gaps; and why something has no answer."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_sim.ink.curves import Curve, turtle
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.scene.imaging import expose, Imaging, mix
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.scene.raster import coverage
from bpc_sim.stress.catalogue import STRESS
from bpc_sim.stress.stress_scene import NOZZLE_SPEED_M_PER_S, STAMP_NS

pytestmark = [pytest.mark.accuracy, pytest.mark.timeout(120)]
MM = 1e-3  # [m]
PIXEL, IMAGE_SIZE_PX = 0.2 * MM, 512
LENGTH, SPACING = 60 * MM, 0.2 * MM
INK, BED = (40.0, 80.0, 170.0), (205.0, 205.0, 200.0)
CURVE = turtle(((LENGTH / 3, 0), (LENGTH / 3, 0.5), (LENGTH / 3, 0)), (-LENGTH / 2, -2 * MM), 0.1)
NO_GAPS = np.empty((0, 2))
FINE_PIXEL = 0.1 * MM
WITHOUT_ANSWER = Status.NO_DATA, Status.LOW_CONFIDENCE


@cache
def covered_by(width: float) -> Array:
    """Return the fraction (H, W) of each pixel that a bead of a width [m] covers."""
    deposit = Deposit(CURVE, constant_width(width), NO_GAPS)
    return coverage(lambda points: deposit.locate(points).margin, IMAGE_SIZE_PX, PIXEL)


def photo(width: float, noise: float = 4.0, exposure: float = 1.0) -> tuple[Capture, Array]:
    """Return a capture from straight above of a bead of a width [m], and its pose (4, 4).

    Its noise is in grey levels; the exposure is a factor on all light.
    """
    covered = covered_by(width)
    image = expose(exposure * mix(INK, BED, covered), covered, Imaging(blur=0.8, noise=noise),
                   np.random.default_rng(0))
    return planar_capture(image, PIXEL, STAMP_NS)


def path(share: float = 1.0, flow_rate: float = np.nan, curve: Curve = CURVE) -> DepositionPath:
    """Return the first share of the path along a curve, with a flow rate [m^3/s]."""
    s = np.linspace(0, curve.length, round(curve.length / SPACING) + 1)
    s = s[:round(share * len(s))]
    points = np.column_stack((curve.points(s), np.zeros(len(s))))
    yes = np.ones(len(s), bool)
    return DepositionPath('print', 0, STAMP_NS * 1e-9, True, s / NOZZLE_SPEED_M_PER_S, s, points,
                          np.full(len(s), np.nan), np.full(len(s), flow_rate), yes, yes)


def measured(width: float, noise: float = 4.0, exposure: float = 1.0) -> ThicknessProfile:
    """Measure a bead of a width [m]."""
    capture, pose = photo(width, noise, exposure)
    return measure(capture, path(), pose, ThicknessConfig())


@pytest.mark.parametrize('width', [1 * MM, 4 * MM, 6 * MM, 9 * MM, 12 * MM])
def test_a_bead_wider_than_the_reach_is_measured(width: float) -> None:
    profile = measured(width)
    known = profile.status == Status.MEASURED
    assert known.mean() > 0.98
    assert np.abs(profile.thickness[known] - width).mean() < 0.02 * MM


def test_a_print_that_grows_is_looked_at_farther_only_once() -> None:
    """Later captures begin with the reach that was found."""
    (capture, pose), memory = photo(9 * MM), PrintMemory()
    measure(capture, path(0.6), pose, ThicknessConfig(), memory=memory)
    assert memory.reach.length == 2 * ThicknessConfig().cross_section.reach
    found = memory.reach
    later = measure(capture, path(), pose, ThicknessConfig(), memory=memory)
    assert memory.reach is found
    assert (later.status == Status.MEASURED).mean() > 0.98


def test_a_bead_of_three_pixels_is_refused_with_the_reason() -> None:
    profile = measured(3 * PIXEL)
    assert not (profile.status == Status.MEASURED).any()
    assert np.mean(profile.cause == Cause.FEW_PIXELS) > 0.95


@pytest.mark.parametrize(('width', 'flow_rate'), [
    (14 * MM, 1.0 * MM**2 * NOZZLE_SPEED_M_PER_S),  # for a bead of 1 mm^2
    (25 * MM, np.nan)])
def test_a_plate_below_ink_that_is_not_seen_is_no_bead(width: float, flow_rate: float) -> None:
    capture, pose = photo(width)
    profile = measure(capture, path(flow_rate=flow_rate), pose, ThicknessConfig())
    assert not (profile.status == Status.MEASURED).any()


@pytest.mark.parametrize(('noise', 'exposure', 'cause'), [
    (140.0, 1.0, Cause.LOW_CONTRAST), (4.0, 4.0, Cause.OVEREXPOSED)])
def test_what_to_change_is_told(noise: float, exposure: float, cause: Cause) -> None:
    profile = measured(2 * MM, noise, exposure)
    assert np.mean(profile.cause == cause) > 0.9


def test_beyond_the_border_of_the_image_is_told_so() -> None:
    capture, pose = photo(2 * MM)
    whole = path()
    beyond = replace(whole, points=whole.points + np.array((40 * MM, 0, 0)))
    profile = measure(capture, beyond, pose, ThicknessConfig())
    far = beyond.points[:, 0] > IMAGE_SIZE_PX / 2 * PIXEL
    assert (profile.status[far] == Status.NO_DATA).all()
    assert (profile.cause[far] == Cause.OUTSIDE_IMAGE).all()


@pytest.mark.parametrize('method', ['cross_section', 'paper'])
@pytest.mark.parametrize('name', STRESS)
def test_every_sample_without_an_answer_says_why(name: str, method: str) -> None:
    scene = STRESS[name](0)
    profile = measure(scene.capture, scene.path, scene.T_base_camera,
                      ThicknessConfig(method=method))
    without = np.isin(profile.status, WITHOUT_ANSWER)
    np.testing.assert_array_equal(without, profile.cause != Cause.NONE)


@pytest.mark.parametrize('turn', [30, 60, 90, 120, 135, 150, 165, 172])
def test_at_a_sharp_corner_no_width_is_that_of_the_other_leg(turn: int) -> None:
    """There a section across one leg meets the other: a width has no meaning, and is not told."""
    width, leg = 1.4 * MM, 15 * MM
    curve = turtle(((leg, 0), (0.01 * MM, np.radians(turn)), (leg, 0)), (-leg / 2, -leg / 3), 0.13)
    deposit = Deposit(curve, constant_width(width), NO_GAPS)
    covered = coverage(lambda points: deposit.locate(points).margin, 400, FINE_PIXEL)
    image = expose(mix(INK, BED, covered), covered, Imaging(blur=0.8, noise=4.0),
                   np.random.default_rng(0))
    capture, pose = planar_capture(image, FINE_PIXEL, STAMP_NS)
    profile = measure(capture, path(curve=curve), pose, ThicknessConfig())
    known = profile.status == Status.MEASURED
    assert np.abs(profile.thickness[known] - width).max() < 0.15 * MM
    # Where the legs are apart by more than their beads, they are measured.
    apart = width / 2 * np.tan(np.radians(turn) / 2) + 2 * width
    assert known[np.abs(profile.arc_length - leg) > apart][1:-1].mean() > 0.95


@pytest.mark.parametrize('texture', [0.0, 8.0, 16.0])
def test_a_gap_between_round_ends_is_a_gap_where_its_bed_is_bare(texture: float) -> None:
    """Of 4 mm between strokes the ends of a bead of 1.6 mm leave 2.4: one and a half widths."""
    width, length, start, end = 1.6 * MM, 30 * MM, 13 * MM, 17 * MM
    curve = turtle(((length, 0),), (-length / 2, 0.3 * MM), 0.07)
    deposit = Deposit(curve, constant_width(width), np.array(((start, end),)))
    ends = curve.points(np.array((start, end)))

    def margin(points: Array) -> Array:
        round_ends = [np.hypot(points[..., 0] - x, points[..., 1] - y) - width / 2
                      for x, y in ends]
        return np.minimum.reduce([deposit.locate(points).margin, *round_ends])

    covered = coverage(margin, 400, FINE_PIXEL)
    rng = np.random.default_rng(0)
    grain = cv2.GaussianBlur(rng.normal(size=covered.shape), (0, 0), 3)
    light = mix(INK, BED, covered) + (texture * grain / grain.std() * (1 - covered))[..., None]
    capture, pose = planar_capture(
        expose(light, covered, Imaging(blur=0.8, noise=4.0), rng), FINE_PIXEL, STAMP_NS)
    profile = measure(capture, path(curve=curve), pose, ThicknessConfig())
    s = profile.arc_length
    bare = (s > start + width / 2 + 0.3 * MM) & (s < end - width / 2 - 0.3 * MM)
    assert bare.sum() > 8
    assert (profile.status[bare] == Status.GAP).mean() > 0.9
    assert not (profile.status[(s < start) | (s > end)] == Status.GAP).any()
