"""Printer and print controller of the closed loop in one process, with invented advice."""

from __future__ import annotations

import math

import pytest

from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.runtime.isolated_graph import Graph

pytest.importorskip('rclpy')
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from std_msgs.msg import Float64

from bpc_interfaces.msg import ExtrusionState, RateAdvice, RateSchedule
from bpc_perception.messages import topics
from bpc_sim.closed_loop.controllers import FLOW_SCALE, SPEED_SCALE
from bpc_sim.nodes.print_controller import PrintControllerNode
from bpc_sim.nodes.printer import SyntheticPrinterNode

pytestmark = pytest.mark.ros
SECOND_NS = 10**9


def now_ns(node: Node) -> int:
    return int(node.get_clock().now().nanoseconds)


def advice(stamp_ns: int, flow: float, lifetime: float) -> RateAdvice:
    message = RateAdvice(print_id='print', valid=True, reason=RateAdvice.UNDER_EXTRUSION,
                         flow_rate_scale=flow, speed_scale=1 / flow, confidence=1.0)
    message.header.stamp = ns_to_stamp(stamp_ns)
    message.valid_until = ns_to_stamp(stamp_ns + round(lifetime * SECOND_NS))
    return message


@pytest.mark.parametrize(('actuator', 'topic', 'factor'), [
    ('flow', FLOW_SCALE, 1.25), ('speed', SPEED_SCALE, 0.8)])
def test_the_controller_follows_advice_until_it_expires(
        graph: Graph, actuator: str, topic: str, factor: float) -> None:
    controller = graph.make(PrintControllerNode, actuator=actuator)
    peer = graph.make(Node, 'peer')
    scales: list[float] = []
    peer.create_subscription(Float64, topic, lambda message: scales.append(message.data), 10)
    publisher = peer.create_publisher(RateAdvice, topics.ADVICE, topics.RESULT_QOS)
    graph.spin_until(lambda: scales and controller.count_publishers(topics.ADVICE))
    assert set(scales) == {1.0}
    publisher.publish(advice(now_ns(peer), 1.25, 0.6))
    graph.spin_until(lambda: scales[-1] == pytest.approx(factor))
    graph.spin_until(lambda: scales[-1] == 1.0)
    assert all(scale == pytest.approx(1.0) or scale == pytest.approx(factor) for scale in scales)


def schedule(layer: int = 0, valid: bool = True, rising: float = 0.1) -> RateSchedule:
    """Factors from 1 up to 1.1 in 0.1 m, or none."""
    curve = {'place': [0.0, 0.1], 'factor': [1.0, 1.0 + rising], 'volume': [1e-6, 1e-6],
             'x': [0.0, 0.1], 'y': [0.0, 0.0], 'z': [0.0, 0.0]} if valid else {}
    return RateSchedule(layer=layer, valid=valid,
                        reason=RateSchedule.LEARNED if valid else RateSchedule.OTHER_PATH, **curve)


def test_the_controller_follows_advice_and_schedule_at_its_place(graph: Graph) -> None:
    controller = graph.make(PrintControllerNode)
    peer = graph.make(Node, 'peer')
    scales: list[float] = []
    peer.create_subscription(Float64, FLOW_SCALE, lambda message: scales.append(message.data), 10)
    publishers = {topic: peer.create_publisher(kind, topic, qos) for kind, topic, qos in (
        (RateAdvice, topics.ADVICE, topics.RESULT_QOS),
        (RateSchedule, topics.SCHEDULE, topics.SCHEDULE_QOS),
        (ExtrusionState, topics.EXTRUSION, topics.EXTRUSION_QOS),
        (PoseStamped, topics.POSE, topics.EXTRUSION_QOS))}
    graph.spin_until(lambda: scales and all(
        one.get_subscription_count() for one in publishers.values()))

    def move_to(x: float) -> None:
        pose = PoseStamped()
        pose.pose.position.x, pose.pose.orientation.w = x, 1.0
        publishers[topics.POSE].publish(pose)

    def expect(scale: float) -> None:
        graph.spin_until(lambda: scales[-1] == pytest.approx(scale, abs=1e-6))

    publishers[topics.ADVICE].publish(advice(now_ns(peer), 1.25, 60.0))
    expect(1.25)
    publishers[topics.SCHEDULE].publish(schedule())
    expect(1.0)  # the schedule has what advice had corrected
    move_to(-0.07)  # to the begin of the path
    publishers[topics.EXTRUSION].publish(ExtrusionState(extruding=True))
    graph.spin_until(lambda: controller._pushing and controller._flange[0] == -0.07)
    move_to(-0.02)
    expect(1.05)
    publishers[topics.ADVICE].publish(advice(now_ns(peer), 1.2, 60.0))
    expect(1.05 * 1.2)
    publishers[topics.SCHEDULE].publish(schedule(layer=1))  # not the layer that it prints
    expect(1.2)
    publishers[topics.SCHEDULE].publish(schedule(rising=9.0))
    expect(2.0)  # both together, no further than its limit
    publishers[topics.SCHEDULE].publish(schedule(valid=False))
    expect(1.0)


def test_the_controller_refuses_advice_without_a_meaning(graph: Graph) -> None:
    controller = graph.make(PrintControllerNode)
    peer = graph.make(Node, 'peer')
    publisher = peer.create_publisher(RateAdvice, topics.ADVICE, topics.RESULT_QOS)
    graph.spin_until(lambda: publisher.get_subscription_count())
    for spoiled in (math.nan, -1.0, 0.0, math.inf):
        message = advice(now_ns(peer), 1.25, 5.0)
        message.flow_rate_scale = spoiled
        publisher.publish(message)
    graph.spin_until(lambda: sum(controller._diagnostics._refusals.values()) == 4)
    assert controller._follower.scale(now_ns(controller), 0.0) == 1.0


def test_the_printer_extrudes_what_is_commanded_and_refuses_what_is_no_factor(
        graph: Graph) -> None:
    peer = graph.make(Node, 'peer')
    flows: list[float] = []

    def take(state: ExtrusionState) -> None:
        if state.extruding:
            flows.append(state.flow_rate)

    peer.create_subscription(ExtrusionState, topics.EXTRUSION, take, topics.EXTRUSION_QOS)
    publisher = peer.create_publisher(Float64, FLOW_SCALE, topics.RESULT_QOS)
    printer = graph.make(SyntheticPrinterNode, situation='noise_07', start_time_ns=now_ns(peer))
    graph.spin_until(lambda: flows and publisher.get_subscription_count())
    nominal = flows[0]
    publisher.publish(Float64(data=1.5))
    graph.spin_until(lambda: flows[-1] == pytest.approx(1.5 * nominal))
    for spoiled in (math.nan, math.inf, -1.0):
        publisher.publish(Float64(data=spoiled))
    graph.spin_until(lambda: sum(printer._diagnostics._refusals.values()) == 3)
    after = len(flows)
    graph.spin_until(lambda: len(flows) > after + 3)
    assert flows[after:] == pytest.approx([1.5 * nominal] * len(flows[after:]))
