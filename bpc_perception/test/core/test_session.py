"""Captures wait for path and poses, and are dealt with in order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from perception_builders import (
    at_ns,
    band_image,
    bed,
    capture_of,
    DOWN,
    PIXEL,
    pixel_path,
    pose,
    SECOND,
    START_NS,
)
import pytest

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig, ThicknessConfig
from bpc_perception.core.design.comparison import WantedDesign
from bpc_perception.core.design.design import Design, DesignStroke
from bpc_perception.core.geometry import transform
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.result import Result
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Session

ON_BASE = HandEye(True, DOWN)
T_FLANGE_CAMERA = pose((0.05, 0, 0.02), (90, 0, 0))
IN_HAND = HandEye(False, T_FLANGE_CAMERA)
CONFIG = ThicknessConfig(method='paper', patience=2.0,
                         advice=AdviceConfig(target_thickness=2.2e-3))
IMAGE = band_image()
NO_PRINT = ('path: expected a print, found none started; push ink out, or call '
            'path_recorder/start')


def path(complete_until: float, finished: bool = False, print_id: str = 'one',
         start: float = 0.0) -> DepositionPath:
    """A path over the band, which takes 1.6 s."""
    whole = pixel_path((40, 55), (120, 55), 81, print_id=print_id, start_ns=at_ns(start))
    return replace(whole.until(at_ns(start + complete_until)), complete_until=complete_until,
                   finished=finished)


def session(*stamps: float, hand_eye: HandEye = ON_BASE, image: Array | None = None) -> Session:
    """A session with captures of these stamps, received at time 0."""
    made = Session(CONFIG, hand_eye)
    for stamp in stamps:
        made.add_capture(capture_of(IMAGE if image is None else image, at_ns(stamp)))
    return made


def stamps(results: Sequence[Result]) -> list[float]:
    return [(result.capture.stamp_ns - START_NS) / SECOND for result in results]


def test_a_capture_is_measured_as_soon_as_the_path_covers_it() -> None:
    made = session(1.01)
    assert list(made.results()) == []
    made.set_path(path(1.0))
    assert list(made.results()) == []
    assert made.waiting == 1
    made.set_path(path(1.01))
    result, = made.results()
    assert result.profile is not None
    assert len(result.profile) == 51
    assert result.refusal == ''
    np.testing.assert_array_equal(result.T_base_camera, DOWN)
    assert made.waiting == 0
    assert list(made.results()) == []


def test_an_overexposed_picture_is_warned_of() -> None:
    words = []
    for image in (IMAGE, np.where(IMAGE == 205, 255, IMAGE).astype(np.uint8)):
        made = session(1.5, image=image)
        made.set_path(path(1.5))
        result, = made.results()
        words.append(result.warning)
    assert words[0] == ''
    assert 'overexposed' in words[1]


def test_a_calibration_that_may_be_of_another_camera_is_warned_of() -> None:
    for camera_frame, warned in (('camera', False), ('other_camera', True)):
        made = session(1.5, hand_eye=HandEye(True, DOWN, 'lbr_link_0', camera_frame))
        made.set_path(path(1.5))
        result, = made.results()
        assert result.profile is not None
        assert ('camera frame other_camera' in result.warning) == warned


def test_advice_comes_with_the_profile() -> None:
    made = session(1.5)
    made.set_path(path(1.5))
    result, = made.results()
    assert result.advice is not None
    assert result.advice.valid
    assert result.advice.measured_thickness == pytest.approx(2.2e-3, abs=1.01 * PIXEL)


def test_no_advice_towards_the_settings_where_a_design_with_widths_is_not_found() -> None:
    """2.2 mm of the settings are not what is wanted of a bead that is to be 0.4 mm wide."""
    other = np.array(((0, 0, 0), (2e-3, 0, 0), (2e-3, 2e-3, 0)))
    design = Design((DesignStroke(other, np.array((0.4e-3, 0.4e-3))),))
    made = Session(CONFIG, ON_BASE, design=WantedDesign('vase.csv', design))
    made.add_capture(capture_of(IMAGE, at_ns(1.5)))
    made.set_path(path(1.5))
    result, = made.results()
    assert result.design is not None
    assert result.design.findings.registration.refusal
    assert result.advice is not None
    assert (result.advice.valid, result.advice.reason) == (False, Reason.NO_TARGET)


def test_captures_are_measured_in_the_order_in_which_they_came() -> None:
    made = session(0.5, 1.5, 1.0)
    made.set_path(path(1.2))
    assert stamps(list(made.results())) == [0.5]
    made.set_path(path(1.5))
    assert stamps(list(made.results())) == [1.5, 1.0]


def test_of_captures_that_are_ready_the_newest_is_measured_live() -> None:
    made = session(0.5, 1.0, 1.2, 1.5)
    made.set_path(path(1.21))
    assert made.skip_overtaken() == 2
    assert stamps(list(made.results())) == [1.2]
    made.set_path(path(1.5))
    assert made.skip_overtaken() == 0
    assert stamps(list(made.results())) == [1.5]


def test_live_only_so_many_captures_wait_for_the_path() -> None:
    made = session(*np.arange(1, 11))
    assert made.skip_overtaken() == 10 - Session.MAXIMUM_WAITING
    assert stamps(list(made.results(finish=True))) == [7, 8, 9, 10]


def test_a_finished_path_lets_later_captures_through() -> None:
    made = session(1.0, 50.0)
    made.set_path(path(1.6, finished=True))
    assert stamps(list(made.results())) == [1.0, 50.0]


def test_after_its_patience_a_capture_is_measured_with_the_path_there_is() -> None:
    made = session(1.0)
    made.set_path(path(0.6))
    assert list(made.results(now_ns=2 * SECOND)) == []
    result, = made.results(now_ns=2 * SECOND + 1)
    assert result.profile is not None
    assert result.profile.time[-1] == pytest.approx(0.6, abs=0.021)


def test_without_a_print_a_capture_is_refused_after_its_patience() -> None:
    made = session(1.0)
    assert list(made.results(now_ns=SECOND)) == []
    result, = made.results(now_ns=3 * SECOND)
    assert result.profile is None
    assert result.advice is None
    assert result.refusal == NO_PRINT
    assert result.premature


def test_an_unnamed_path_is_no_print() -> None:
    made = session(1.0)
    made.set_path(path(1.6, print_id=''))
    assert [result.refusal for result in made.results()] == [
        NO_PRINT]


def test_at_the_end_all_captures_are_dealt_with() -> None:
    made = session(1.0, 2.0)
    made.set_path(path(0.6))
    assert stamps(list(made.results(finish=True))) == [1.0, 2.0]


@pytest.mark.parametrize(('stamp', 'premature'), [(-0.5, True), (-6.0, False)])
def test_a_capture_from_before_the_print_is_refused(stamp: float, premature: bool) -> None:
    """Shortly before it that is no fault."""
    made = session(stamp)
    made.set_path(path(1.6))
    result, = made.results()
    assert result.profile is None
    assert result.premature == premature
    assert result.refusal.startswith('path: expected a print begun before the capture, found one')


@pytest.mark.parametrize('again', [1.2, 1.4])  # twice, out of order
def test_a_capture_that_comes_late_or_twice_is_refused(again: float) -> None:
    made = session(1.0, 1.2, 1.4, again, 1.6)
    made.set_path(path(1.6))
    results = list(made.results())
    assert stamps(results) == [1.0, 1.2, 1.4, again, 1.6]
    assert [result.refusal for result in results if result.profile is None] == [
        'capture: expected a later stamp than the last, found it late or twice; let one camera '
        'alone publish, with a stamp for each capture']
    assert [result.profile.capture for result in results if result.profile] == [0, 1, 2, 3]


def test_two_prints_back_to_back_share_nothing() -> None:
    """The second print, on a new bed, is measured by itself."""
    made = session(1.4)
    made.set_path(path(1.6, finished=True))
    first, = made.results()
    made.set_path(path(1.5, print_id='two', start=20.0))
    made.add_capture(capture_of(IMAGE, at_ns(21.4)))
    second, = made.results()
    alone = session(21.4)
    alone.set_path(path(1.5, print_id='two', start=20.0))
    expected, = alone.results()
    assert first.profile is not None
    assert second.profile is not None
    assert expected.profile is not None
    assert (second.profile.print_id, second.profile.capture) == ('two', 0)
    np.testing.assert_array_equal(second.profile.thickness, expected.profile.thickness)
    assert repr(second.advice) == repr(expected.advice)


@pytest.mark.parametrize('method', ['paper', 'cross_section'])
@pytest.mark.parametrize('count', [0, 1])
def test_a_path_of_one_point_is_refused_and_the_next_measured(count: int, method: str) -> None:
    made = Session(replace(CONFIG, method=method), ON_BASE)
    whole = path(1.6, finished=True)
    made.set_path(whole.where(np.arange(len(whole)) < count))
    made.add_capture(capture_of(IMAGE, at_ns(1.6)))
    result, = made.results()
    assert result.refusal == (
        f'path: expected 2 points or more before the capture, found {count}; capture later')
    made.set_path(whole)
    made.add_capture(capture_of(IMAGE, at_ns(1.7)))
    result, = made.results()
    assert result.profile is not None


def test_what_cannot_be_measured_is_refused_with_the_reason() -> None:
    made = session(1.0)
    nothing = capture_of(IMAGE, at_ns(1.2))
    nothing.cloud[:] = np.nan
    made.add_capture(nothing)
    made.set_path(path(1.6))
    good, bad = made.results()
    assert good.profile is not None
    assert bad.profile is None
    assert not bad.premature
    assert bad.refusal.startswith('cloud: expected')


def test_a_capture_that_is_refused_takes_no_number() -> None:
    made = session(0.001, 1.0, 1.5)  # the first when hardly anything was laid
    made.set_path(path(1.6, finished=True))
    found = list(made.results())
    assert found[0].refusal.startswith('path: expected 2 points')
    assert [result.profile.capture for result in found if result.profile] == [0, 1]


def test_captures_are_numbered_within_their_print() -> None:
    made = session(1.0, 1.1)
    made.set_path(path(1.6, finished=True))
    numbers = [result.profile.capture for result in made.results() if result.profile]
    made.add_capture(capture_of(IMAGE, at_ns(11.0)))
    made.set_path(path(1.6, finished=True, print_id='two', start=10.0))
    numbers += [result.profile.capture for result in made.results() if result.profile]
    assert numbers == [0, 1, 0]


def test_settings_of_the_moment_count() -> None:
    made = session(1.0)
    made.config = replace(CONFIG, advice=AdviceConfig(target_thickness=9e-3))
    made.set_path(path(1.6))
    result, = made.results()
    assert result.advice is not None
    assert result.advice.target_thickness == 9e-3


def test_clear_forgets_captures_and_path() -> None:
    made = session(1.0)
    made.set_path(path(0.5))
    made.clear()
    assert list(made.results(finish=True)) == []
    made.add_capture(capture_of(IMAGE, at_ns(0.4)))
    result, = made.results(finish=True)
    assert result.refusal == NO_PRINT


# Camera in hand: the flange is where it has to be for the camera to look down at the bed.


def flange(T_base_camera: Array) -> Array:
    return T_base_camera @ np.linalg.inv(T_FLANGE_CAMERA)


def in_hand() -> Session:
    """A capture at 1.0 s, of a camera that turns and moves but is right there in between."""
    made = session(1.0, hand_eye=IN_HAND)
    made.set_path(path(1.6, finished=True))
    return made


def test_in_hand_the_flange_pose_is_interpolated_at_the_stamp() -> None:
    made = in_hand()
    # The camera turns about its own optical axis and glides along it: linear and slerp meet
    # the true pose half-way, when the flange moves about the camera.
    for time, side in ((0.96, -1.0), (1.04, 1.0), (1.12, 3.0)):
        turned = pose((0, 0, 0), (0, 0, 0))
        T_base_flange = flange(DOWN)
        turned[:3, :3] = pose(angles=(20 * side, 0, 0))[:3, :3]
        moved = T_base_flange.copy()
        moved[:3, :3] = turned[:3, :3] @ T_base_flange[:3, :3]
        moved[:3, 3] += side * np.array((0.01, -0.02, 0.005))
        assert made.add_flange_pose(at_ns(time), moved)
    result, = made.results()
    assert result.T_base_camera is not None
    np.testing.assert_allclose(result.T_base_camera, DOWN, atol=1e-12)
    assert result.profile is not None
    np.testing.assert_allclose(result.profile.thickness, 2.2e-3, atol=1.01 * PIXEL)


def test_in_hand_the_camera_pose_moves_with_the_flange() -> None:
    made = in_hand()
    T = pose((0.3, 0.1, 0.2), (30, 5, -10))
    made.set_path(replace(path(1.6, finished=True),
                          points=transform(T, path(1.6, finished=True).points)))
    for time in (0.99, 1.01):
        made.add_flange_pose(at_ns(time), flange(T @ DOWN))
    result, = made.results()
    assert result.profile is not None
    np.testing.assert_allclose(result.profile.thickness, 2.2e-3, atol=1.01 * PIXEL)


@pytest.mark.parametrize(('frozen_from', 'known'), [(0.5, False), (1.02, True), (9.0, True)])
def test_in_hand_a_capture_is_refused_while_poses_are_repeated_until_they_leap(
        frozen_from: float, known: bool) -> None:
    """A robot at 0.1 m/s whose driver repeats its pose for half a second, and then recovers."""
    made = in_hand()
    for time in np.arange(0.2, 1.8, 0.02):
        seen = frozen_from if frozen_from <= time < frozen_from + 0.6 else time
        T_base_flange = flange(DOWN)
        T_base_flange[2, 3] += 0.1 * (seen - 1.0)
        made.add_flange_pose(at_ns(float(time)), T_base_flange)
    result, = made.results()
    assert (result.profile is not None) == known
    assert ('leapt' in result.refusal) != known


def test_in_hand_a_capture_waits_for_a_later_pose() -> None:
    made = in_hand()
    made.add_flange_pose(at_ns(0.99), flange(DOWN))
    assert list(made.results()) == []
    made.add_flange_pose(at_ns(1.0), flange(DOWN))
    assert len(list(made.results())) == 1


@pytest.mark.parametrize('times', [(), (0.5,), (0.9, 1.1), (1.01, 1.02)])
def test_in_hand_without_poses_close_by_a_capture_is_refused(times: tuple[float, ...]) -> None:
    made = in_hand()
    for time in times:
        made.add_flange_pose(at_ns(time), flange(DOWN))
    result, = made.results(now_ns=3 * SECOND)
    assert result.profile is None
    assert result.refusal.startswith('end_effector_pose: expected poses around the capture')


def test_on_base_no_pose_is_needed() -> None:
    made = session(1.0, image=bed())
    made.set_path(path(1.6, finished=True))
    result, = made.results()
    assert result.profile is not None


def test_a_defect_in_the_measurement_is_a_refusal_and_logged(
        monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError('of ours')

    monkeypatch.setattr('bpc_perception.core.session.measure', fail)
    made = session(1.0)
    made.set_path(path(1.0))
    result, = made.results()
    assert result.profile is None
    assert 'of ours' in result.refusal
    assert 'measurement failed' in caplog.text
