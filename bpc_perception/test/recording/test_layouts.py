"""Messages of another version of their type are read by the definition beside them."""

from __future__ import annotations

from collections.abc import Callable
import math
from typing import Any

import numpy as np
from perception_builders import START_NS
import pytest

pytest.importorskip('bpc_perception.recording.bag')
from geometry_msgs.msg import Point, Polygon, Pose, PoseStamped, Quaternion
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from bpc_interfaces.msg import ExtrusionState, RateAdvice
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.messages.types import message_definition, MessageTypeError
from bpc_perception.recording.layouts import reader_of
from bpc_perception.recording.storage.raw_message import Channel

pytestmark = pytest.mark.ros
STATE, JOINTS = 'bpc_interfaces/msg/ExtrusionState', 'sensor_msgs/msg/JointState'
POLYGON = 'geometry_msgs/msg/Polygon'
STAMPED = 'geometry_msgs/msg/PoseStamped'
POSE = Channel('/pose', STAMPED, message_definition(STAMPED).encode())


def recorded(kind: str, change: Callable[[str], str], **fields: Any) -> Any:
    """Return what is read of a message that another program wrote by another definition."""
    definition = change(message_definition(kind))
    types = get_types_from_msg(definition, kind)
    store = get_typestore(Stores.EMPTY)
    store.register(types)

    def made(name: str, values: dict[str, Any]) -> Any:
        return store.types[name](**{field: made(node[1], values.get(field, {}))
                                    if node[0].name == 'NAME' else values.get(field, zero(node))
                                    for field, node in types[name][1]})

    def zero(node: Any) -> Any:
        if node[0].name == 'BASE':
            return '' if node[1][0] == 'string' else 0
        return []

    data = bytes(store.serialize_cdr(made(kind, fields), kind))
    return reader_of(Channel('/topic', kind, definition.encode()))(data)


def without(*names: str) -> Callable[[str], str]:
    return lambda text: '\n'.join(line for line in text.split('\n')
                                  if not (line.split()[1:2] and line.split()[1] in names
                                          and not line.startswith('#')))


def test_a_message_of_the_installed_version_is_read() -> None:
    message = recorded(STATE, lambda text: text, flow_rate=2.5e-9, error_status=3)
    assert (message.flow_rate, message.error_status) == (2.5e-9, 3)


def test_comments_and_order_of_the_used_types_do_not_matter() -> None:
    message = recorded(STATE, lambda text: text.replace('#', '# !'), flow_rate=2.5e-9)
    assert message.flow_rate == 2.5e-9


def test_fields_of_a_later_version_are_what_its_type_says_and_never_a_number() -> None:
    message = recorded(STATE, without('error_status', 'position_uncertain', 'plunger_position'),
                       header={'frame_id': 'syringe'}, extruding=True, plunger_velocity=1e-3,
                       flow_rate=2.5e-9)
    assert message.header.frame_id == 'syringe'
    assert message.extruding
    assert (message.plunger_velocity, message.flow_rate) == (1e-3, 2.5e-9)
    assert math.isnan(message.plunger_position)
    assert (message.error_status, message.position_uncertain) == (0, False)
    assert isinstance(message, ExtrusionState)


def test_fields_that_a_later_version_added_in_between_are_left_out() -> None:
    message = recorded(STATE, lambda text: text.replace(
        'bool extruding\n', 'uint8 tool\nbool extruding\nfloat64[] pressures\n'),
        tool=2, extruding=True, pressures=np.array([1.0, 2.0]), flow_rate=2.5e-9)
    assert message.extruding
    assert message.flow_rate == 2.5e-9


