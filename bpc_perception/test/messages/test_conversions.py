"""Messages to core types and back, field by field, and what must not get through."""

from __future__ import annotations

from array import array
from dataclasses import fields, replace
import math
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion
import numpy as np
from perception_builders import (
    band_image,
    BED,
    capture_of,
    HEIGHT,
    INK,
    path_through,
    pose,
    profile_of,
    START_NS,
    WIDTH,
)
import pytest
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

from bpc_interfaces.msg import (
    ExtrusionState,
    RateAdvice as RateAdviceMsg,
    ThicknessProfile as ThicknessProfileMsg,
)
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.profile import Status
from bpc_perception.messages.advice import advice_from_message, advice_to_message
from bpc_perception.messages.capture import (
    camera_from_info,
    capture_from_messages,
    capture_to_messages,
    cloud_to_xyz,
    image_to_rgb,
)
from bpc_perception.messages.extruder import extruder_from_message
from bpc_perception.messages.path import path_from_message, path_to_message, path_to_nav
from bpc_perception.messages.pose import pose_to_matrix, pose_to_message
from bpc_perception.messages.profile import profile_from_message, profile_to_message
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

pytestmark = pytest.mark.ros
refused = pytest.raises(ConversionError, match=r'expected .*found')
NAN = np.nan
STAMP = START_NS + 123_456_789


def assert_same(found: Any, expected: Any) -> None:
    """Two dataclasses hold the same, and arrays of the same kind."""
    assert type(found) is type(expected)
    for field in fields(expected):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        if isinstance(other, np.ndarray):
            assert one.dtype == other.dtype, field.name
            np.testing.assert_array_equal(one, other, err_msg=field.name)
        else:
            assert one == other or (one != one and other != other), field.name


# Stamps


@pytest.mark.parametrize('stamp_ns', [
    0, 1, 999_999_999, 10**9, STAMP, (2**31 - 1) * 10**9 + 999_999_999, -1, -(10**9) - 1])
def test_a_stamp_survives_to_the_nanosecond(stamp_ns: int) -> None:
    stamp = ns_to_stamp(stamp_ns)
    assert 0 <= stamp.nanosec < 10**9
    assert stamp_to_ns(stamp) == stamp_ns


def test_a_stamp_is_seconds_and_nanoseconds() -> None:
    assert stamp_to_ns(Time(sec=3, nanosec=7)) == 3_000_000_007


# Images


def image_message(encoding: str, size: int, padding: int = 0) -> Image:
    """Two rows of three pixels whose channels count up; padding is 99."""
    rows = np.full((2, 3 * size + padding), 99, np.uint8)
    rows[:, :3 * size] = np.arange(6 * size).reshape(2, 3 * size)
    return Image(width=3, height=2, encoding=encoding, step=rows.shape[1],
                 data=array('B', rows.tobytes()))


@pytest.mark.parametrize('padding', [0, 1, 13])
@pytest.mark.parametrize(('encoding', 'size', 'order'), [
    ('rgba8', 4, (0, 1, 2)), ('rgb8', 3, (0, 1, 2)), ('bgr8', 3, (2, 1, 0)),
    ('bgra8', 4, (2, 1, 0))])
def test_every_encoding_becomes_rgb(encoding: str, size: int, order: tuple[int, ...],
                                    padding: int) -> None:
    message = image_message(encoding, size, padding)
    rgb = image_to_rgb(message)
    expected = [[[size * (3 * row + column) + channel for channel in order]
                 for column in range(3)] for row in range(2)]
    assert rgb.tolist() == expected
    assert rgb.dtype == np.uint8
    assert np.shares_memory(rgb, np.asarray(message.data))  # nothing was copied


def test_the_last_row_needs_no_padding() -> None:
    message = image_message('rgb8', 3, 5)
    message.data = message.data[:-5]
    assert image_to_rgb(message)[1, 2].tolist() == [15, 16, 17]


