"""A print recorded with the vendor's camera node, byte for byte as that node publishes."""

from __future__ import annotations

from array import array
from dataclasses import replace
from pathlib import Path
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pytest
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from std_msgs.msg import Header

from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.messages import topics
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.recording.offline import measure_bag
from bpc_sim.doubles.srgb import srgb_to_linear
from bpc_sim.printer.messages import extruder_message, robot_message
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_system_tests.parts.print_comparison import compare, expect_the_truth, pixel_size

pytestmark = [pytest.mark.system, pytest.mark.ros, pytest.mark.accuracy]
START_NS, SECOND_NS = 1_790_000_000 * 10**9, 10**9


def in_linear_light(job: PrintJob) -> PrintJob:
    """Return a print seen by a camera with colours in proportion to the light.

    The lens blurs the light, not its sRGB values.
    """
    imaging = job.sensor.imaging
    ink, bed = (tuple(srgb_to_linear(np.array(colour, np.uint8)).astype(float).tolist())
                for colour in (imaging.ink, imaging.bed))
    return replace(job, sensor=replace(job.sensor, imaging=replace(imaging, ink=ink, bed=bed)))


JOB = in_linear_light(SCENARIOS['spiral_gaps'](0.02))


def vendor_messages(capture: Capture) -> dict[str, object]:
    """Return image, camera info, cloud and what else the node sends (zivid_camera.cpp, 3.4.0)."""
    header = Header(stamp=ns_to_stamp(capture.stamp_ns), frame_id='zivid_optical_frame')
    rgba = np.full((*capture.image.shape[:2], 4), 255, np.uint8)
    rgba[..., :3] = capture.image
    info = vendor_camera_info(header, capture)
    depth = capture.cloud[..., 2].astype('<f4')
    return {
        topics.IMAGE: vendor_image(header, 'rgba8', rgba),
        topics.CAMERA_INFO: info,
        topics.CLOUD: vendor_cloud(header, capture),
        'depth/image': vendor_image(header, '32FC1', depth),
        'depth/camera_info': info,
        'snr/image': vendor_image(header, '32FC1', np.full_like(depth, 30.0)),
        'snr/camera_info': info,
    }


def vendor_image(header: Header, encoding: str, pixels: NDArray[Any]) -> Image:
    """Return an image of pixels (H, W) or (H, W, C), four bytes each."""
    height, width = pixels.shape[:2]
    return Image(header=header, height=height, width=width, encoding=encoding, step=4 * width,
                 data=array('B', pixels.tobytes()))


def vendor_camera_info(header: Header, capture: Capture) -> CameraInfo:
    """Return the camera's intrinsics."""
    K = capture.camera.K.ravel().tolist()
    height, width = capture.image.shape[:2]
    return CameraInfo(header=header, height=height, width=width, distortion_model='plumb_bob',
                      d=[0.0] * 5, k=K, r=np.eye(3).ravel().tolist(),
                      p=[*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0])


def vendor_cloud(header: Header, capture: Capture) -> PointCloud2:
    """Return the coloured cloud."""
    height, width = capture.image.shape[:2]
    points = np.zeros((height, width), [('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('rgba', '<u4')])
    for index, axis in enumerate('xyz'):
        points[axis] = capture.cloud[..., index]
    red, green, blue = (capture.image[..., index].astype(np.uint32) for index in range(3))
    points['rgba'] = 255 << 24 | red << 16 | green << 8 | blue
    fields = [PointField(name=name, offset=4 * index, count=1, datatype=kind)
              for index, (name, kind) in enumerate((('x', 7), ('y', 7), ('z', 7), ('rgba', 6)))]
    return PointCloud2(header=header, height=height, width=width, fields=fields,
                       is_bigendian=False, point_step=16, row_step=16 * width, is_dense=False,
                       data=array('B', points.tobytes()))


def record(bag: BagWriter, messages: dict[str, object], capture_ns: int, end: float) -> None:
    """Write the messages of a capture, and robot and extruder up to a time [s] of the job."""
    for name, message in messages.items():
        bag.add_topic(f'/zivid_camera/{name}', topics.type_name(type(message)))
    for name, kind in topics.PRINT.items():
        bag.add_topic(f'/{name}', topics.type_name(kind))
    for time in np.arange(0, end, 0.01).tolist():
        stamp_ns = START_NS + round(time * SECOND_NS)
        bag.write(f'/{topics.POSE}', stamp_ns, robot_message(JOB, time, stamp_ns))
        bag.write(f'/{topics.EXTRUSION}', stamp_ns, extruder_message(JOB, time, stamp_ns))
    for name, message in messages.items():
        bag.write(f'/zivid_camera/{name}', capture_ns + SECOND_NS // 2, message)


def test_its_recording_is_measured_as_it_is(tmp_path: Path) -> None:
    t = JOB.duration
    capture = JOB.capture(t, 0, START_NS + round(t * 1e9))
    messages = vendor_messages(capture)
    first = bytes(messages[topics.CLOUD].data[:16])  # type: ignore[attr-defined]
    blue, green, red, alpha = first[12:]
    assert (red, green, blue) == tuple(capture.image[0, 0])
    assert alpha == 255
    np.testing.assert_array_equal(struct.unpack('<3f', first[:12]), capture.cloud[0, 0])
    with BagWriter(tmp_path / 'bag') as bag:
        record(bag, messages, capture.stamp_ns, t + 0.5)
    x, y, z = JOB.nozzle_offset.tolist()
    result, = measure_bag(Bag(tmp_path / 'bag'), HandEye(True, JOB.view.T_base_camera),
                          ThicknessConfig(), RecorderConfig(nozzle_offset=(x, y, z)))
    assert result.profile is not None, result.refusal
    compared = compare(result.profile, JOB)
    assert compared.s.max() > JOB.length - 1e-3
    expect_the_truth(compared, pixel_size(JOB))
