"""What the diagnostics of a node publish, and how soon."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticStatus
from node_builders import extrusion, flange_pose, recorder_bench

from bpc_perception.messages import topics
from bpc_perception.messages.stamps import stamp_to_ns

pytestmark = pytest.mark.ros


def test_silence_of_an_input_is_said_at_once_and_until_it_is_over(graph: Any) -> None:
    """It does not wait for the diagnostics that come each second."""
    bench = recorder_bench(graph, watch__warn_after=0.2, watch__error_after=0.4)
    bench.timer.cancel()
    states = bench.received['/diagnostics']
    bench.until(lambda: states and states[-1].status[0].level == DiagnosticStatus.STALE)
    for number in range(20):
        bench.send(topics.POSE, flange_pose(0.1 * number))
        bench.send(topics.EXTRUSION, extrusion(0.1 * number, False))
    bench.until(lambda: states[-1].status[0].level == DiagnosticStatus.ERROR)
    levels = [state.status[0].level for state in states]
    ok, warn, error = (len(levels) - 1 - levels[::-1].index(level) for level in (
        DiagnosticStatus.STALE, DiagnosticStatus.WARN, DiagnosticStatus.ERROR))
    assert ok < warn < error == len(levels) - 1
    published = [state.header.stamp.sec + state.header.stamp.nanosec * 1e-9
                 for state in states[warn:]]
    assert published[-1] - published[0] < 0.9  # a period of the diagnostics is 1 s
    assert 'found lasting silence' in states[-1].status[0].message
    sent = 20

    def heard_again() -> bool:
        nonlocal sent
        sent += 1
        bench.send(topics.POSE, flange_pose(0.1 * sent))
        bench.send(topics.EXTRUSION, extrusion(0.1 * sent, False))
        return bool(states[-1].status[0].level == DiagnosticStatus.OK)

    bench.until(heard_again)


def test_a_second_fault_is_said_as_soon_as_the_first(graph: Any) -> None:
    """It is published even within the same second."""
    bench = recorder_bench(graph, watch__warn_after=0.2, watch__error_after=60.0)
    bench.timer.cancel()
    states = bench.received['/diagnostics']
    sent = 0

    def goes_on(*names: str) -> None:
        nonlocal sent
        sent += 1
        if topics.POSE in names:
            bench.send(topics.POSE, flange_pose(0.02 * sent))
        if topics.EXTRUSION in names:
            bench.send(topics.EXTRUSION, extrusion(0.02 * sent, False))

    def said(text: str, *names: str) -> float:
        """Return when the text was first published, while these inputs go on [s]."""
        before = len(states)

        def those() -> list[Any]:
            goes_on(*names)
            return [state for state in states[before:] if text in state.status[0].message]

        bench.until(those)
        return stamp_to_ns(those()[0].header.stamp) * 1e-9

    said('ok', topics.POSE, topics.EXTRUSION)
    silence = 'expected messages, found silence'
    first = said(f'{topics.EXTRUSION}: {silence}', topics.POSE)
    second = said(f'{topics.EXTRUSION}, {topics.POSE}: {silence}')  # the first goes on
    assert second - first < 0.8
    over = said('ok', topics.POSE, topics.EXTRUSION)
    assert over - second < 0.8
    bench.node._diagnostics.refuse('one: of a kind')
    bench.node._diagnostics.refuse('another: of a kind')
    refused = said('one: of a kind; another: of a kind', topics.POSE, topics.EXTRUSION)
    bench.node._diagnostics.refuse('new: of a kind')
    assert said('new: of a kind', topics.POSE, topics.EXTRUSION) - refused < 0.8
    bench.node._diagnostics.refuse('new: the same again')  # as often as messages come
    assert said('new: the same again', topics.POSE, topics.EXTRUSION) - refused > 0.9
