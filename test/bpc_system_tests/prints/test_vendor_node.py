"""A print recorded with the vendor's own camera node, byte for byte as that publishes."""

from __future__ import annotations

from array import array
from dataclasses import replace
from pathlib import Path
import struct

import numpy as np
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
from bpc_sim.doubles.zivid import linear
from bpc_sim.printer.messages import extruder_message, robot_message
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_system_tests.parts.truth_of_prints import compare, expect_the_truth, pixel_size

pytestmark = [pytest.mark.system, pytest.mark.ros, pytest.mark.accuracy]
START_NS, SECOND = 1_790_000_000 * 10**9, 10**9


def in_linear_light(job: PrintJob) -> PrintJob:
    """A print seen by a camera that tells the light as it is: that is what its lens blurs."""
    imaging = job.sensor.imaging
    ink, bed = (tuple(linear(np.array(colour, np.uint8)).astype(float).tolist())
                for colour in (imaging.ink, imaging.bed))
    return replace(job, sensor=replace(job.sensor, imaging=replace(imaging, ink=ink, bed=bed)))


JOB = in_linear_light(SCENARIOS['spiral_gaps'](0.02))


def vendor_messages(capture: Capture) -> dict[str, object]:
    """Image, camera info, cloud and what else it sends at once (zivid_camera.cpp, 3.4.0)."""
    height, width = capture.image.shape[:2]
    header = Header(stamp=ns_to_stamp(capture.stamp_ns), frame_id='zivid_optical_frame')
    light = capture.image
    rgba = np.full((height, width, 4), 255, np.uint8)
    rgba[..., :3] = light
    points = np.zeros((height, width), [('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('rgba', '<u4')])
    for index, axis in enumerate('xyz'):
        points[axis] = capture.cloud[..., index]
    red, green, blue = (light[..., index].astype(np.uint32) for index in range(3))
    points['rgba'] = 255 << 24 | red << 16 | green << 8 | blue
    fields = [PointField(name=name, offset=4 * index, count=1, datatype=kind)
              for index, (name, kind) in enumerate((('x', 7), ('y', 7), ('z', 7), ('rgba', 6)))]
    K = capture.camera.K.ravel().tolist()
    info = CameraInfo(header=header, height=height, width=width, distortion_model='plumb_bob',
                      d=[0.0] * 5, k=K, r=np.eye(3).ravel().tolist(),
                      p=[*K[:3], 0.0, *K[3:6], 0.0, *K[6:], 0.0])
    depth = capture.cloud[..., 2].astype('<f4')
    return {
        topics.IMAGE: Image(header=header, height=height, width=width, encoding='rgba8',
                            step=4 * width, data=array('B', rgba.tobytes())),
        topics.CAMERA_INFO: info,
        topics.CLOUD: PointCloud2(
            header=header, height=height, width=width, fields=fields, is_bigendian=False,
            point_step=16, row_step=16 * width, is_dense=False,
            data=array('B', points.tobytes())),
        'depth/image': Image(header=header, height=height, width=width, encoding='32FC1',
                             step=4 * width, data=array('B', depth.tobytes())),
        'depth/camera_info': info,
        'snr/image': Image(header=header, height=height, width=width, encoding='32FC1',
                           step=4 * width, data=array('B', np.full_like(depth, 30.0).tobytes())),
        'snr/camera_info': info,
    }


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
        for name, message in messages.items():
            bag.add_topic(f'/zivid_camera/{name}', topics.type_name(type(message)))
        for name, kind in topics.PRINT.items():
            bag.add_topic(f'/{name}', topics.type_name(kind))
        for time in np.arange(0, t + 0.5, 0.01).tolist():
            stamp_ns = START_NS + round(time * SECOND)
            bag.write(f'/{topics.POSE}', stamp_ns, robot_message(JOB, time, stamp_ns))
            bag.write(f'/{topics.EXTRUSION}', stamp_ns, extruder_message(JOB, time, stamp_ns))
        for name, message in messages.items():
            bag.write(f'/zivid_camera/{name}', capture.stamp_ns + SECOND // 2, message)
    x, y, z = JOB.nozzle_offset.tolist()
    result, = measure_bag(Bag(tmp_path / 'bag'), HandEye(True, JOB.view.T_base_camera),
                          ThicknessConfig(), RecorderConfig(nozzle_offset=(x, y, z)))
    assert result.profile is not None, result.refusal
    compared = compare(result.profile, JOB)
    assert compared.s.max() > JOB.length - 1e-3
    expect_the_truth(compared, pixel_size(JOB))
