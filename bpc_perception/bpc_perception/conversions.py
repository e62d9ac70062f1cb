"""Between ROS messages and the core's types: the only place where the two meet.

What cannot be converted faithfully raises ConversionError, naming what was expected and found.
"""

from __future__ import annotations

from array import array
import math
from typing import Any

from builtin_interfaces.msg import Time
import cv2
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Transform
from nav_msgs.msg import Path
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2, PointField
from std_msgs.msg import Header

from bpc_interfaces.msg import (
    DepositionPath as DepositionPathMsg,
)
from bpc_interfaces.msg import (
    ExtrusionState,
)
from bpc_interfaces.msg import (
    RateAdvice as RateAdviceMsg,
)
from bpc_interfaces.msg import (
    ThicknessProfile as ThicknessProfileMsg,
)
from bpc_perception.core.advice import RateAdvice, Reason
from bpc_perception.core.capture import Capture, PinholeCamera
from bpc_perception.core.extruder import PlungerMotion
from bpc_perception.core.geometry import Array
from bpc_perception.core.kinematics import flange_pose, order_joints
from bpc_perception.core.path import DepositionPath
from bpc_perception.core.path_assembly import ExtruderSample
from bpc_perception.core.poses import pose_matrix
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.message_data import set_data

# Where red, green and blue lie in a pixel, and how many bytes it has.
IMAGE_ENCODINGS = {'rgba8': (slice(0, 3), 4), 'rgb8': (slice(0, 3), 3),
                   'bgr8': (slice(2, None, -1), 3), 'bgra8': (slice(2, None, -1), 4)}
NAV_POSES = 2000  # at most in a path to look at
# What advice says beyond its factors, under the same names in both forms.
ADVICE_DETAILS = ('reference_time', 'expected_thickness', 'delivery', 'delivery_sigma', 'lag',
                  'lag_sigma', 'flow_rate', 'plunger_velocity', 'speed')
DISTORTION_MODELS = {'': (0,), 'plumb_bob': (0, 4, 5), 'rational_polynomial': (8,)}


class ConversionError(ValueError):
    """A message is not what was expected; the text names both."""


def stamp_to_ns(stamp: Time) -> int:
    """Nanoseconds of a message's stamp."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def ns_to_stamp(stamp_ns: int) -> Time:
    """The message's form of a stamp [ns]."""
    return Time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)


def check_frame(name: str, message: Any, frame_id: str) -> None:
    """Raise ConversionError where a message is in another frame; an empty name is no other."""
    if message.header.frame_id not in ('', frame_id):
        raise ConversionError(f'{name}: expected frame {frame_id}, '
                              f'found {message.header.frame_id}')


def image_to_rgb(message: Image) -> NDArray[np.uint8]:
    """The image as a view RGB (H, W, 3), uint8."""
    if message.encoding not in IMAGE_ENCODINGS:
        raise ConversionError(f'image: expected encoding {", ".join(IMAGE_ENCODINGS)}, '
                              f'found "{message.encoding}"')
    channels, size = IMAGE_ENCODINGS[message.encoding]
    _check_layout('image', message, message.step, message.width * size)
    pixels: NDArray[np.uint8] = np.ndarray(
        (message.height, message.width, size), np.uint8, message.data,
        strides=(message.step, size, 1))
    return pixels[..., channels]


def cloud_to_xyz(message: PointCloud2) -> NDArray[np.float32]:
    """The points of an organized cloud as a view (H, W, 3), float32 [m]; NaN = none."""
    if message.height < 2:
        raise ConversionError('cloud: expected an organized cloud, found '
                              f'{message.width} x {message.height} points')
    offsets = []
    for name in ('x', 'y', 'z'):
        found = [field for field in message.fields if field.name == name]
        if not found or found[0].datatype != PointField.FLOAT32:
            raise ConversionError(f'cloud: expected a FLOAT32 field {name}, found '
                                  f'{[(field.name, field.datatype) for field in message.fields]}')
        offsets.append(found[0].offset)
    if max(offsets) + 4 > message.point_step:
        raise ConversionError(f'cloud: expected fields within point_step {message.point_step}, '
                              f'found offsets {offsets}')
    _check_layout('cloud', message, message.row_step, message.width * message.point_step)
    kind = np.dtype('>f4' if message.is_bigendian else '<f4')
    axes: list[NDArray[np.float32]] = [
        np.ndarray((message.height, message.width), kind, message.data, offset,
                   (message.row_step, message.point_step)) for offset in offsets]
    if offsets == [offsets[0], offsets[0] + 4, offsets[0] + 8] and not message.is_bigendian:
        return np.ndarray((message.height, message.width, 3), kind, message.data, offsets[0],
                          (message.row_step, message.point_step, 4))
    return np.stack(axes, axis=2).astype(np.float32)


