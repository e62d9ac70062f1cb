"""Subscribe to flange poses, from the source that a node's parameters name."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.time import Time

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PoseConfig
from bpc_perception.messages import topics
from bpc_perception.messages.poses.flange_poses import FlangePoses
from bpc_perception.messages.poses.pose import transform_to_matrix
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.nodes.parts.single_source import subscribe_single_source
from bpc_perception.runtime.clock import expect_not_ahead
from bpc_perception.runtime.diagnostics import Diagnostics

TF_PERIOD_S = 0.01

TakePose = Callable[[int, Array], None]


def subscribe_poses(node: Node, config: PoseConfig, base_frame: str, maximum_lead: float,
                    diagnostics: Diagnostics, take: TakePose) -> None:
    """Hand stamp [ns] and T_base_flange (4, 4) [m] of every pose to ``take``.

    Messages that are no poses, or more than ``maximum_lead`` [s] in the future, are refused on
    ``diagnostics``, which also watches that poses come. Raises ValueError when the source needs a
    package that is not installed.
    """
    if config.source == 'tf':
        _follow_tf(node, config, base_frame, maximum_lead, diagnostics, take)
        return
    poses = FlangePoses(config, base_frame)
    warned: list[bool] = []
    diagnostics.expect(poses.topic)

    def received(message: Any) -> None:
        diagnostics.heard(poses.topic)
        try:
            stamp_ns, T_base_flange = poses.read(message, node.get_clock().now().nanoseconds)
            expect_not_ahead(node, 'pose', stamp_ns, maximum_lead)
        except ConversionError as error:
            diagnostics.refuse(error)
            return
        if config.source == 'pose' and not warned:
            warned.append(True)
            diagnostics.warn('pose: expected a stamp, found none; taken as of its receipt, so '
                             'that the path is late by the delay of the network'
                             '; rather publish a stamped pose')
        take(stamp_ns, T_base_flange)

    subscribe_single_source(
        node, poses.message_class, poses.topic, received, topics.POSE_QOS, diagnostics,
        poses.concerns, qos_overriding_options=QoSOverridingOptions.with_default_policies())


def _follow_tf(node: Node, config: PoseConfig, base_frame: str, maximum_lead: float,
               diagnostics: Diagnostics, take: TakePose) -> None:
    try:
        tf2_ros = import_module('tf2_ros')
    except ImportError as error:
        raise ValueError(f'pose.source: expected tf2_ros to be installed for tf, '
                         f'found: {error}; install it, or choose another pose.source') from error
    buffer = tf2_ros.Buffer()
    tf2_ros.TransformListener(buffer, node)  # kept alive by the node's subscriptions
    latest = [0]
    diagnostics.expect('/tf')

    def look() -> None:
        try:
            message = buffer.lookup_transform(base_frame, config.flange_frame, Time())
            pose = transform_to_matrix(message.transform)
            stamp_ns = stamp_to_ns(message.header.stamp)
            expect_not_ahead(node, 'pose', stamp_ns, maximum_lead)
        except (tf2_ros.TransformException, ConversionError) as error:
            diagnostics.refuse(f'tf: expected {config.flange_frame} in {base_frame}, '
                               f'found: {error}'
                               '; set base_frame and pose.flange_frame to frames of its tree')
            return
        if stamp_ns != latest[0]:
            latest[0] = stamp_ns
            diagnostics.heard('/tf')
            take(stamp_ns, pose)

    node.create_timer(TF_PERIOD_S, look)