def test_arrays_and_lists_are_read_in_another_version() -> None:
    joints = recorded(JOINTS, without('effort'), name=['a', 'b'], position=np.array([0.5, 1.5]),
                      velocity=np.empty(0))
    assert isinstance(joints, JointState)
    assert (joints.name, list(joints.position), list(joints.effort)) == (
        ['a', 'b'], [0.5, 1.5], [])
    store = get_typestore(Stores.ROS2_JAZZY)
    corner = store.types['geometry_msgs/msg/Point32']
    polygon = recorded(POLYGON, lambda text: text.replace('[] points', '[] points\nuint8 more'),
                       points=[corner(1.0, 2.0, 3.0), corner(4.0, 5.0, 6.0)], more=1)
    assert isinstance(polygon, Polygon)
    assert [(point.x, point.z) for point in polygon.points] == [(1.0, 3.0), (4.0, 6.0)]


@pytest.mark.parametrize(('kind', 'change', 'found'), [
    (STATE, lambda text: text.replace('float64 flow_rate', 'float64 rate'),
     'rate instead of flow_rate'),
    (STATE, lambda text: text.replace('float64 flow_rate', 'float32 flow_rate'),
     'flow_rate instead of flow_rate'),
    ('bpc_interfaces/msg/RateAdvice', lambda text: text.replace(
        'uint8 ON_TARGET = 0', 'uint8 ON_TARGET = 1'), 'ON_TARGET instead of ON_TARGET')])
def test_versions_that_contradict_each_other_are_refused(
        kind: str, change: Callable[[str], str], found: str) -> None:
    with pytest.raises(MessageTypeError, match=f'expected recordings .*{kind}, found .*{found}'):
        recorded(kind, change)


@pytest.mark.parametrize('definition', ['', '???', '= = =\nMSG: '])
def test_where_no_definition_can_be_read_the_installed_type_counts(definition: str) -> None:
    channel = Channel('/topic', 'bpc_interfaces/msg/RateAdvice', definition.encode())
    assert reader_of(channel)(serialize_message(RateAdvice(reason=3))).reason == 3


def stamped_pose(frame: str) -> PoseStamped:
    return PoseStamped(
        header=Header(stamp=ns_to_stamp(START_NS + 5), frame_id=frame),
        pose=Pose(position=Point(x=0.1, y=-0.2, z=math.nan),
                  orientation=Quaternion(x=0.5, y=-0.5, z=0.5, w=0.1)))


def fields(message: Any) -> str:
    """Return the values of a stamped pose."""
    stamp, p, q = message.header.stamp, message.pose.position, message.pose.orientation
    return repr((stamp.sec, stamp.nanosec, message.header.frame_id, p.x, p.y, p.z,
                 q.x, q.y, q.z, q.w))


@pytest.mark.parametrize('frame', ['', 'a', 'lbr_link_0', 'Flansch ä'])
def test_a_light_pose_has_the_fields_of_its_message(frame: str) -> None:
    message = stamped_pose(frame)
    light = reader_of(POSE, light=True)(serialize_message(message))
    assert not isinstance(light, PoseStamped)
    assert fields(light) == fields(message)


def test_a_pose_that_is_out_of_the_ordinary_is_read_as_by_rclpy() -> None:
    whole = serialize_message(stamped_pose('base'))
    big = get_typestore(Stores.ROS2_JAZZY)
    light = big.deserialize_cdr(whole, STAMPED)
    for data in (bytes(big.serialize_cdr(light, STAMPED, little_endian=False)), whole + b'longer',
                 whole.replace(b'base', b'\xff\xfe\xfd\xfc')):
        message = reader_of(POSE, light=True)(data)
        assert fields(message) == fields(deserialize_message(data, PoseStamped))


@pytest.mark.parametrize('damaged', [b'', b'\0\1\0\0', b'\7\7\7\7'])
def test_a_damaged_pose_is_refused(damaged: bytes) -> None:
    whole = serialize_message(stamped_pose('base'))
    for data in (damaged, damaged + whole[4:-9]):
        with pytest.raises(Exception):  # noqa: B017, PT011 (rclpy says which)
            reader_of(POSE, light=True)(data)