def _check_layout(name: str, message: Any, step: int, least_step: int) -> None:
    if message.width == 0 or message.height == 0:
        raise ConversionError(f'{name}: expected pixels, found {message.width} x {message.height}')
    if step < least_step:
        raise ConversionError(f'{name}: expected rows of {least_step} bytes or more, found {step}')
    needed = step * (message.height - 1) + least_step
    if len(message.data) < needed:
        raise ConversionError(f'{name}: expected {needed} bytes of data, '
                              f'found {len(message.data)}')


def camera_from_info(message: CameraInfo) -> PinholeCamera:
    """The intrinsics of a calibrated camera."""
    K = np.array(message.k, np.float64).reshape(3, 3)
    if not (np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0):
        raise ConversionError(f'camera_info: expected a calibrated camera, found K {K.tolist()}')
    distortion = np.array(message.d, np.float64)
    lengths = DISTORTION_MODELS.get(message.distortion_model)
    if lengths is None or len(distortion) not in lengths or not np.isfinite(distortion).all():
        raise ConversionError('camera_info: expected plumb_bob with 5 or rational_polynomial '
                              f'with 8 finite coefficients, found "{message.distortion_model}" '
                              f'with {distortion.tolist()}')
    return PinholeCamera(K, distortion, message.width, message.height)


def capture_from_messages(image: Image, info: CameraInfo, cloud: PointCloud2) -> Capture:
    """The capture that image, camera info and cloud of one header make up."""
    stamps = [stamp_to_ns(message.header.stamp) for message in (image, info, cloud)]
    if len(set(stamps)) > 1:
        raise ConversionError('capture: expected one stamp for image, camera_info and cloud, '
                              f'found {stamps}')
    sizes = [(message.width, message.height) for message in (image, info, cloud)]
    if len(set(sizes)) > 1:
        raise ConversionError('capture: expected one size for image, camera_info and cloud, '
                              f'found {", ".join(f"{w} x {h}" for w, h in sizes)}')
    return Capture(stamps[0], cloud.header.frame_id, image_to_rgb(image), cloud_to_xyz(cloud),
                   camera_from_info(info))


def capture_to_messages(capture: Capture) -> tuple[Image, CameraInfo, PointCloud2]:
    """A capture as the messages of the vendor's node: rgba8, 16 bytes a point.

    The distortion is plumb_bob as there, unless it has the eight terms of rational_polynomial.
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
    """The signal-to-noise ratio of a capture that has one, as the vendor's node sends it."""
    assert capture.snr is not None
    height, width = capture.snr.shape
    return Image(header=Header(stamp=ns_to_stamp(capture.stamp_ns), frame_id=capture.frame_id),
                 height=height, width=width, encoding='32FC1', step=4 * width,
                 data=array('B', capture.snr.astype('<f4').tobytes()))


def pose_to_matrix(message: Pose) -> Array:
    """The 4x4 transform of a pose."""
    p, q = message.position, message.orientation
    try:
        return pose_matrix(np.array((p.x, p.y, p.z)), np.array((q.x, q.y, q.z, q.w)))
    except ValueError as error:
        raise ConversionError(str(error)) from error


def joints_to_matrix(message: JointState, robot: str) -> Array:
    """T_base_flange (4, 4) of a robot whose joints are among those of the message."""
    try:
        return flange_pose(robot, order_joints(message.name, message.position))
    except ValueError as error:
        raise ConversionError(f'joint_states: {error}') from error


def lbr_state_to_matrix(message: Any, robot: str) -> tuple[int, Array]:
    """Controller time [ns] and T_base_flange (4, 4) of an lbr_fri_idl/LBRState."""
    try:
        pose = flange_pose(robot, np.array(message.measured_joint_position, np.float64))
    except ValueError as error:
        raise ConversionError(f'lbr_state: {error}') from error
    return int(message.time_stamp_sec) * 10**9 + int(message.time_stamp_nano_sec), pose


def transform_to_matrix(message: Transform) -> Array:
    """The 4x4 transform of a tf2 transform."""
    t = message.translation
    return pose_to_matrix(Pose(position=Point(x=t.x, y=t.y, z=t.z),
                               orientation=message.rotation))


def pose_to_message(stamp_ns: int, frame_id: str, T_frame_body: Array) -> PoseStamped:
    """A stamped pose of a 4x4 transform."""
    x, y, z, w = Rotation.from_matrix(T_frame_body[:3, :3]).as_quat().tolist()
    px, py, pz = T_frame_body[:3, 3].tolist()
    return PoseStamped(
        header=Header(stamp=ns_to_stamp(stamp_ns), frame_id=frame_id),
        pose=Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=x, y=y, z=z, w=w)))


