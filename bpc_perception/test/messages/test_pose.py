"""Poses from and to messages, and which messages are refused."""

from __future__ import annotations

from geometry_msgs.msg import Point, Pose, Quaternion
from message_builders import NAN, refused, STAMP_NS
import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.messages.poses.pose import pose_to_matrix, pose_to_message
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns

pytestmark = pytest.mark.ros


def test_a_pose_survives_there_and_back() -> None:
    T = pose((0.1, -0.2, 0.3), (100, 20, -30))
    message = pose_to_message(STAMP_NS, 'lbr_link_0', T)
    assert message.header.frame_id == 'lbr_link_0'
    assert stamp_to_ns(message.header.stamp) == STAMP_NS
    np.testing.assert_allclose(pose_to_matrix(message.pose), T, atol=1e-15)


@pytest.mark.parametrize(('position', 'orientation'), [
    ((NAN, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (NAN, 0.0, 0.0, 1.0)), ((0.0, np.inf, 0.0), (0.0, 0.0, 0.0, 1.0)),
    ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0)), ((520.0, -110.0, 30.0), (0.0, 0.0, 0.0, 1.0))])
def test_what_is_no_pose_is_refused(position: tuple[float, ...],
                                    orientation: tuple[float, ...]) -> None:
    with refused:
        pose_to_matrix(Pose(
            position=Point(**dict(zip('xyz', position, strict=True))),
            orientation=Quaternion(**dict(zip('xyzw', orientation, strict=True)))))


def test_a_pose_in_millimetres_is_called_that() -> None:
    with pytest.raises(ConversionError, match='is it in millimetres'):
        pose_to_matrix(Pose(position=Point(x=520.0, y=-110.0, z=30.0)))
