"""What the fuzzer feeds: everything that reads bytes which others wrote.

Each target is given spoiled copies of its seeds. It may raise what its reader documents, which is
what ``refused`` holds, and nothing else.
"""

from __future__ import annotations

from binascii import crc_hqx
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
import shutil
from typing import Any

from geometry_msgs.msg import PoseStamped
import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2
from std_msgs.msg import String
import ticlib

from bpc_interfaces.msg import (
    DepositionPath as DepositionPathMsg,
    ExtrusionState,
    RateAdvice,
    ThicknessProfile,
)
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.config import (
    CameraConfig,
    ExtruderConfig,
    PlungerConfig,
    RecorderConfig,
    ThicknessConfig,
)
from bpc_perception.core.extruder.plunger import Plunger
from bpc_perception.core.extruder.tic import ExtruderError, format_line, TicState
from bpc_perception.core.parameter import ConfigError
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tracker import PrintTracker
from bpc_perception.core.profile import Status
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Session
from bpc_perception.drivers.extruder import SerialExtruder, TicExtruder
from bpc_perception.files.hand_eye_file import HandEyeError, load_hand_eye
from bpc_perception.files.parameter_file import configure, ParameterFileError
from bpc_perception.messages import topics
from bpc_perception.messages.advice import advice_from_message
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.capture_pairing import CapturePairer
from bpc_perception.messages.extruder import (
    extruder_from_message,
    extruder_to_message,
    joint_motion,
)
from bpc_perception.messages.path import path_from_message, path_to_message
from bpc_perception.messages.pose import joints_to_matrix, pose_to_matrix
from bpc_perception.messages.profile import profile_from_message, profile_to_message
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.bag_writer import BagWriter
from bpc_system_tests.parts.command_line import ROOT, SAMPLE

Run = Callable[[bytes], object]


@dataclass(frozen=True)
class Target:
    """A reader under test.

    Attributes:
        seeds: good inputs.
        run: reads one input.
        refused: the errors that it documents.
        text: whether inputs are text, and spoiled by words rather than by bytes.
        cost: how much longer one takes than the quickest target's, or about.
    """

    seeds: list[bytes]
    run: Run
    refused: tuple[type[Exception], ...]
    text: bool = False
    cost: int = 1


def targets(folder: Path) -> dict[str, Target]:
    """All of them; their files go into this folder, best one in memory."""
    return {
        'bag': Target(mcap_seeds(folder), read_bag(folder), (BagError,), cost=4),
        'sqlite bag': Target([sqlite_seed(folder)], read_sqlite(folder), (BagError,), cost=20),
        'calibration': Target(calibrations(), by_file(folder / 'a.calib', load_hand_eye),
                              (HandEyeError,), text=True, cost=4),
        'parameters': Target(parameter_files(), by_file(folder / 'params.yaml', read_parameters),
                             (ParameterFileError, ConfigError), text=True, cost=16),
        'targets': Target([b'arc_length_mm,thickness_mm\n0,2\n10.5,2.5\n10.5,1e0\n'],
                          by_file(folder / 'targets.csv', WidthTargets.read), (ValueError,),
                          text=True),
        'extruder line': Target(lines(), read_line, ()),
        'tic': Target([tic_answers()], read_tic, ()),
        'messages': Target(message_seeds(), read_message, (ConversionError,)),
        'captures': Target(capture_seeds(), measure_capture, (), cost=40),
    }


def by_file(file: Path, read: Callable[[Path], object]) -> Run:
    """A reader of files as one of bytes."""
    def run(data: bytes) -> object:
        file.write_bytes(data)
        return read(file)
    return run


# Recordings


def small_capture() -> Capture:
    """A dark band on a light bed, 40 pixels wide, on a plane half a metre away."""
    image = np.full((32, 40, 3), 200, np.uint8)
    image[12:20] = 40
    v, u = np.mgrid[:32, :40]
    cloud = np.stack(((u - 20) * 2e-4, (v - 16) * 2e-4, np.full(u.shape, 0.5)), -1)
    return Capture(5 * 10**9, 'camera', image, cloud.astype(np.float32),
                   PinholeCamera(np.array(((2500.0, 0, 20), (0, 2500.0, 16), (0, 0, 1))),
                                 np.zeros(5), 40, 32))


def straight_path() -> DepositionPath:
    """Along the band, in the frame of the camera."""
    count = 30
    s = np.arange(count) * 2e-4
    return DepositionPath('print', 10**9, 10.0, True, s * 100, s,
                          np.column_stack((s - 3e-3, np.zeros(count), np.full(count, 0.5))),
                          np.full(count, 1e-5), np.full(count, 1e-9), np.ones(count, bool))


def recorded() -> list[tuple[str, Any]]:
    """What a recording holds: topic, message."""
    pose = PoseStamped()
    pose.header.frame_id = 'lbr_link_0'
    pose.pose.orientation.w = 1.0
    joints = JointState(name=[f'lbr_A{number}' for number in range(1, 8)], position=[0.1] * 7,
                        velocity=[0.0] * 7)
    return [(topics.POSE, pose), (topics.JOINTS, joints), (topics.EXTRUSION, ExtrusionState()),
            (topics.PATH, path_to_message(straight_path(), 'lbr_link_0')),
            *zip(topics.CAMERA, capture_to_messages(small_capture()), strict=True)]


