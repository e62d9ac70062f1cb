"""The thickness node in process: captures and path in, profiles and advice out, never a crash."""

from __future__ import annotations

from array import array
from dataclasses import replace
from pathlib import Path
import time
from typing import Any

import numpy as np
from perception_builders import band_image, capture_of, DOWN, PIXEL, pixel_path, pose, SECOND
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.parameter import parameters_of
from bpc_perception.core.path.growing_path import GrowingPath

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticStatus
from node_builders import (
    assert_profile_comes,
    BASE,
    BEAD_PATH,
    BEAD_WIDTH_M,
    Bench,
    CALIBRATION,
    STAMP_NS,
    thickness_bench,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from bpc_interfaces.msg import DepositionPathUpdate, RateAdvice, ThicknessProfile
from bpc_perception.files.hand_eye_file import HandEyeError
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.path import path_from_message, path_to_message
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.nodes.thickness import ThicknessNode

pytestmark = pytest.mark.ros
METHODS = parameters_of(ThicknessConfig)['method'][0].choices


@pytest.mark.parametrize('method', METHODS)
def test_capture_and_path_become_profile_and_advice(graph: Any, tmp_path: Path,
                                                    method: str) -> None:
    bench = thickness_bench(graph, tmp_path, method=method, advice__target_thickness=BEAD_WIDTH_M,
                            advice__dead_band=0.12)
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS)
    profile = assert_profile_comes(bench, STAMP_NS)
    assert (profile.header.frame_id, profile.print_id, profile.method, profile.capture) == (
        BASE, 'print', method, 0)
    assert set(profile.status) == {ThicknessProfile.MEASURED}
    assert profile.thickness_median == pytest.approx(BEAD_WIDTH_M, abs=1.01 * PIXEL)
    advice = bench.received[topics.ADVICE][0]
    assert advice.valid
    assert advice.reason == RateAdvice.ON_TARGET
    assert advice.target_thickness == BEAD_WIDTH_M
    assert stamp_to_ns(advice.header.stamp) == STAMP_NS


def test_what_a_print_was_set_up_with_is_known_after_a_restart(graph: Any,
                                                               tmp_path: Path) -> None:
    state = tmp_path / 'state'
    settings: dict[str, Any] = {'advice__target_thickness': BEAD_WIDTH_M,
                                'state_folder': str(state)}
    bench = thickness_bench(graph, tmp_path, **settings)
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS)
    assert_profile_comes(bench, STAMP_NS)
    setup = bench.node._session.setup
    assert np.isfinite(setup.gain)
    again = thickness_bench(graph, tmp_path, **settings)
    assert again.node._session.setup == setup


