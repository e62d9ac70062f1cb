"""Convert captures from and to the messages of the vendor's camera node."""

from __future__ import annotations

from array import array
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_msgs.msg import Header

from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.messages.array_fields import set_data
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

# Where red, green and blue lie in a pixel, and the bytes of a pixel.
IMAGE_ENCODINGS = {'rgba8': (slice(0, 3), 4), 'rgb8': (slice(0, 3), 3),
                   'bgr8': (slice(2, None, -1), 3), 'bgra8': (slice(2, None, -1), 4)}
FLOAT_BYTES = {PointField.FLOAT32: 4, PointField.FLOAT64: 8}
FARTHEST_M = 20.0  # that a camera sees; what is farther has another unit
GRID_POINTS = 128  # along the longer side, that tell how a cloud is written
# Possible numbers of coefficients.
DISTORTION_MODELS = {'': (0,), 'none': (0,), 'plumb_bob': (0, 4, 5), 'rational_polynomial': (8,)}


def image_to_rgb(message: Image) -> NDArray[np.uint8]:
    """Return the image as a view RGB (H, W, 3), uint8. Raises ConversionError."""
    if message.encoding not in IMAGE_ENCODINGS:
        raise ConversionError(f'image: expected encoding {", ".join(IMAGE_ENCODINGS)}, '
                              f'found "{message.encoding}"'
                              "; choose one at the camera's driver")
    channels, size = IMAGE_ENCODINGS[message.encoding]
    step = _row_step('image', message, message.step, message.width * size)
    pixels: NDArray[np.uint8] = np.ndarray(
        (message.height, message.width, size), np.uint8, message.data, strides=(step, size, 1))
    return pixels[..., channels]


def cloud_to_xyz(message: PointCloud2) -> NDArray[np.float32]:
    """Return the points of an organized cloud (H, W, 3), float32 [m], in its frame; NaN = none.

    They are a view if x, y and z are FLOAT32 and lie together in the byte order of this computer.
    Points at 0, 0, 0 stand for none as well. Raises ConversionError.
    """
    if message.height < 2:
        raise ConversionError('cloud: expected an organized cloud, found '
                              f'{message.width} x {message.height} points'
                              '; let the driver publish it with all pixels')
    offsets, size = _axes(message)
    if max(offsets) + size > message.point_step:
        raise ConversionError(f'cloud: expected fields within point_step {message.point_step}, '
                              f'found offsets {offsets}'
                              "; look at the camera's driver")
    step = _row_step('cloud', message, message.row_step, message.width * message.point_step)
    kind = np.dtype(f'{">" if message.is_bigendian else "<"}f{size}')
    if (offsets == [offsets[0], offsets[0] + 4, offsets[0] + 8] and size == 4
            and not message.is_bigendian):
        return _in_metres(np.ndarray((message.height, message.width, 3), kind, message.data,
                                     offsets[0], (step, message.point_step, 4)))
    axes = [np.ndarray((message.height, message.width), kind, message.data, offset,
                       (step, message.point_step)) for offset in offsets]
    return _in_metres(np.stack(axes, axis=2).astype(np.float32))


def _axes(message: PointCloud2) -> tuple[list[int], int]:
    """Return the offsets of x, y and z in a point, and the size of each [bytes].

    Raises ConversionError.
    """
    fields = {field.name: field for field in message.fields}
    kinds = {fields[axis].datatype for axis in 'xyz' if axis in fields}
    if not (fields.keys() >= set('xyz') and len(kinds) == 1 and kinds <= FLOAT_BYTES.keys()):
        raise ConversionError('cloud: expected FLOAT32 or FLOAT64 fields x, y and z, found '
                              f'{[(field.name, field.datatype) for field in message.fields]}'
                              "; choose such fields at the camera's driver")
    return [int(fields[axis].offset) for axis in 'xyz'], FLOAT_BYTES[kinds.pop()]


