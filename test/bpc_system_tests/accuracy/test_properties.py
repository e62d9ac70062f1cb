"""Changes that must not change a thickness: place, colours and direction of the print, and more.

The print is about 1.5 mm wide, bends and has a gap. It is drawn without noise, so that only the
error of the method itself remains.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

from hypothesis import assume, example, given, settings, strategies as st
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import transform
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.parameter import parameters_of
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.ink.curves import turtle
from bpc_sim.ink.deposit import Deposit
from bpc_sim.scene.imaging import Colour, expose, Imaging, mix
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.scene.raster import coverage
from bpc_sim.stress.stress_scene import NOZZLE_SPEED_M_PER_S, STAMP_NS

METHODS = parameters_of(ThicknessConfig)['method'][0].choices
MM = 1e-3  # [m]
IMAGE_SIZE_PX = 200
PIXEL = 0.1 * MM
INK, BED = (40.0, 80.0, 170.0), (205.0, 205.0, 200.0)
BLUR_PX = 0.8
LENGTH = 15 * MM
GAP = (9 * MM, 11 * MM)
# By how much widths may differ. The published method's edges are whole pixels, each at most half
# a pixel off: two widths differ by at most two pixels, which is the root of 12 times their sigma.
MAX_SIGMAS = {'cross_section': 3.0, 'paper': 12**0.5}
END_POINTS = 1.5  # path points next to a start or end of ink where statuses may differ

few = settings(max_examples=20)
colours = st.tuples(*[st.integers(20, 230).map(float)] * 3)


@dataclass(frozen=True)
class Print:
    """A print and its picture; the base frame is the surface frame.

    Attributes:
        start: start of the path (x, y) [m].
        heading: direction of the path there [rad].
        turn: turn of the whole path, positive to the left [rad].
        ink, bed: colours, RGB, 0..255.
        spacing: distance of the path's samples [m].
    """

    start: tuple[float, float] = (-6 * MM, -2 * MM)
    heading: float = -0.3
    turn: float = 1.2
    ink: Colour = INK
    bed: Colour = BED
    spacing: float = 0.2 * MM

    @property
    def deposit(self) -> Deposit:
        """The ink."""
        curve = turtle(((LENGTH / 3, 0), (LENGTH / 3, self.turn), (LENGTH / 3, 0)), self.start,
                       self.heading)
        return Deposit(curve, width, np.array((GAP,)))

    def capture(self) -> tuple[Capture, Array]:
        """Return the capture of a camera straight above, and its pose (4, 4)."""
        covered = covered_by(replace(self, ink=INK, bed=BED, spacing=0.0))
        image = expose(mix(self.ink, self.bed, covered), covered, Imaging(blur=BLUR_PX),
                       np.random.default_rng(0))
        return planar_capture(image, PIXEL, STAMP_NS)

    def path(self) -> DepositionPath:
        """Return the path as a recorder gives it."""
        s = np.linspace(0, LENGTH, round(LENGTH / self.spacing) + 1)
        points = np.column_stack((self.deposit.curve.points(s), np.zeros(len(s))))
        return path_of(points, s)

    def measured(self, method: str) -> ThicknessProfile:
        """Measure the print by a method."""
        capture, T_base_camera = self.capture()
        return measure(capture, self.path(), T_base_camera, ThicknessConfig(method=method))


def width(s: Array) -> Array:
    """Return the true width (N,) at arc lengths s (N,) [m]."""
    return (1.5 + 0.3 * np.sin(2 * np.pi * s / LENGTH)) * MM


@cache
def covered_by(drawn: Print) -> Array:
    """Return the fraction (H, W) of each pixel that ink covers."""
    deposit = drawn.deposit
    return coverage(lambda points: deposit.locate(points).margin, IMAGE_SIZE_PX, PIXEL)


def path_of(points: Array, s: Array) -> DepositionPath:
    """Return a path through points (N, 3) at arc lengths s (N,) [m]."""
    unknown = np.full(len(s), np.nan)
    return DepositionPath('print', 0, STAMP_NS * 1e-9, True, s / NOZZLE_SPEED_M_PER_S, s, points,
                          unknown, unknown, np.ones(len(s), bool), np.ones(len(s), bool))


def assert_same(one: ThicknessProfile, other: ThicknessProfile, scale: float = 1.0) -> None:
    """Assert that a profile is ``scale`` times another within sigma, and as complete."""
    inner = away_from_ends(one)
    np.testing.assert_array_equal(one.status[inner], other.status[inner])
    both = compared(one) & compared(other)
    assert both.mean() > 0.75
    off = np.abs(other.thickness / scale - one.thickness)[both]
    assert (off <= MAX_SIGMAS[one.method] * np.hypot(one.sigma, other.sigma / scale)[both]).all()


def away_from_ends(profile: ThicknessProfile) -> Flags:
    """Return which samples (N,) do not lie where the ink starts or ends."""
    s = profile.arc_length * (LENGTH / profile.arc_length[-1])
    borders = np.abs(s[:, None] - np.array((0, *GAP, LENGTH))).min(axis=1)
    return np.asarray(borders > END_POINTS * max(s[1] - s[0], PIXEL))


def compared(profile: ThicknessProfile) -> Flags:
    """Return which samples (N,) must have a thickness.

    The published method takes the nearest part of the outline, which at an end is the end itself.
    """
    measured: Flags = profile.status == Status.MEASURED
    return measured & away_from_ends(profile) if profile.method == 'paper' else measured


@pytest.fixture(params=METHODS)
def method(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def plain(method: str) -> ThicknessProfile:
    """The profile of the unchanged print."""
    return Print().measured(method)


def test_the_print_itself_is_measured(plain: ThicknessProfile) -> None:
    measured = compared(plain)
    assert measured.mean() > 0.75
    assert (plain.status == Status.GAP).mean() > 0.1
    off = np.abs(plain.thickness - width(plain.arc_length))[measured]
    assert (off <= MAX_SIGMAS[plain.method] * plain.sigma[measured]).all()


@pytest.mark.parametrize('method', METHODS)
@few
@given(x=st.floats(-1, 1), y=st.floats(-1, 1), angle=st.floats(-np.pi, np.pi))
def test_a_print_that_lies_elsewhere(method: str, x: float, y: float, angle: float) -> None:
    cos, sin = np.cos(angle), np.sin(angle)
    start = np.array(((cos, -sin), (sin, cos))) @ Print().start + np.array((x, y)) * MM
    moved = Print(start=(float(start[0]), float(start[1])), heading=Print().heading + angle)
    assert_same(Print().measured(method), moved.measured(method))


@pytest.mark.parametrize('method', METHODS)
@few
@given(shift=st.tuples(*[st.floats(-1, 1)] * 3), turn=st.tuples(*[st.floats(-2, 2)] * 3))
def test_a_base_frame_that_lies_elsewhere(method: str, shift: tuple[float, ...],
                                          turn: tuple[float, ...]) -> None:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    T[:3, 3] = shift
    capture, T_base_camera = Print().capture()
    path = Print().path()
    moved = measure(capture, replace(path, points=transform(T, path.points)), T @ T_base_camera,
                    ThicknessConfig(method=method))
    assert_same(Print().measured(method), moved)


@pytest.mark.parametrize('method', METHODS)
@few
@given(ink=colours, bed=colours)
@example(ink=(0.0, 0.0, 0.0), bed=(245.0, 245.0, 245.0))  # brighter would be overexposed
@example(ink=(180.0, 60.0, 60.0), bed=(60.0, 121.0, 60.0))
def test_colours_that_are_swapped(method: str, ink: Colour, bed: Colour) -> None:
    assume(np.abs(np.subtract(ink, bed)).max() >= 80)  # for the published method's thresholds
    one, other = Print(ink=ink, bed=bed), Print(ink=bed, bed=ink)
    assert_same(one.measured(method), other.measured(method))


def test_a_path_that_is_reversed(method: str, plain: ThicknessProfile) -> None:
    capture, T_base_camera = Print().capture()
    path = Print().path()
    back = measure(capture, path_of(path.points[::-1], path.arc_length), T_base_camera,
                   ThicknessConfig(method=method))
    assert_same(plain, replace(back, status=back.status[::-1], thickness=back.thickness[::-1],
                               sigma=back.sigma[::-1]))
    both = np.isfinite(plain.left) & np.isfinite(back.left[::-1])
    assert np.abs(plain.left - back.right[::-1])[both].max() <= PIXEL


def test_a_print_in_the_mirror(method: str, plain: ThicknessProfile) -> None:
    capture, T_base_camera = Print().capture()
    path = Print().path()
    flipped = replace(capture, image=np.ascontiguousarray(capture.image[:, ::-1]))
    mirrored = measure(flipped, replace(path, points=path.points * (-1, 1, 1)), T_base_camera,
                       ThicknessConfig(method=method))
    assert_same(plain, mirrored)
    both = np.isfinite(plain.left) & np.isfinite(mirrored.left)
    assert np.abs(plain.left - mirrored.right)[both].max() <= PIXEL


@pytest.mark.parametrize('method', METHODS)
@few
@given(spacing=st.floats(0.03, 0.4))
def test_a_path_that_is_sampled_otherwise(method: str, spacing: float) -> None:
    usual, other = Print().measured(method), Print(spacing=spacing * MM).measured(method)
    nearest = np.abs(other.arc_length[:, None] - usual.arc_length).argmin(axis=0)
    # The nearest sample is at another place, where the width differs.
    there = width(usual.arc_length) / width(other.arc_length[nearest])
    assert_same(usual, replace(
        usual, status=other.status[nearest], sigma=other.sigma[nearest],
        thickness=other.thickness[nearest] * there))


@pytest.mark.parametrize('method', METHODS)
@few
@given(scale=st.floats(0.5, 2))
def test_a_print_that_is_scaled(method: str, scale: float) -> None:
    capture, _ = Print().capture()
    scaled, T_base_camera = planar_capture(capture.image, scale * PIXEL, STAMP_NS)
    path = Print().path()
    assert_same(Print().measured(method),
                measure(scaled, path_of(scale * path.points, scale * path.arc_length),
                        T_base_camera, ThicknessConfig(method=method)), scale)