def test_a_capture_waits_for_the_path(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    bench.send_capture(STAMP_NS)
    bench.until(lambda: bench.diagnosed('captures') == '1')
    assert bench.received[topics.PROFILE] == []
    bench.send(topics.PATH, BEAD_PATH)
    assert_profile_comes(bench, STAMP_NS)


def test_captures_that_stop_are_missed(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    bench.timer.cancel()
    watch = bench.node._diagnostics._inputs['captures']
    bench.send_capture(STAMP_NS)
    bench.until(lambda: watch.age(time.monotonic()) is not None)
    for age in (4, 3, 2, 1):  # as if one had come each second until now
        watch.heard(time.monotonic() - age)
    bench.until(lambda: any('captures: expected messages, found silence' in status.message
                            for status in bench.statuses))


def test_a_deposit_beside_its_path_is_warned_of(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    bench.send(topics.PATH, path_to_message(pixel_path((40, 59), (120, 59), 81), BASE))
    bench.send_capture(STAMP_NS)
    bench.until(lambda: any('offset: ' in status.message for status in bench.statuses))
    profile, = bench.received[topics.PROFILE]
    # The band's middle is at v = 55, and smaller v is to the left of travel along u.
    assert profile.offset_mean == pytest.approx(4 * PIXEL, abs=PIXEL / 2)
    assert profile.offset_rms == pytest.approx(4 * PIXEL, abs=PIXEL / 2)


def test_the_newest_of_captures_is_measured_and_the_others_are_counted(graph: Any,
                                                                       tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    bench.send(topics.PATH, BEAD_PATH)
    bench.until(lambda: bench.node._session._path)
    turns = [bench.node.hand_over(capture_of(band_image(), STAMP_NS + number * SECOND))
             for number in range(3)]
    assert not turns[0].is_set()
    assert_profile_comes(bench, STAMP_NS + 2 * SECOND)
    assert all(turn.is_set() for turn in turns)
    bench.until(lambda: bench.diagnosed('captures skipped for newer ones') == '2')
    assert bench.diagnosed('captures') == '3'
    assert bench.statuses[-1].level == DiagnosticStatus.OK


def test_a_second_camera_is_not_measured_as_if_it_were_the_first(graph: Any,
                                                                tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    other = graph.make(Node, 'other')
    cameras = [other.create_publisher(kind, name, topics.CAMERA_QOS)
               for name, kind in topics.CAMERA.items()]
    bench.until(lambda: all(camera.get_subscription_count() for camera in cameras))
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS)
    assert_profile_comes(bench, STAMP_NS)
    for camera, message in zip(cameras, capture_to_messages(
            capture_of(band_image(), STAMP_NS + SECOND)), strict=True):
        camera.publish(message)
    for name in topics.CAMERA:
        bench.until(lambda name=name: bench.diagnosed(f'refused: {name}') == '1')
    assert bench.diagnosed('captures') == '1'
    assert 'expected messages of one publisher' in bench.diagnosed('last refusal')


@pytest.mark.parametrize('place', [
    'messages.capture_pairing.capture_from_messages', 'core.session.measure',
    'core.session.overexposed', 'nodes.parts.views.Views.publish'])
def test_without_memory_for_a_capture_it_is_refused_and_the_next_is_measured(
        graph: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    def fail(*_: Any) -> None:
        raise MemoryError('Unable to allocate 23.0 MiB')

    bench = thickness_bench(graph, tmp_path)
    bench.send(topics.PATH, BEAD_PATH)
    with monkeypatch.context() as context:
        context.setattr(f'bpc_perception.{place}', fail)
        bench.send_capture(STAMP_NS)
        bench.until(lambda: 'Unable to allocate 23.0 MiB' in bench.diagnosed('last refusal'))
    profiles = bench.received[topics.PROFILE]
    profiles.clear()
    bench.send_capture(STAMP_NS + SECOND)
    assert_profile_comes(bench, STAMP_NS + SECOND)


def test_a_path_in_parts_is_as_good(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    path = path_from_message(BEAD_PATH)
    half = path.until(STAMP_NS - 9 * SECOND - SECOND // 2)
    rest = path.where(np.arange(len(path)) >= len(half))
    assert len(half) > 10 < len(rest)
    bench.send_capture(STAMP_NS)
    for first, part in ((0, replace(half, complete_until=0.5, finished=False)),
                        (len(half), rest)):
        bench.send(topics.PATH_UPDATE, DepositionPathUpdate(
            first=first, path=path_to_message(part, BASE)), kind=DepositionPathUpdate,
            qos=topics.UPDATE_QOS)
    assert len(assert_profile_comes(bench, STAMP_NS).x) == len(path)


def test_who_looks_gets_markers_overlay_and_scalars(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, advice__target_thickness=BEAD_WIDTH_M)
    views = [bench.listen(name, kind, topics.VIEW_QOS) for name, kind in topics.VIEWS.items()]
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS)
    bench.until(lambda: all(views))
    width = bench.received[topics.WIDTH][0].data
    assert width == pytest.approx(BEAD_WIDTH_M, abs=PIXEL)


def test_what_nobody_looks_at_is_not_made(graph: Any, tmp_path: Path,
                                          monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    for name in ('markers', 'overlay', 'width', 'deviation'):
        monkeypatch.setattr(f'bpc_perception.nodes.parts.views.{name}_message',
                            lambda *_, name=name: made.append(name))
    bench = thickness_bench(graph, tmp_path)
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS)
    assert_profile_comes(bench, STAMP_NS)
    assert made == []


def test_in_hand_poses_place_the_camera(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, mount='eye_in_hand')
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS)
    bench.send(topics.POSE, *(pose_to_message(STAMP_NS + shift, BASE, np.eye(4))
                              for shift in (-10**7, 10**7)))
    assert_profile_comes(bench, STAMP_NS)


def image_only(bench: Bench) -> None:
    image, info, _ = capture_to_messages(capture_of(band_image(), STAMP_NS))
    bench.send(topics.IMAGE, image)
    bench.send(topics.CAMERA_INFO, info)


def test_an_image_without_cloud_is_given_up_after_a_while(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, patience=0.2)
    bench.send(topics.PATH, BEAD_PATH)
    image_only(bench)
    bench.until(lambda: bench.diagnosed('refused: capture') == '1')
    refusal = bench.diagnosed('last refusal')
    assert 'found no points/xyzrgba; they get lost where' in refusal
    assert 'has too little shared memory' in refusal
    assert refusal.endswith('transport.xml')
    bench.send_capture(STAMP_NS + SECOND)
    assert_profile_comes(bench, STAMP_NS + SECOND)


def smaller(messages: dict[str, Any]) -> None:
    messages[topics.CLOUD].height -= 1


def unorganized(messages: dict[str, Any]) -> None:
    for message in messages.values():
        message.width, message.height = message.width * message.height, 1
    messages[topics.IMAGE].step *= 120
    messages[topics.CLOUD].row_step *= 120


def mono(messages: dict[str, Any]) -> None:
    messages[topics.IMAGE].encoding = 'mono8'


def uncalibrated(messages: dict[str, Any]) -> None:
    messages[topics.CAMERA_INFO].k = [0.0] * 9


def truncated(messages: dict[str, Any]) -> None:
    cloud = messages[topics.CLOUD]
    cloud.data = cloud.data[:1000]


def without_depth(messages: dict[str, Any]) -> None:
    cloud = messages[topics.CLOUD]
    cloud.data = array('B', np.full(len(cloud.data) // 4, np.nan, np.float32).tobytes())


@pytest.mark.parametrize(('spoil', 'kind'), [
    (smaller, 'capture'), (unorganized, 'cloud'), (mono, 'image'), (uncalibrated, 'camera_info'),
    (truncated, 'cloud'), (without_depth, 'cloud')], ids=lambda value: getattr(
        value, '__name__', value))
def test_an_unusable_capture_is_counted_and_the_next_is_measured(
        graph: Any, tmp_path: Path, spoil: Any, kind: str) -> None:
    bench = thickness_bench(graph, tmp_path)
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS, spoil)
    bench.until(lambda: bench.diagnosed(f'refused: {kind}') == '1')
    assert bench.received[topics.PROFILE] == []
    bench.send_capture(STAMP_NS + SECOND)
    assert_profile_comes(bench, STAMP_NS + SECOND)


def test_a_capture_without_path_is_counted(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, patience=0.1)
    bench.send_capture(STAMP_NS)
    bench.until(lambda: bench.diagnosed('captures before a print') == '1')
    assert bench.received[topics.PROFILE] == []


def elsewhere(message: Any) -> None:
    message.header.frame_id = 'world'


def torn(message: Any) -> None:
    message.x = message.x[:-1]


@pytest.mark.parametrize('spoil', [elsewhere, torn], ids=lambda spoil: spoil.__name__)
def test_an_unusable_path_is_counted_and_not_used(graph: Any, tmp_path: Path,
                                                  spoil: Any) -> None:
    bench = thickness_bench(graph, tmp_path, patience=0.1)
    wrong = path_to_message(pixel_path((40, 55), (120, 55), 81), BASE)
    spoil(wrong)
    bench.send(topics.PATH, wrong)
    bench.until(lambda: bench.diagnosed('refused: deposition_path') == '1')
    bench.send_capture(STAMP_NS)
    bench.until(lambda: bench.diagnosed('captures before a print') == '1')
    assert bench.received[topics.PROFILE] == []


@pytest.mark.parametrize('frame', ['world', 'nan'])
def test_in_hand_unusable_poses_are_counted_and_not_used(graph: Any, tmp_path: Path,
                                                         frame: str) -> None:
    bench = thickness_bench(graph, tmp_path, mount='eye_in_hand', patience=0.1)
    bench.send(topics.PATH, BEAD_PATH)
    for shift in (-10**7, 10**7):
        message = pose_to_message(STAMP_NS + shift, BASE, np.eye(4))
        if frame == 'nan':
            message.pose.position.x = np.nan
        else:
            message.header.frame_id = frame
        bench.send(topics.POSE, message)
    bench.until(lambda: bench.diagnosed('refused: pose') == '2')
    bench.send_capture(STAMP_NS)
    bench.until(lambda: bench.diagnosed('refused: end_effector_pose') == '1')
    assert bench.received[topics.PROFILE] == []


def test_in_hand_poses_that_jump_or_come_twice_are_counted_and_not_used(
        graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, mount='eye_in_hand', patience=0.1)
    bench.send(topics.PATH, BEAD_PATH)
    away = np.eye(4)
    away[:3, 3] = 0.5
    for shift, pose_then in ((-10**7, np.eye(4)), (-10**7, np.eye(4)), (10**7, away)):
        bench.send(topics.POSE, pose_to_message(STAMP_NS + shift, BASE, pose_then))
    bench.until(lambda: bench.diagnosed('refused: pose') == '2')
    bench.send_capture(STAMP_NS)
    bench.until(lambda: bench.diagnosed('refused: end_effector_pose') == '1')
    assert bench.received[topics.PROFILE] == []


def test_a_new_target_takes_effect_at_once(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    bench.send(topics.PATH, BEAD_PATH)
    result, = bench.node.set_parameters([Parameter('advice.target_thickness', value=0.0033)])
    assert result.successful
    bench.send_capture(STAMP_NS)
    assert_profile_comes(bench, STAMP_NS)
    advice = bench.received[topics.ADVICE][0]
    assert advice.target_thickness == 0.0033
    assert advice.reason in (RateAdvice.UNDER_EXTRUSION, RateAdvice.LIMITED)


@pytest.mark.parametrize('name', ['', '/nowhere/camera.calib'])
def test_an_unknown_calibration_is_refused_at_the_start(graph: Any, name: str) -> None:
    with pytest.raises(HandEyeError, match=r'expected a .*file, found'):
        graph.make(ThicknessNode, hand_eye_file=name)


def test_the_pose_used_here_is_the_one_of_the_calibration(tmp_path: Path) -> None:
    from bpc_perception.files.hand_eye_file import load_hand_eye

    file = tmp_path / 'camera.calib'
    file.write_text(CALIBRATION.format(mount='eye_on_base'))
    T: Array = load_hand_eye(file).T_parent_camera
    np.testing.assert_allclose(T, DOWN, atol=1e-15)
    np.testing.assert_allclose(T, pose((0, 0, 0.5), (0, 0, 180)), atol=1e-15)


def test_after_a_print_was_cleared_nothing_of_it_stands(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, advice__target_thickness=BEAD_WIDTH_M)
    for view, kind in topics.VIEWS.items():
        bench.listen(view, kind, topics.VIEW_QOS)
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(STAMP_NS)
    assert_profile_comes(bench, STAMP_NS)
    bench.until(lambda: all(bench.received[view] for view in topics.VIEWS))
    none = GrowingPath('', STAMP_NS)
    none.finished = True
    bench.send(topics.PATH, path_to_message(none.path(), BASE))
    profiles, advice = bench.received[topics.PROFILE], bench.received[topics.ADVICE]
    bench.until(lambda: len(profiles) == len(advice) == 2)
    assert (profiles[1].print_id, len(profiles[1].time)) == ('', 0)
    assert np.isnan(profiles[1].thickness_mean)
    assert (advice[1].print_id, advice[1].valid, advice[1].flow_rate_scale) == ('', False, 1.0)
    assert advice[1].valid_until == advice[1].header.stamp
    late: dict[str, list[Any]] = {view: [] for view in topics.VIEWS}
    for view, kind in topics.VIEWS.items():
        bench.peer.create_subscription(kind, view, late[view].append, topics.VIEW_QOS)
    bench.until(lambda: all(late.values()))
    marker, = late[topics.MARKERS][0].markers
    assert marker.action == marker.DELETEALL
    assert np.isnan((late[topics.WIDTH][0].data, late[topics.DEVIATION][0].data)).all()
    assert late[topics.OVERLAY][0].width == 1
    bench.send_capture(STAMP_NS + SECOND)  # of what was cleared it is no print
    bench.until(lambda: any('found none started' in status.message for status in bench.statuses))
    assert len(profiles) == 2


def test_what_was_begun_since_is_not_cleared(graph: Any, tmp_path: Path) -> None:
    """Topics may overtake each other."""
    bench = thickness_bench(graph, tmp_path)
    late = GrowingPath('', stamp_to_ns(BEAD_PATH.header.stamp) - 1)
    late.finished = True
    bench.send(topics.PATH_UPDATE, DepositionPathUpdate(path=BEAD_PATH),
               kind=DepositionPathUpdate, qos=topics.UPDATE_QOS)
    bench.send_capture(STAMP_NS)
    assert_profile_comes(bench, STAMP_NS)
    bench.send(topics.PATH, path_to_message(late.path(), BASE))
    bench.send_capture(STAMP_NS + SECOND)
    bench.until(lambda: len(bench.received[topics.PROFILE]) == 2)
    assert all(each.print_id == 'print' for each in bench.received[topics.PROFILE])


def test_before_a_print_begins_nothing_is_a_fault(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, watch__warn_after=0.0)
    bench.send_capture(STAMP_NS)
    bench.until(lambda: bench.diagnosed('captures before a print') == '1')
    assert 'found none started' in bench.statuses[-1].message
    assert {status.level for status in bench.statuses} == {DiagnosticStatus.OK}
    assert not bench.diagnosed('refused: path')
    bench.until(lambda: bench.statuses[-1].message == 'ok')
