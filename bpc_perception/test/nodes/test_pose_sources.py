"""The path of the nozzle from each source of flange poses."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from pathlib import Path
import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
from perception_builders import band_image, capture_of, DOWN, SECOND, START_NS
import pytest
from scipy.spatial.transform import Rotation

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PoseConfig, RecorderConfig, ThicknessConfig
from bpc_perception.core.parameter import ConfigError
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.robot.kinematics import JOINTS

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose, PoseStamped, Transform, TransformStamped
from node_builders import BASE, extrusion, NOZZLE
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from bpc_interfaces.msg import DepositionPath, ExtrusionState
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.poses.flange_poses import FlangePoses
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns
from bpc_perception.messages.types import message_type, MessageTypeError
from bpc_perception.nodes.path_recorder import PathRecorderNode
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.recording.offline import measure_bag

pytestmark = pytest.mark.ros
TIMES = np.arange(0.0, 3.0, 0.01)  # of poses at 100 Hz [s]
# With these angles the flange points straight down, 0.6 m in front of A1 and 0.56041 m above the
# base; turning A1 moves it along a circle (hardware data of the LBR Med 7).
ARM = np.radians((0.0, 30.0, 0.0, -60.0, 0.0, 90.0, 0.0))
RADIUS, HEIGHT = 0.6, 0.56041
TURN_RATE = 0.02  # of A1 [rad/s]; 12 mm/s at the flange


def joint_state(time: float) -> JointState:
    """Joint states as joint_state_broadcaster may send them: any order, a prefix, more joints."""
    angles = ARM.copy()
    angles[0] = TURN_RATE * time
    names = [f'lbr_{joint}' for joint in reversed(JOINTS)]
    message = JointState(name=['gripper', *names],
                         position=array('d', [0.01, *angles[::-1].tolist()]))
    message.header.stamp = ns_to_stamp(START_NS + round(time * SECOND))
    return message


class Rig:
    """A path recorder, and a robot and an extruder that talk to it."""

    def __init__(self, graph: Any, **parameters: Any) -> None:
        self.graph = graph
        self.recorder = graph.make(PathRecorderNode, nozzle_offset=NOZZLE, publish_rate=50.0,
                                   **parameters)
        self.peer: Node = graph.make(Node, 'peer')
        self.paths: list[DepositionPath] = []
        self.said: list[str] = []
        self.peer.create_subscription(
            DepositionPath, topics.PATH, self.paths.append, topics.PATH_QOS)
        self.peer.create_subscription(
            DiagnosticArray, '/diagnostics',
            lambda array: self.said.extend(status.message for status in array.status), 100)
        self.peer.create_timer(0.1, self.recorder._diagnostics.publish)
        self.extruder = self.publisher(ExtrusionState, topics.EXTRUSION, topics.EXTRUSION_QOS)

    def publisher(self, kind: Any, topic: str, qos: QoSProfile) -> Any:
        publisher = self.peer.create_publisher(kind, topic, qos)
        self.graph.spin_until(publisher.get_subscription_count)
        return publisher

    def print(self, publish: Callable[[float], None]) -> DepositionPath:
        """Send the poses of three seconds; return the path."""
        self.extruder.publish(extrusion(0.0))
        self.graph.spin_until(lambda: self.paths)
        # Half a second at a time: none is far behind the other, however busy the machine is.
        for times in np.split(TIMES, 6):
            for time in times.tolist():
                self.extruder.publish(extrusion(time))
                publish(time)
            reached = times[-1] - 0.2
            self.graph.spin_until(
                lambda reached=reached: self.paths[-1].complete_until > reached)
        return self.paths[-1]


def test_joint_states_become_the_path(graph: Any) -> None:
    rig = Rig(graph, pose__source='joint_states', pose__robot='lbr_med_7')
    robot = rig.publisher(JointState, topics.JOINTS, topics.POSE_QOS)
    path = rig.print(lambda time: robot.publish(joint_state(time)))
    x, y, z, time = (np.array(values) for values in (path.x, path.y, path.z, path.time))
    # Smoothing over 0.1 s cuts the circle by far less than a micrometre.
    np.testing.assert_allclose(np.hypot(x, y), RADIUS, atol=1e-6)
    np.testing.assert_allclose(z, HEIGHT - NOZZLE[2], atol=5e-6)  # known to five digits
    np.testing.assert_allclose(np.arctan2(y, x), TURN_RATE * time, atol=1e-5)


def test_other_devices_may_publish_their_joints_beside_the_arm(graph: Any) -> None:
    rig = Rig(graph, pose__source='joint_states', pose__robot='lbr_med_7')
    robot = rig.publisher(JointState, topics.JOINTS, topics.POSE_QOS)
    plunger = rig.publisher(JointState, topics.JOINTS, topics.POSE_QOS)

    def publish(time: float) -> None:
        robot.publish(joint_state(time))
        for _ in range(2):  # so that their numbers part
            plunger.publish(JointState(name=['plunger'], position=[0.01]))

    path = rig.print(publish)
    assert len(path.x) > 150
    assert not any('expected messages of one publisher' in text for text in rig.said)
    assert not any('expected each of A1' in text for text in rig.said)


def test_joint_states_without_the_joints_are_refused(graph: Any) -> None:
    rig = Rig(graph, pose__source='joint_states', pose__robot='lbr_med_7')
    robot = rig.publisher(JointState, topics.JOINTS, topics.POSE_QOS)
    short, unstamped = joint_state(0.1), joint_state(0.2)
    short.name, short.position = short.name[:-1], short.position[:-1]
    unstamped.header.stamp = ns_to_stamp(0)
    robot.publish(short)
    rig.graph.spin_until(lambda: any('expected each of A1' in text for text in rig.said))
    robot.publish(unstamped)
    rig.graph.spin_until(lambda: any('expected a stamp, found 0' in text for text in rig.said))


@pytest.mark.parametrize('rotation', ['xyz', 'zyx'])
def test_a_swinging_flange_leaves_the_path_where_the_tip_is(graph: Any, rotation: str) -> None:
    """150 mm of nozzle, 30 degrees of rotation to each side, a straight line at the tip."""
    rig = Rig(graph)
    robot = rig.publisher(PoseStamped, topics.POSE, topics.EXTRUSION_QOS)

    def publish(time: float) -> None:
        T = np.eye(4)
        T[:3, :3] = np.diag((1.0, -1.0, -1.0)) @ Rotation.from_euler(
            rotation, np.radians(30) * np.sin(2 * time + np.arange(3))).as_matrix()
        T[:3, 3] = np.array((0.5 + 0.01 * time, 0.1, 0.02)) - T[:3, :3] @ NOZZLE
        robot.publish(pose_to_message(START_NS + round(time * SECOND), BASE, T))

    path = rig.print(publish)
    found = np.stack((path.x, path.y, path.z))
    true = np.stack(np.broadcast_arrays(0.5 + 0.01 * np.array(path.time), 0.1, 0.02))
    assert np.linalg.norm(found - true, axis=0).max() < 5e-5


def test_a_pose_without_stamp_is_taken_as_of_its_receipt_and_warned_about(graph: Any) -> None:
    rig = Rig(graph, pose__source='pose', path__auto=False)
    robot = rig.publisher(Pose, topics.POSE, topics.POSE_QOS)
    taken: list[tuple[int, Array]] = []
    rig.recorder._tracker.add_pose = lambda stamp, tip: taken.append((stamp, tip)) or True
    before = rig.recorder.get_clock().now().nanoseconds
    T = np.eye(4)
    T[:3, 3] = (0.1, 0.2, 0.3)
    robot.publish(pose_to_message(0, BASE, T).pose)
    rig.graph.spin_until(lambda: taken)
    assert before < taken[0][0] < rig.recorder.get_clock().now().nanoseconds
    np.testing.assert_allclose(taken[0][1], (0.1, 0.2, 0.45))
    rig.graph.spin_until(lambda: any('expected a stamp, found none' in text for text in rig.said))


def test_a_robot_of_unknown_model_is_refused(graph: Any) -> None:
    with pytest.raises(ConfigError, match=r'pose\.robot: expected one of lbr_med_7'):
        graph.make(PathRecorderNode, pose__source='joint_states')


# There is no wheel of tf2. Its stand-in has the names and errors of tf2_ros.


class TransformException(Exception):
    """Stands in for the one of tf2_ros."""


@pytest.fixture
def tf(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[TransformStamped]]:
    """Stand in for tf2: the list has the newest transform, or nothing as long as there is none."""
    newest: list[TransformStamped] = []

    class Buffer:
        def lookup_transform(self, target: str, source: str, time: Any) -> TransformStamped:
            assert (target, source, time.nanoseconds) == (BASE, 'lbr_link_ee', 0)
            if not newest:
                raise TransformException(f'"{target}" passed to lookupTransform does not exist')
            return newest[-1]

    module = ModuleType('tf2_ros')
    module.Buffer = Buffer
    module.TransformListener = lambda *_: None
    module.TransformException = TransformException
    monkeypatch.setitem(sys.modules, 'tf2_ros', module)
    return newest


def test_tf_is_followed_where_it_is_installed(graph: Any, tf: list[TransformStamped]) -> None:
    rig = Rig(graph, pose__source='tf', path__auto=False)
    taken: list[tuple[int, Array]] = []
    rig.recorder._tracker.add_pose = lambda stamp, tip: taken.append((stamp, tip)) or True
    rig.graph.spin_until(lambda: any(
        'expected lbr_link_ee in lbr_link_0' in text for text in rig.said))
    for index in range(3):
        message = TransformStamped(transform=Transform())
        message.header.stamp = ns_to_stamp(START_NS + index)
        message.transform.translation.x = 0.1 * index
        tf.append(message)
        rig.graph.spin_until(lambda: taken and taken[-1][0] == stamp_to_ns(tf[-1].header.stamp))
    assert [stamp for stamp, _ in taken] == [START_NS, START_NS + 1, START_NS + 2]  # each once
    np.testing.assert_allclose(taken[-1][1], (0.2, 0.0, 0.15))


def test_tf_is_refused_where_it_is_not_installed(
        graph: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'tf2_ros', None)
    with pytest.raises(ValueError, match=r'pose\.source: expected tf2_ros to be installed'):
        graph.make(PathRecorderNode, pose__source='tf')


# There is no wheel of LBRState either. Its stand-in has the fields of the message.


@pytest.fixture
def lbr(monkeypatch: pytest.MonkeyPatch) -> Iterator[FlangePoses]:
    module = ModuleType('lbr_fri_idl.msg')
    module.LBRState = SimpleNamespace
    monkeypatch.setitem(sys.modules, 'lbr_fri_idl.msg', module)
    monkeypatch.setitem(sys.modules, 'lbr_fri_idl', ModuleType('lbr_fri_idl'))
    poses = FlangePoses(PoseConfig(source='lbr_state', robot='lbr_med_7'), BASE)
    assert (poses.topic, poses.message_class) == ('lbr_state', SimpleNamespace)
    yield poses
    message_type.cache_clear()


def lbr_state(time: float, angles: Array = ARM) -> SimpleNamespace:
    """An LBRState. The clock of the controller shows the seconds since it was switched on."""
    return SimpleNamespace(time_stamp_sec=int(time), time_stamp_nano_sec=round(time % 1 * SECOND),
                           measured_joint_position=array('d', angles.tolist()))


def test_lbr_states_are_put_on_our_clock(lbr: FlangePoses) -> None:
    lbr.read(lbr_state(100.0), START_NS)
    # 10 ms later by the clock of the controller, and delayed by 7 ms on the way.
    stamp_ns, T = lbr.read(lbr_state(100.01), START_NS + 17 * 10**6)
    assert stamp_ns == START_NS + 10 * 10**6
    np.testing.assert_allclose(T[:3, 3], (RADIUS, 0, HEIGHT), atol=5e-6)


def test_lbr_states_without_angles_are_refused(lbr: FlangePoses) -> None:
    with pytest.raises(ConversionError, match='lbr_state: joints: expected 7 finite'):
        lbr.read(lbr_state(0, np.full(7, np.nan)), START_NS)


def test_lbr_states_are_refused_where_they_are_not_installed(
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'lbr_fri_idl', None)
    monkeypatch.setitem(sys.modules, 'lbr_fri_idl.msg', None)
    with pytest.raises(MessageTypeError,
                       match='expected one that is installed, found lbr_fri_idl'):
        FlangePoses(PoseConfig(source='lbr_state', robot='lbr_med_14'), BASE)


def test_a_recording_of_joint_states_is_measured(tmp_path: Path) -> None:
    """The arm draws 36 mm of a circle, and the camera looks down on the ink."""
    with BagWriter(tmp_path / 'bag') as bag:
        for name, kind in {**topics.CAMERA, topics.EXTRUSION: ExtrusionState,
                           topics.JOINTS: JointState}.items():
            bag.add_topic(f'/lbr/{name}', topics.type_name(kind))
        for time in TIMES.tolist():
            log_ns = START_NS + round(time * SECOND)
            bag.write(f'/lbr/{topics.EXTRUSION}', log_ns, extrusion(time))
            bag.write(f'/lbr/{topics.JOINTS}', log_ns, joint_state(time))
        stamp_ns = START_NS + 2 * SECOND
        capture = capture_of(band_image(rows=(0, 119), columns=(75, 84)), stamp_ns)
        for name, message in zip(topics.CAMERA, capture_to_messages(capture), strict=True):
            bag.write(f'/lbr/{name}', START_NS + 3 * SECOND, message)
    # The middle of the strip goes below the circle's start, at x = 0.6 and y = 0.
    T_base_camera = DOWN.copy()
    T_base_camera[0, 3] += RADIUS
    recorder = RecorderConfig(pose=PoseConfig(source='joint_states', robot='lbr_med_7'),
                              nozzle_offset=(0.0, 0.0, HEIGHT - 5e-4))
    result, = measure_bag(Bag(tmp_path / 'bag'), HandEye(True, T_base_camera),
                          ThicknessConfig(), recorder)
    assert result.profile is not None, result.refusal
    measured = result.profile.thickness[np.isfinite(result.profile.thickness)]
    assert len(measured) > 30
    np.testing.assert_allclose(measured, 10 * 2e-4, atol=5e-5)
    with pytest.raises(BagError, match='expected one topic end_effector_pose'):
        list(measure_bag(Bag(tmp_path / 'bag'), HandEye(True, T_base_camera),
                         ThicknessConfig(), RecorderConfig()))