def extruder_from_message(message: ExtrusionState) -> ExtruderSample:
    """The part of the extruder's state that the path carries.

    What an extruder does that stopped with an error is not known.
    """
    if message.error_status:
        return ExtruderSample(stamp_to_ns(message.header.stamp), False, math.nan, math.nan)
    return ExtruderSample(stamp_to_ns(message.header.stamp), bool(message.extruding),
                          message.plunger_velocity, message.flow_rate)


def extruder_to_message(stamp_ns: int, motion: PlungerMotion,
                        error_status: int = 0) -> ExtrusionState:
    """The extruder's state as a message."""
    return ExtrusionState(
        header=Header(stamp=ns_to_stamp(stamp_ns)), extruding=motion.extruding,
        plunger_velocity=motion.velocity, plunger_position=motion.position,
        flow_rate=motion.flow_rate, error_status=error_status,
        position_uncertain=motion.position_uncertain)


def joint_motion(message: JointState, joint: str) -> tuple[float, float]:
    """Velocity [m/s] and position [m] of a prismatic joint; NaN = not told."""
    if joint not in message.name:
        raise ConversionError(f'{joint}: expected this joint, '
                              f'found {", ".join(message.name) or "none"}')
    index = list(message.name).index(joint)
    velocity, position = (float(values[index]) if len(values) > index else float('nan')
                          for values in (message.velocity, message.position))
    if not np.isfinite(velocity):
        raise ConversionError(f'{joint}: expected a velocity, found none')
    return velocity, position


def path_to_message(path: DepositionPath, frame_id: str) -> DepositionPathMsg:
    """A path in the robot base frame as a message."""
    return DepositionPathMsg(
        header=Header(stamp=ns_to_stamp(path.start_ns), frame_id=frame_id),
        print_id=path.print_id, complete_until=path.complete_until, finished=path.finished,
        time=_floats(path.time), arc_length=_floats(path.arc_length),
        **_axes('', path.points), plunger_velocity=_floats(path.plunger_velocity),
        flow_rate=_floats(path.flow_rate), extruding=path.extruding.tolist())


def path_from_message(message: DepositionPathMsg) -> DepositionPath:
    """A path from its message."""
    names = ('time', 'arc_length', 'x', 'y', 'z', 'plunger_velocity', 'flow_rate', 'extruding')
    _check_lengths('deposition_path', message, names)
    time, arc_length = np.array(message.time), np.array(message.arc_length)
    points = _points(message, '')
    if not (np.isfinite(points).all() and np.isfinite(time).all() and (np.diff(time) > 0).all()
            and np.isfinite(arc_length).all() and (np.diff(arc_length) >= 0).all()):
        raise ConversionError('deposition_path: expected finite points, and times and arc lengths '
                              'that increase, found others')
    return DepositionPath(
        print_id=message.print_id, start_ns=stamp_to_ns(message.header.stamp),
        complete_until=message.complete_until, finished=bool(message.finished), time=time,
        arc_length=arc_length, points=points,
        plunger_velocity=np.array(message.plunger_velocity),
        flow_rate=np.array(message.flow_rate), extruding=np.array(message.extruding, bool))