@pytest.mark.parametrize('changes', [
    {'encoding': 'mono8'}, {'encoding': ''}, {'encoding': 'rgb16'}, {'step': 8}, {'step': 0},
    {'width': 4}, {'height': 3}, {'height': 0}, {'width': 0}, {'data': array('B')},
    {'height': 2**32 - 1, 'width': 2**32 - 1, 'step': 2**32 - 1}])
def test_an_image_that_does_not_fit_is_refused(changes: dict[str, Any]) -> None:
    message = image_message('rgb8', 3)
    for name, value in changes.items():
        setattr(message, name, value)
    with refused:
        image_to_rgb(message)


# Clouds


def cloud_message(*, offsets: tuple[int, int, int] = (0, 4, 8), point_step: int = 16,
                  padding: int = 0, big: bool = False, order: str = 'xyz') -> PointCloud2:
    """4 rows of 5 points (column, 10 row, column * row), the last of them missing."""
    v, u = np.mgrid[0:4, 0:5].astype(np.float32)
    values = dict(zip('xyz', (u, 10 * v, u * v), strict=True))
    rows = np.full((4, 5 * point_step + padding), 0x5a, np.uint8)
    points = rows[:, :5 * point_step].reshape(4, 5, point_step)
    for name, offset in zip('xyz', offsets, strict=True):
        axis = values[name].astype('>f4' if big else '<f4')
        axis[3, 4] = NAN
        points[..., offset:offset + 4] = axis[..., None].view(np.uint8)
    rows[:, :5 * point_step] = points.reshape(4, -1)
    named = dict(zip('xyz', offsets, strict=True))
    return PointCloud2(
        width=5, height=4, is_bigendian=big, point_step=point_step, row_step=rows.shape[1],
        fields=[PointField(name=name, offset=named[name], count=1, datatype=PointField.FLOAT32)
                for name in order], data=array('B', rows.tobytes()))


@pytest.mark.parametrize('layout', [
    {}, {'order': 'zyx'}, {'offsets': (8, 0, 4)}, {'offsets': (4, 8, 12)},
    {'offsets': (0, 8, 16), 'point_step': 32}, {'point_step': 32}, {'point_step': 12},
    {'point_step': 17}, {'offsets': (1, 5, 9), 'point_step': 13}, {'padding': 7}, {'big': True},
    {'big': True, 'offsets': (20, 24, 28), 'point_step': 32, 'padding': 16}], ids=str)
def test_every_layout_of_a_cloud_is_read(layout: dict[str, Any]) -> None:
    xyz = cloud_to_xyz(cloud_message(**layout))
    v, u = np.mgrid[0:4, 0:5]
    expected = np.stack((u, 10 * v, u * v), axis=-1).astype(np.float32)
    expected[3, 4] = NAN
    assert xyz.dtype == np.float32
    np.testing.assert_array_equal(xyz, expected)


def test_the_vendors_cloud_is_not_copied() -> None:
    message = capture_to_messages(capture_of(band_image()))[2]
    xyz = cloud_to_xyz(message)
    assert np.shares_memory(xyz, np.frombuffer(message.data, np.uint8))
    assert xyz.shape == (HEIGHT, WIDTH, 3)


def unorganized(message: PointCloud2) -> None:
    message.width, message.height, message.row_step = 20, 1, 320


def without_z(message: PointCloud2) -> None:
    message.fields = message.fields[:2]


def of_doubles(message: PointCloud2) -> None:
    message.fields[1].datatype = PointField.FLOAT64


def truncated(message: PointCloud2) -> None:
    message.data = message.data[:-8]


def beyond_the_point(message: PointCloud2) -> None:
    message.fields[2].offset = 13


def without_points(message: PointCloud2) -> None:
    message.width = 0


def with_short_rows(message: PointCloud2) -> None:
    message.row_step = 79


def without_fields(message: PointCloud2) -> None:
    message.fields = []