def _in_metres(xyz: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return points (H, W, 3) with NaN where there is none. Raises ConversionError."""
    step = max(1, max(xyz.shape[:2]) // GRID_POINTS)
    some = xyz[::step, ::step]
    distance = np.abs(some[..., 2][np.isfinite(some[..., 2])])
    if len(distance) and np.median(distance) > FARTHEST_M:
        raise ConversionError('cloud: expected points in metres, found them '
                              f'{np.median(distance):.0f} away; are they in millimetres?')
    if not (some == 0).all(axis=2).any():
        return xyz
    return np.where((xyz == 0).all(axis=2)[..., None], np.float32(np.nan), xyz)


def _row_step(name: str, message: Any, step: int, least: int) -> int:
    """Return the bytes from row to row; some drivers leave it 0, or say the size of all rows.

    Raises ConversionError unless the data have all rows.
    """
    if message.width == 0 or message.height == 0:
        raise ConversionError(f'{name}: expected pixels, found {message.width} x {message.height}'
                              "; look at the camera's driver")
    if step in (0, least * message.height) and len(message.data) == least * message.height:
        return least
    if step < least:
        raise ConversionError(f'{name}: expected rows of {least} bytes or more, found {step}'
                              "; look at the camera's driver")
    needed = step * (message.height - 1) + least
    if len(message.data) < needed:
        raise ConversionError(f'{name}: expected {needed} bytes of data, '
                              f'found {len(message.data)}'
                              "; look at the camera's driver")
    return step


def camera_from_info(message: CameraInfo) -> PinholeCamera:
    """Return the intrinsics of a calibrated camera. Raises ConversionError."""
    K = np.array(message.k, np.float64).reshape(3, 3)
    if not (np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0):
        raise ConversionError(f'camera_info: expected a calibrated camera, found K {K.tolist()}'
                              '; calibrate it, or let its driver publish the calibration')
    distortion = np.array(message.d, np.float64)
    lengths = DISTORTION_MODELS.get(message.distortion_model)
    if lengths is not None and not distortion[lengths[-1]:].any():
        distortion = distortion[:lengths[-1]]  # zeros that the model has not
    if lengths is None or len(distortion) not in lengths or not np.isfinite(distortion).all():
        raise ConversionError('camera_info: expected plumb_bob with 5 or rational_polynomial '
                              f'with 8 finite coefficients, found "{message.distortion_model}" '
                              f'with {distortion.tolist()}; choose one at the driver')
    return PinholeCamera(K, distortion, message.width, message.height)


def capture_from_messages(image: Image, info: CameraInfo, cloud: PointCloud2) -> Capture:
    """Make the capture of an image, a camera info and a cloud with one stamp and size.

    Raises ConversionError.
    """
    stamps = [stamp_to_ns(message.header.stamp) for message in (image, info, cloud)]
    if len(set(stamps)) > 1:
        raise ConversionError('capture: expected one stamp for image, camera_info and cloud, '
                              f'found {stamps}; let the driver give all three that of the capture')
    sizes = [(message.width, message.height) for message in (image, info, cloud)]
    if len(set(sizes)) > 1:
        raise ConversionError('capture: expected one size for image, camera_info and cloud, '
                              f'found {", ".join(f"{w} x {h}" for w, h in sizes)}'
                              '; let the driver publish all three in one')
    return Capture(stamps[0], cloud.header.frame_id, image_to_rgb(image), cloud_to_xyz(cloud),
                   camera_from_info(info))


def capture_to_messages(capture: Capture) -> tuple[Image, CameraInfo, PointCloud2]:
    """Convert a capture to the messages of the vendor's node: rgba8, 16 bytes a point.

    The distortion model is plumb_bob as there, or rational_polynomial when it has eight terms.
    """
    header = Header(stamp=ns_to_stamp(capture.stamp_ns), frame_id=capture.frame_id)
    height, width = capture.image.shape[:2]
    pixels = np.ascontiguousarray(capture.image)
    points = np.empty((height, width, 4), np.float32)
    # The bytes of the uint32 field "rgba" are blue, green, red, alpha.
    colours = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGRA).view(np.float32)
    cv2.mixChannels([np.ascontiguousarray(capture.cloud), colours], [points],
                    [0, 0, 1, 1, 2, 2, 3, 3])
    K, camera = capture.camera.K, capture.camera
    P = np.column_stack((K, np.zeros(3)))
    model = 'rational_polynomial' if len(camera.distortion) == 8 else 'plumb_bob'
    image = Image(header=header, height=height, width=width, encoding='rgba8', step=4 * width)
    set_data(image, cv2.cvtColor(pixels, cv2.COLOR_RGB2RGBA))
    info = CameraInfo(header=header, height=height, width=width, distortion_model=model,
                      d=camera.distortion.tolist(), k=K.ravel(), r=np.eye(3).ravel(),
                      p=P.ravel())
    cloud = PointCloud2(
        header=header, height=height, width=width, point_step=16, row_step=16 * width,
        fields=[PointField(name=name, offset=4 * index, count=1, datatype=kind)
                for index, (name, kind) in enumerate((
                    ('x', PointField.FLOAT32), ('y', PointField.FLOAT32),
                    ('z', PointField.FLOAT32), ('rgba', PointField.UINT32)))],
        is_dense=False)
    set_data(cloud, points)
    return image, info, cloud


def snr_to_message(capture: Capture) -> Image:
    """Return the signal-to-noise ratio of a capture that has one, as the vendor's node does."""
    assert capture.snr is not None
    height, width = capture.snr.shape
    return Image(header=Header(stamp=ns_to_stamp(capture.stamp_ns), frame_id=capture.frame_id),
                 height=height, width=width, encoding='32FC1', step=4 * width,
                 data=array('B', capture.snr.astype('<f4').tobytes()))