def mcap_seeds(folder: Path) -> list[bytes]:
    """A recording of ours, another with compressed chunks, a torn one, and one of lz4."""
    seeds = []
    for compress in (False, True):
        with BagWriter(folder / f'seed_{compress}', compress=compress) as writer:
            for name, message in recorded():
                writer.add_topic(f'/{name}', topics.type_name(type(message)))
            for number, (name, message) in enumerate(recorded()):
                writer.write(f'/{name}', number, message)
                writer.flush()
        file, = Bag(writer.path).files
        seeds.append(file.read_bytes())
    return [*seeds, seeds[0][:len(seeds[0]) // 2]]


def read_bag(folder: Path) -> Run:
    """Open a recording and read all of it."""
    file = folder / 'spoiled.mcap'

    def run(data: bytes) -> object:
        file.write_bytes(data)
        bag = Bag(file)
        bag.span()
        return sum(1 for _ in bag.messages(set(bag.topics)))
    return run


def sqlite_seed(folder: Path) -> bytes:
    """Database and metadata, one behind the other."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    text = store.types['std_msgs/msg/String']
    with Writer(folder / 'sqlite', version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection('/words', 'std_msgs/msg/String', typestore=store)
        for number in range(3):
            writer.write(connection, number, bytes(store.serialize_cdr(
                text(data=f'word {number}'), 'std_msgs/msg/String')))
    database, = (folder / 'sqlite').glob('*.db3')
    return (folder / 'sqlite' / 'metadata.yaml').read_bytes() + SEPARATOR + database.read_bytes()


SEPARATOR = b'\n# end of metadata\n'


def read_sqlite(folder: Path) -> Run:
    """Open a recording of rosbag2's other kind and read all of it."""
    bag = folder / 'spoiled'

    def run(data: bytes) -> object:
        metadata, _, database = data.partition(SEPARATOR)
        shutil.rmtree(bag, ignore_errors=True)
        bag.mkdir()
        (bag / 'metadata.yaml').write_bytes(metadata)
        (bag / 'sqlite.db3').write_bytes(database)
        opened = Bag(bag)
        return sum(1 for _ in opened.messages(set(opened.topics)))
    return run


# Text


def calibrations() -> list[bytes]:
    """One of each form."""
    return [
        (SAMPLE / 'hand_eye.calib').read_bytes(),
        b'parameters: {eye_on_hand: true}\n'
        b'transformation: {x: 0.1, y: 0, z: 0.2, qx: 0, qy: 0, qz: 0, qw: 1}\n',
        b'calibration_type: eye_in_hand\nunit: mm\nFloatMatrix:\n  Data:\n'
        b'  - [1, 0, 0, 10]\n  - [0, 1, 0, 20]\n  - [0, 0, 1, 30]\n  - [0, 0, 0, 1]\n',
        b'calibration_type: eye_on_base\nunit: m\nxyz: [0.1, 0.2, 0.3]\n'
        b'quaternion: [0, 0, 0, 1]\n']


def parameter_files() -> list[bytes]:
    """The shipped ones and that of the sample."""
    shipped = ROOT / 'bpc_perception' / 'config'
    return [(SAMPLE / 'params.yaml').read_bytes(),
            (shipped / 'path_recorder.yaml').read_bytes(),
            b'/**:\n  ros__parameters:\n    path.spacing: 0.0002\n'
            b'thickness:\n  ros__parameters:\n    method: paper\n'
            b'    advice: {target_thickness: 0.002, target_file: ""}\n']


def read_parameters(file: Path) -> object:
    """What it says to each node."""
    return [configure(default, node, file) for default, node in (
        (ThicknessConfig(), 'thickness'), (RecorderConfig(), 'path_recorder'),
        (CameraConfig(), 'camera_driver'), (ExtruderConfig(), 'extruder_bridge'))]


# Extruders


def lines() -> list[bytes]:
    """What an Arduino sends."""
    states = [TicState(time * 10**6, -500 + time, 2000000, 3, vin_mv=12000)
              for time in (0, 20, 40)]
    return [b''.join(map(format_line, states)), format_line(states[1])]


class FakeLine:
    """A serial line on which these bytes come, in pieces."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    @property
    def in_waiting(self) -> int:
        return min(len(self._data), 37)

    def read(self, size: int = 1) -> bytes:
        data, self._data = self._data[:size], self._data[size:]
        return data

    def write(self, data: bytes) -> int:
        return len(data)

    def reset_input_buffer(self) -> None:
        pass

    def close(self) -> None:
        pass


PLUNGER = PlungerConfig(lead=0.8e-3, bore=14e-3)


def publish(state: TicState, plunger: Plunger) -> None:
    """All that the bridge makes of a state, down to the bytes that it sends."""
    message = extruder_to_message(state.device_ns or 0, plunger.motion(state), state.error_status)
    serialize_message(message)
    extruder_from_message(message)


def read_line(data: bytes) -> object:
    """Lines as they come, and again with checksums that fit."""
    plunger = Plunger(PLUNGER)
    right = b'\n'.join(line.rpartition(b'*')[0] + b'*%04X' % crc_hqx(line.rpartition(b'*')[0], 0)
                       for line in data.split(b'\n'))
    for text in (data, b'\n' + right + b'\n'):
        refusals: list[object] = []
        extruder = SerialExtruder(FakeLine(text), refusals.append)
        for _ in range(len(text) // 37 + 1):
            for state in extruder.read():
                publish(state, plunger)
    return None


def tic_answers() -> bytes:
    """What a Tic answers to the four questions, three times."""
    motion = (1000).to_bytes(4, 'little') + (-20000).to_bytes(4, 'little', signed=True)
    status = bytes((10, 1, 0, 0, 0, 0, 0, 0))
    return b''.join(motion + status + b'\3' + b'\x10\x2e' + up_ms.to_bytes(4, 'little')
                    for up_ms in (1000, 1020, 1040))


class Answers(FakeLine):
    """A line on which bytes come as they are asked for, and no earlier."""

    @property
    def in_waiting(self) -> int:
        return 0


def read_tic(data: bytes) -> object:
    """A Tic on a serial line that answers these bytes."""
    line, plunger = Answers(data), Plunger(PLUNGER)
    refusals: list[object] = []
    extruder = TicExtruder(ticlib.TicSerial(line, None), line, refusals.append)
    for _ in range(3):
        try:
            for state in extruder.read():
                publish(state, plunger)
        except ExtruderError:
            return None
    return None


# Messages

KINDS = (Image, CameraInfo, PointCloud2, PoseStamped, JointState, ExtrusionState,
         DepositionPathMsg, ThicknessProfile, RateAdvice, String)


def serialized(message: Any) -> bytes:
    """The number of the kind, and the message."""
    return bytes((KINDS.index(type(message)),)) + bytes(serialize_message(message))


def message_seeds() -> list[bytes]:
    """One of each kind."""
    session = measured_session()
    result, = session.results(finish=True)
    assert result.profile is not None
    assert (result.profile.status == Status.MEASURED).any()
    return [serialized(message) for message in (
        *(message for _, message in recorded()), profile_to_message(result.profile, 'base'),
        RateAdvice(flow_rate_scale=1.0, speed_scale=1.0))]


def measured_session() -> Session:
    """A session that has a path and a capture that can be measured."""
    session = Session(ThicknessConfig(), HandEye(True, np.eye(4)))
    session.set_path(straight_path())
    session.add_capture(small_capture())
    return session


def message_of(data: bytes) -> Any:
    """The message in the bytes; None where the middleware would drop them."""
    try:
        return deserialize_message(data[1:], KINDS[data[0] % len(KINDS)])
    except Exception:  # rclpy raises whatever the type support throws
        return None


def read_message(data: bytes) -> object:
    """All that the nodes do with a message but the measurement."""
    message = message_of(data) if data else None
    if isinstance(message, PoseStamped):
        matrix = pose_to_matrix(message.pose)
        return PrintTracker(RecorderConfig().path).add_pose(0, matrix[:3, 3])
    if isinstance(message, JointState):
        joints_to_matrix(message, 'lbr_med_7')
        return joint_motion(message, 'lbr_A1')
    if isinstance(message, ExtrusionState):
        return PrintTracker(RecorderConfig().path).add_extruder(extruder_from_message(message))
    if isinstance(message, DepositionPathMsg):
        return path_from_message(message)
    if isinstance(message, ThicknessProfile):
        return profile_from_message(message)
    if isinstance(message, RateAdvice):
        return advice_from_message(message)
    return None


def capture_seeds() -> list[bytes]:
    """The three messages of a capture, each with its length."""
    parts = [serialized(message) for message in capture_to_messages(small_capture())]
    return [b''.join(len(part).to_bytes(4, 'little') + part for part in parts)]


def measure_capture(data: bytes) -> object:
    """All that the thickness node does with a capture. Raises AssertionError for a defect."""
    session, pairer = Session(ThicknessConfig(), HandEye(True, np.eye(4))), CapturePairer()
    session.set_path(straight_path())
    names = dict(zip((Image, CameraInfo, PointCloud2), topics.CAMERA, strict=True))
    while data:
        length = int.from_bytes(data[:4], 'little')
        message, data = message_of(data[4:4 + length] or b'\0'), data[4 + length:]
        if type(message) not in names:
            continue
        try:
            capture = pairer.add(names[type(message)], message)
        except ConversionError:
            continue
        if capture is not None:
            session.add_capture(capture)
    for result in session.results(finish=True):
        # This is how the session names an error that nobody foresaw.
        assert not result.refusal.startswith('measurement: expected a result'), result.refusal
        if result.profile is not None:
            serialize_message(profile_to_message(result.profile, 'base'))
    return None