def without_size(message: PointCloud2) -> None:
    message.point_step = 0


def gigantic(message: PointCloud2) -> None:
    message.width = message.height = message.row_step = 2**32 - 1


@pytest.mark.parametrize('spoil', [
    unorganized, without_z, of_doubles, truncated, beyond_the_point, without_points,
    with_short_rows, without_fields, without_size, gigantic], ids=lambda spoil: spoil.__name__)
def test_a_cloud_that_does_not_fit_is_refused(spoil: Any) -> None:
    message = cloud_message()
    spoil(message)
    with refused:
        cloud_to_xyz(message)


def test_an_empty_cloud_message_is_refused() -> None:
    with refused:
        cloud_to_xyz(PointCloud2())


# Intrinsics


def info(**changes: Any) -> CameraInfo:
    values = {'width': 640, 'height': 480, 'distortion_model': 'plumb_bob',
              'd': [0.1, -0.2, 0.01, 0.02, 0.3],
              'k': [800.0, 0.0, 320.0, 0.0, 780.0, 240.0, 0.0, 0.0, 1.0]}
    return CameraInfo(**{**values, **changes})


def test_camera_info_gives_the_intrinsics() -> None:
    camera = camera_from_info(info())
    assert camera.K.tolist() == [[800, 0, 320], [0, 780, 240], [0, 0, 1]]
    assert camera.distortion.tolist() == [0.1, -0.2, 0.01, 0.02, 0.3]
    assert (camera.width, camera.height) == (640, 480)


@pytest.mark.parametrize(('model', 'count'), [('plumb_bob', 0), ('plumb_bob', 4), ('', 0),
                                              ('rational_polynomial', 8)])
def test_distortion_models_of_opencv_are_accepted(model: str, count: int) -> None:
    camera = camera_from_info(info(distortion_model=model, d=[0.0] * count))
    pixel = camera.pixels(np.array(((0.1, -0.2, 2.0),)))
    np.testing.assert_allclose(pixel, ((360, 162),))


@pytest.mark.parametrize('changes', [
    {'k': [0.0] * 9}, {'k': [NAN] * 9},
    {'k': [800.0, 0.0, 320.0, 0.0, -1.0, 240.0, 0.0, 0.0, 1.0]},
    {'d': [0.0] * 3}, {'d': [NAN] * 5}, {'distortion_model': 'equidistant'},
    {'distortion_model': ''}, {'distortion_model': 'rational_polynomial'}])
def test_an_uncalibrated_camera_is_refused(changes: dict[str, Any]) -> None:
    with refused:
        camera_from_info(info(**changes))


# Captures


def test_a_capture_survives_there_and_back() -> None:
    capture = capture_of(band_image(), STAMP)
    capture.cloud[3, 4] = NAN
    capture = replace(capture, camera=replace(capture.camera,
                                              distortion=np.array((0.1, 0.2, 0.3, 0.4, 0.5))))
    found = capture_from_messages(*capture_to_messages(capture))
    np.testing.assert_array_equal(found.image, capture.image)
    np.testing.assert_array_equal(found.cloud, capture.cloud)
    np.testing.assert_array_equal(found.camera.K, capture.camera.K)
    np.testing.assert_array_equal(found.camera.distortion, capture.camera.distortion)
    assert (found.stamp_ns, found.frame_id) == (STAMP, 'camera_optical_frame')


@pytest.mark.parametrize('count', [0, 4, 5, 8])
def test_a_capture_keeps_its_distortion(count: int) -> None:
    capture = capture_of(band_image())
    capture = replace(capture, camera=PinholeCamera(
        capture.camera.K, np.arange(count) / 100, WIDTH, HEIGHT))
    found = capture_from_messages(*capture_to_messages(capture))
    assert found.camera.distortion.tolist() == capture.camera.distortion.tolist()