def path_to_nav(path: DepositionPath, frame_id: str) -> Path:
    """A path for RViz and Foxglove: positions, each with its time; orientation is not known.

    Of a long path only every n-th point, and the last: a pose is a slow thing in Python.
    """
    shown = np.arange(len(path) - 1, -1, -(len(path) // NAV_POSES + 1))[::-1]
    poses = []
    for time, (x, y, z) in zip(path.time[shown].tolist(), path.points[shown].tolist(),
                               strict=True):
        stamp = ns_to_stamp(path.start_ns + round(time * 1e9))
        poses.append(PoseStamped(header=Header(stamp=stamp, frame_id=frame_id),
                                 pose=Pose(position=Point(x=x, y=y, z=z))))
    return Path(header=Header(stamp=ns_to_stamp(path.start_ns), frame_id=frame_id), poses=poses)


def profile_to_message(profile: ThicknessProfile, frame_id: str) -> ThicknessProfileMsg:
    """A profile in the robot base frame as a message."""
    summary = profile.summary
    return ThicknessProfileMsg(
        header=Header(stamp=ns_to_stamp(profile.stamp_ns), frame_id=frame_id),
        print_id=profile.print_id, print_start=ns_to_stamp(profile.print_start_ns),
        capture=profile.capture, method=profile.method, time=_floats(profile.time),
        arc_length=_floats(profile.arc_length), **_axes('', profile.points),
        extruding=profile.extruding.tolist(), status=array('B', profile.status.tobytes()),
        thickness=_floats(profile.thickness), thickness_sigma=_floats(profile.sigma),
        left=_floats(profile.left), right=_floats(profile.right),
        **_axes('left_', profile.left_points), **_axes('right_', profile.right_points),
        thickness_mean=summary.thickness_mean, thickness_std=summary.thickness_std,
        thickness_q1=summary.thickness_q1, thickness_median=summary.thickness_median,
        thickness_q3=summary.thickness_q3, coverage=summary.coverage,
        gap_count=summary.gap_count, gap_length=summary.gap_length,
        offset_mean=summary.offset_mean, offset_rms=summary.offset_rms,
        processing_time=profile.processing_time)


def profile_from_message(message: ThicknessProfileMsg) -> ThicknessProfile:
    """A profile from its message; raises ConversionError for what no measurement gives."""
    axes = [side + axis for side in ('', 'left_', 'right_') for axis in 'xyz']
    _check_lengths('thickness_profile', message, (
        'time', 'arc_length', *axes, 'extruding', 'status', 'thickness', 'thickness_sigma',
        'left', 'right'))
    status, thickness = np.array(message.status, np.uint8), np.array(message.thickness)
    if (unknown := status[status > max(Status)]).size:
        raise ConversionError(f'thickness_profile: expected each status up to {max(Status)}, '
                              f'found {unknown[0]}')
    measured = thickness[status == Status.MEASURED]
    if (impossible := measured[~((measured > 0) & (measured < np.inf))]).size:
        raise ConversionError('thickness_profile: expected a thickness above 0 where it is '
                              f'measured, found {impossible[0]}')
    return ThicknessProfile(
        stamp_ns=stamp_to_ns(message.header.stamp), print_id=message.print_id,
        print_start_ns=stamp_to_ns(message.print_start), capture=message.capture,
        method=message.method, time=np.array(message.time),
        arc_length=np.array(message.arc_length), points=_points(message, ''),
        extruding=np.array(message.extruding, bool), status=status,
        thickness=thickness, sigma=np.array(message.thickness_sigma),
        left=np.array(message.left), right=np.array(message.right),
        left_points=_points(message, 'left_'), right_points=_points(message, 'right_'),
        processing_time=message.processing_time)


def advice_to_message(advice: RateAdvice) -> RateAdviceMsg:
    """Advice as a message."""
    return RateAdviceMsg(
        header=Header(stamp=ns_to_stamp(advice.stamp_ns)), print_id=advice.print_id,
        valid=advice.valid, reason=int(advice.reason), target_thickness=advice.target_thickness,
        measured_thickness=advice.measured_thickness, window_start=advice.window[0],
        window_end=advice.window[1], sample_count=advice.sample_count,
        flow_rate_scale=advice.flow_rate_scale, speed_scale=advice.speed_scale,
        confidence=advice.confidence, measurement_age=advice.measurement_age,
        valid_until=ns_to_stamp(advice.valid_until_ns),
        **{name: getattr(advice, name) for name in ADVICE_DETAILS})


def advice_from_message(message: RateAdviceMsg) -> RateAdvice:
    """Advice from its message."""
    if message.reason not in list(Reason):
        raise ConversionError(f'rate_advice: expected a reason up to {max(Reason)}, '
                              f'found {message.reason}')
    for name in ('flow_rate_scale', 'speed_scale'):
        if not 0 < getattr(message, name) < np.inf:
            raise ConversionError(f'rate_advice: expected a {name} above 0, '
                                  f'found {getattr(message, name)}')
    return RateAdvice(
        stamp_ns=stamp_to_ns(message.header.stamp), print_id=message.print_id,
        valid=bool(message.valid), reason=Reason(message.reason),
        target_thickness=message.target_thickness,
        measured_thickness=message.measured_thickness,
        window=(message.window_start, message.window_end), sample_count=message.sample_count,
        flow_rate_scale=message.flow_rate_scale, speed_scale=message.speed_scale,
        confidence=message.confidence, measurement_age=message.measurement_age,
        valid_until_ns=stamp_to_ns(message.valid_until),
        **{name: getattr(message, name) for name in ADVICE_DETAILS})


def _floats(values: Array) -> array[float]:
    return array('d', values.astype(np.float64).tobytes())


def _axes(prefix: str, points: Array) -> dict[str, array[float]]:
    return {prefix + axis: _floats(points[:, index]) for index, axis in enumerate('xyz')}


def _points(message: Any, prefix: str) -> Array:
    return np.column_stack([np.array(getattr(message, prefix + axis)) for axis in 'xyz'])


def _check_lengths(name: str, message: Any, fields: tuple[str, ...]) -> None:
    lengths = {field: len(getattr(message, field)) for field in fields}
    if len(set(lengths.values())) > 1:
        raise ConversionError(f'{name}: expected arrays of one length, found {lengths}')
