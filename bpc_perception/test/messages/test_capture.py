"""Captures from and to the messages of the camera, and which messages are refused."""

from __future__ import annotations

from array import array
from dataclasses import replace
from typing import Any

from message_builders import NAN, refused, STAMP_NS
import numpy as np
from perception_builders import band_image, BED, capture_of, HEIGHT, INK, WIDTH
import pytest
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.messages.capture import (
    camera_from_info,
    capture_from_messages,
    capture_to_messages,
    cloud_to_xyz,
    image_to_rgb,
)
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp

pytestmark = pytest.mark.ros


def image_message(encoding: str, size: int, padding: int = 0) -> Image:
    """Return two rows of three pixels whose channels count up; padding is 99."""
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
    {'encoding': 'mono8'}, {'encoding': ''}, {'encoding': 'rgb16'}, {'step': 8},
    {'step': 0, 'data': array('B', bytes(17))},
    {'width': 4}, {'height': 3}, {'height': 0}, {'width': 0}, {'data': array('B')},
    {'height': 2**32 - 1, 'width': 2**32 - 1, 'step': 2**32 - 1}])
def test_an_image_that_does_not_fit_is_refused(changes: dict[str, Any]) -> None:
    message = image_message('rgb8', 3)
    for name, value in changes.items():
        setattr(message, name, value)
    with refused:
        image_to_rgb(message)


def cloud_message(*, offsets: tuple[int, int, int] = (0, 4, 8), point_step: int = 16,
                  padding: int = 0, big: bool = False, order: str = 'xyz') -> PointCloud2:
    """Return 4 rows of 5 points (column, 10 row, 1 + column * row) without the last point."""
    v, u = np.mgrid[0:4, 0:5].astype(np.float32)
    values = dict(zip('xyz', (u, 10 * v, 1 + u * v), strict=True))
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
    expected = np.stack((u, 10 * v, 1 + u * v), axis=-1).astype(np.float32)
    expected[3, 4] = NAN
    assert xyz.dtype == np.float32
    np.testing.assert_array_equal(xyz, expected)


@pytest.mark.parametrize('of_row', [0.0, 4.0])  # left out, and the size of all rows
def test_rows_are_found_where_a_driver_does_not_say_them(of_row: float) -> None:
    message = cloud_message()
    expected = cloud_to_xyz(message).copy()
    message.row_step = int(of_row * message.row_step)
    np.testing.assert_array_equal(cloud_to_xyz(message), expected)
    image = image_message('rgb8', 3)
    colours = image_to_rgb(image).copy()
    image.step = int(of_row / 2 * image.step)
    np.testing.assert_array_equal(image_to_rgb(image), colours)


def test_double_precision_is_read() -> None:
    message = cloud_message()
    expected = cloud_to_xyz(message).copy()
    message.data = array('B', expected.astype('<f8').tobytes())
    message.point_step, message.row_step = 24, 24 * 5
    message.fields = [PointField(name=name, offset=8 * index, count=1,
                                 datatype=PointField.FLOAT64) for index, name in enumerate('xyz')]
    np.testing.assert_array_equal(cloud_to_xyz(message), expected)


def test_a_point_in_the_camera_is_none() -> None:
    message = capture_to_messages(capture_of(band_image()))[2]
    expected = cloud_to_xyz(message).copy()
    expected[20:60, 30:50] = NAN
    points = np.frombuffer(message.data, np.float32).reshape(HEIGHT, WIDTH, 4).copy()
    points[20:60, 30:50, :3] = 0
    message.data = array('B', points.tobytes())
    np.testing.assert_array_equal(cloud_to_xyz(message), expected)


def test_a_cloud_in_millimetres_is_called_that() -> None:
    message = capture_to_messages(capture_of(band_image()))[2]
    points = np.frombuffer(message.data, np.float32).reshape(-1, 4).copy()
    points[:, :3] *= 1000
    message.data = array('B', points.tobytes())
    with pytest.raises(ConversionError, match='are they in millimetres'):
        cloud_to_xyz(message)


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
                                              ('none', 5), ('', 5), ('plumb_bob', 8),
                                              ('rational_polynomial', 8)])