def test_a_capture_looks_like_one_of_the_vendors_node() -> None:
    image, camera_info, cloud = capture_to_messages(capture_of(band_image(), STAMP))
    assert image.header == camera_info.header == cloud.header
    assert (image.encoding, image.step, image.is_bigendian) == ('rgba8', 4 * WIDTH, 0)
    assert set(image.data[3::4]) == {255}
    assert (cloud.point_step, cloud.row_step, len(cloud.data)) == (
        16, 16 * WIDTH, 16 * WIDTH * HEIGHT)
    assert not cloud.is_bigendian
    assert not cloud.is_dense
    assert [(field.name, field.offset, field.datatype, field.count) for field in cloud.fields] == [
        ('x', 0, 7, 1), ('y', 4, 7, 1), ('z', 8, 7, 1), ('rgba', 12, 6, 1)]
    first, ink = cloud.data[12:16], cloud.data[16 * (55 * WIDTH + 80) + 12:][:4]
    assert list(first) == [*BED[::-1], 255]  # blue, green, red, alpha
    assert list(ink) == [*INK[::-1], 255]
    assert camera_info.p.tolist()[:3] == camera_info.k.tolist()[:3]


def parts() -> tuple[Image, CameraInfo, PointCloud2]:
    messages: tuple[Image, CameraInfo, PointCloud2] = capture_to_messages(
        capture_of(band_image(), STAMP))
    # They share one header object.
    copies = [type(message)(**{name: getattr(message, name) for name in
                               message.get_fields_and_field_types() if name != 'header'})
              for message in messages]
    for copy in copies:
        copy.header.stamp = ns_to_stamp(STAMP)
    return copies[0], copies[1], copies[2]


@pytest.mark.parametrize('which', range(3))
def test_parts_of_different_stamps_make_no_capture(which: int) -> None:
    messages = parts()
    messages[which].header.stamp = ns_to_stamp(STAMP + 1)
    with pytest.raises(ConversionError, match='expected one stamp'):
        capture_from_messages(*messages)


@pytest.mark.parametrize('which', range(3))
def test_parts_of_different_sizes_make_no_capture(which: int) -> None:
    messages = parts()
    messages[which].height -= 1
    with pytest.raises(ConversionError, match=r'expected one size .*160 x 119'):
        capture_from_messages(*messages)


# Poses


def test_a_pose_survives_there_and_back() -> None:
    T = pose((0.1, -0.2, 0.3), (100, 20, -30))
    message = pose_to_message(STAMP, 'lbr_link_0', T)
    assert message.header.frame_id == 'lbr_link_0'
    assert stamp_to_ns(message.header.stamp) == STAMP
    np.testing.assert_allclose(pose_to_matrix(message.pose), T, atol=1e-15)


@pytest.mark.parametrize(('position', 'orientation'), [
    ((NAN, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (NAN, 0.0, 0.0, 1.0)), ((0.0, np.inf, 0.0), (0.0, 0.0, 0.0, 1.0)),
    ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0))])
def test_what_is_no_pose_is_refused(position: tuple[float, ...],
                                    orientation: tuple[float, ...]) -> None:
    with refused:
        pose_to_matrix(Pose(
            position=Point(**dict(zip('xyz', position, strict=True))),
            orientation=Quaternion(**dict(zip('xyzw', orientation, strict=True)))))


# Extruder


def test_what_an_extruder_in_error_does_is_unknown() -> None:
    message = ExtrusionState(extruding=True, plunger_velocity=1e-4, flow_rate=5e-8,
                             error_status=1 << 6)
    sample = extruder_from_message(message)
    assert not sample.extruding
    assert np.isnan((sample.plunger_velocity, sample.flow_rate)).all()


def test_an_extruder_that_is_uncertain_of_its_position_is_believed() -> None:
    """The path carries velocity and flow, which do not depend on it."""
    message = ExtrusionState(extruding=True, plunger_velocity=1e-4, flow_rate=5e-8,
                             position_uncertain=True)
    sample = extruder_from_message(message)
    assert (sample.extruding, sample.plunger_velocity, sample.flow_rate) == (True, 1e-4, 5e-8)


def test_an_extruder_state_is_read() -> None:
    message = ExtrusionState(extruding=True, plunger_velocity=2e-4, flow_rate=NAN)
    message.header.stamp = ns_to_stamp(STAMP)
    sample = extruder_from_message(message)
    assert (sample.stamp_ns, sample.extruding, sample.plunger_velocity) == (STAMP, True, 2e-4)
    assert np.isnan(sample.flow_rate)


# Paths

PATH = replace(
    path_through(np.random.default_rng(0).normal(size=(7, 3)).cumsum(axis=0), start_ns=STAMP,
                 extruding=[True, False] * 3 + [True], finished=False),
    flow_rate=np.array((1.0, NAN, 3, 4, 5, 6, 7)), plunger_velocity=np.arange(7.0))


@pytest.mark.parametrize('path', [PATH, PATH.until(0), replace(PATH, finished=True)],
                         ids=['growing', 'empty', 'finished'])
def test_a_path_survives_there_and_back(path: Any) -> None:
    message = path_to_message(path, 'base')
    assert message.header.frame_id == 'base'
    assert_same(path_from_message(message), path)


def test_a_path_message_has_its_points_by_axis() -> None:
    message = path_to_message(PATH, 'base')
    assert [message.x[2], message.y[2], message.z[2]] == PATH.points[2].tolist()
    assert list(message.extruding) == [True, False] * 3 + [True]


@pytest.mark.parametrize('name', ['time', 'arc_length', 'x', 'y', 'z', 'plunger_velocity',
                                  'flow_rate', 'extruding'])
def test_a_path_with_arrays_of_different_lengths_is_refused(name: str) -> None:
    message = path_to_message(PATH, 'base')
    setattr(message, name, getattr(message, name)[:-1])
    with pytest.raises(ConversionError,
                       match=rf"^deposition_path: expected arrays of one length.*'{name}': 6"):
        path_from_message(message)


@pytest.mark.parametrize(('name', 'value'), [
    ('x', NAN), ('z', np.inf), ('time', NAN), ('time', 0.0), ('arc_length', NAN),
    ('arc_length', -1.0)])
def test_a_path_of_impossible_points_is_refused(name: str, value: float) -> None:
    message = path_to_message(PATH, 'base')
    getattr(message, name)[3] = value
    with refused:
        path_from_message(message)


def test_a_path_for_viewers_has_places_and_times() -> None:
    message = path_to_nav(PATH, 'base')
    assert message.header.frame_id == 'base'
    assert len(message.poses) == 7
    position = message.poses[4].pose.position
    assert [position.x, position.y, position.z] == PATH.points[4].tolist()
    assert stamp_to_ns(message.poses[4].header.stamp) == pytest.approx(
        STAMP + PATH.time[4] * 1e9, abs=1)


# Profiles

PROFILE = replace(
    profile_of([1e-3, 0, NAN, 3e-3, NAN, NAN], [Status.MEASURED, Status.GAP, Status.NO_DATA,
                                               Status.MEASURED, Status.OCCLUDED,
                                               Status.LOW_CONFIDENCE],
               extruding=[True, False, True, True, False, True]),
    left=np.arange(6.0), right=-np.arange(6.0), sigma=np.arange(6.0) / 7,
    points=np.arange(18.0).reshape(6, 3), left_points=np.arange(18.0).reshape(6, 3) + 100,
    right_points=np.arange(18.0).reshape(6, 3) + 200)


def test_a_profile_survives_there_and_back() -> None:
    message = profile_to_message(PROFILE, 'base')
    assert message.header.frame_id == 'base'
    assert_same(profile_from_message(message), PROFILE)