def test_distortion_models_of_opencv_are_accepted(model: str, count: int) -> None:
    camera = camera_from_info(info(distortion_model=model, d=[0.0] * count))
    pixel = camera.pixels(np.array(((0.1, -0.2, 2.0),)))
    np.testing.assert_allclose(pixel, ((360, 162),))


@pytest.mark.parametrize('changes', [
    {'k': [0.0] * 9}, {'k': [NAN] * 9},
    {'k': [800.0, 0.0, 320.0, 0.0, -1.0, 240.0, 0.0, 0.0, 1.0]},
    {'d': [0.0] * 3}, {'d': [NAN] * 5}, {'distortion_model': 'equidistant'},
    {'distortion_model': '', 'd': [0.1] * 5},
    {'distortion_model': 'plumb_bob', 'd': [0.0] * 5 + [0.1] * 3},
    {'distortion_model': 'rational_polynomial'}])
def test_an_uncalibrated_camera_is_refused(changes: dict[str, Any]) -> None:
    with refused:
        camera_from_info(info(**changes))


def test_a_capture_survives_there_and_back() -> None:
    capture = capture_of(band_image(), STAMP_NS)
    capture.cloud[3, 4] = NAN
    capture = replace(capture, camera=replace(capture.camera,
                                              distortion=np.array((0.1, 0.2, 0.3, 0.4, 0.5))))
    found = capture_from_messages(*capture_to_messages(capture))
    np.testing.assert_array_equal(found.image, capture.image)
    np.testing.assert_array_equal(found.cloud, capture.cloud)
    np.testing.assert_array_equal(found.camera.K, capture.camera.K)
    np.testing.assert_array_equal(found.camera.distortion, capture.camera.distortion)
    assert (found.stamp_ns, found.frame_id) == (STAMP_NS, 'camera_optical_frame')


@pytest.mark.parametrize('count', [0, 4, 5, 8])
def test_a_capture_keeps_its_distortion(count: int) -> None:
    capture = capture_of(band_image())
    capture = replace(capture, camera=PinholeCamera(
        capture.camera.K, np.arange(count) / 100, WIDTH, HEIGHT))
    found = capture_from_messages(*capture_to_messages(capture))
    assert found.camera.distortion.tolist() == capture.camera.distortion.tolist()


def test_a_capture_looks_like_one_of_the_vendors_node() -> None:
    image, camera_info, cloud = capture_to_messages(capture_of(band_image(), STAMP_NS))
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
        capture_of(band_image(), STAMP_NS))
    # They share one header object.
    copies = [type(message)(**{name: getattr(message, name) for name in
                               message.get_fields_and_field_types() if name != 'header'})
              for message in messages]
    for copy in copies:
        copy.header.stamp = ns_to_stamp(STAMP_NS)
    return copies[0], copies[1], copies[2]


@pytest.mark.parametrize('which', range(3))
def test_parts_of_different_stamps_make_no_capture(which: int) -> None:
    messages = parts()
    messages[which].header.stamp = ns_to_stamp(STAMP_NS + 1)
    with pytest.raises(ConversionError, match='expected one stamp'):
        capture_from_messages(*messages)


@pytest.mark.parametrize('which', range(3))
def test_parts_of_different_sizes_make_no_capture(which: int) -> None:
    messages = parts()
    messages[which].height -= 1
    with pytest.raises(ConversionError, match=r'expected one size .*160 x 119'):
        capture_from_messages(*messages)


def test_a_capture_of_a_real_size_is_read_quickly_because_it_is_not_copied() -> None:
    message = PointCloud2(
        width=1944, height=1200, point_step=16, row_step=16 * 1944,
        fields=[PointField(name=name, offset=4 * index, count=1, datatype=7)
                for index, name in enumerate('xyz')],
        data=array('B', bytes((0, 0, 0, 63)) * 4 * 1944 * 1200))
    xyz = cloud_to_xyz(message)
    assert np.shares_memory(xyz[-1, -1], np.frombuffer(message.data, np.uint8)[-16:])


def test_a_capture_is_what_the_core_takes() -> None:
    found = capture_from_messages(*parts())
    assert isinstance(found, Capture)