def test_an_empty_profile_survives_there_and_back() -> None:
    profile = profile_of([])
    message = profile_to_message(profile, 'base')
    assert np.isnan(message.coverage)
    found = profile_from_message(message)
    assert len(found) == 0
    assert found.points.shape == (0, 3)


def test_a_profile_message_carries_the_summary() -> None:
    message = profile_to_message(PROFILE, 'base')
    assert message.thickness_mean == pytest.approx(2e-3)
    assert message.thickness_std == pytest.approx(1e-3)
    assert message.thickness_q1 == pytest.approx(1.5e-3)
    assert message.thickness_median == pytest.approx(2e-3)
    assert message.thickness_q3 == pytest.approx(2.5e-3)
    assert message.coverage == 0.5
    assert message.gap_count == 1
    assert message.gap_length == pytest.approx(1e-3)
    assert message.processing_time == 0.25


ARRAYS = [name for name, kind in ThicknessProfileMsg.get_fields_and_field_types().items()
          if kind.startswith('sequence')]


@pytest.mark.parametrize('name', ARRAYS)
def test_a_profile_with_arrays_of_different_lengths_is_refused(name: str) -> None:
    message = profile_to_message(PROFILE, 'base')
    setattr(message, name, getattr(message, name)[:-1])
    with pytest.raises(ConversionError, match=rf"expected arrays .*'{name}': 5"):
        profile_from_message(message)


@pytest.mark.parametrize(('name', 'value'), [
    ('status', max(Status) + 1), ('status', 255), ('thickness', math.nan), ('thickness', math.inf),
    ('thickness', 0.0), ('thickness', -1e-3)])
def test_a_profile_of_impossible_samples_is_refused(name: str, value: float) -> None:
    message = profile_to_message(PROFILE, 'base')
    assert message.status[0] == Status.MEASURED
    getattr(message, name)[0] = value
    with pytest.raises(ConversionError, match=rf'expected .*{name}.* found {value}'):
        profile_from_message(message)


@pytest.mark.parametrize('status', list(Status))
def test_status_numbers_are_those_of_the_message(status: Status) -> None:
    assert getattr(ThicknessProfileMsg, status.name) == status


# Advice

ADVICE = RateAdvice(
    stamp_ns=STAMP, print_id='print', valid=True, reason=Reason.LIMITED, target_thickness=2e-3,
    measured_thickness=1e-3, window=(0.01, 0.03), sample_count=17, flow_rate_scale=2.0,
    speed_scale=0.5, confidence=0.75, measurement_age=1.5, valid_until_ns=STAMP + 5,
    reference_time=0.25, expected_thickness=1.1e-3, delivery=0.9, delivery_sigma=0.1, lag=2.0,
    lag_sigma=0.5, flow_rate=1e-9, plunger_velocity=1e-5, speed=3e-3)


def test_advice_survives_there_and_back() -> None:
    assert_same(advice_from_message(advice_to_message(ADVICE)), ADVICE)


def test_an_unknown_reason_is_refused() -> None:
    message = advice_to_message(ADVICE)
    message.reason = 99
    with refused:
        advice_from_message(message)


@pytest.mark.parametrize('reason', list(Reason))
def test_reasons_are_those_of_the_message(reason: Reason) -> None:
    assert getattr(RateAdviceMsg, reason.name) == reason


def test_a_capture_of_a_real_size_is_read_quickly_because_it_is_not_copied() -> None:
    message = PointCloud2(
        width=1944, height=1200, point_step=16, row_step=16 * 1944,
        fields=[PointField(name=name, offset=4 * index, count=1, datatype=7)
                for index, name in enumerate('xyz')], data=array('B', bytes(16 * 1944 * 1200)))
    xyz = cloud_to_xyz(message)
    assert np.shares_memory(xyz[-1, -1], np.frombuffer(message.data, np.uint8)[-16:])


def test_a_capture_is_what_the_core_takes() -> None:
    found = capture_from_messages(*parts())
    assert isinstance(found, Capture)
