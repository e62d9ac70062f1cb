"""Clocks that jump back, and stamps of the future."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from perception_builders import SECOND
import pytest

pytest.importorskip('rclpy')
from node_builders import (
    assert_profile_comes,
    BEAD_PATH,
    extrusion,
    flange_pose,
    print_line,
    recorder_bench,
    STAMP_NS,
    thickness_bench,
)
from rosgraph_msgs.msg import Clock

from bpc_perception.messages import topics
from bpc_perception.messages.stamps import ns_to_stamp, stamp_to_ns

pytestmark = pytest.mark.ros
FUTURE_NS = (2**31 - 60) * SECOND  # near the largest stamp of a message


def test_poses_and_states_of_the_future_do_not_keep_out_those_that_follow(graph: Any) -> None:
    bench = recorder_bench(graph, watch__warn_after=0.0)
    bench.send(topics.POSE, flange_pose(0, start_ns=FUTURE_NS), flange_pose(0.1))
    bench.send(topics.EXTRUSION, extrusion(0, False, FUTURE_NS), extrusion(0.1, False))
    bench.until(lambda: bench.diagnosed('poses') == '1'
                and bench.diagnosed('extrusion states') == '1')
    assert bench.diagnosed('refused: pose') == '1'
    assert bench.diagnosed('refused: extrusion_state') == '1'
    assert 'found one of the future' in bench.diagnosed('last refusal')


def test_a_clock_that_goes_back_clears_the_print(graph: Any) -> None:
    bench = recorder_bench(graph, use_sim_time=True)

    def set_clock(seconds: int) -> None:
        bench.send('/clock', Clock(clock=ns_to_stamp(seconds * SECOND)), kind=Clock, qos=10)
        bench.until(lambda: bench.node.get_clock().now().nanoseconds == seconds * SECOND)

    set_clock(100)
    print_line(bench, start_ns=100 * SECOND)
    set_clock(101)
    assert bench.call('path_recorder/stop').success  # a print was running
    set_clock(50)
    assert 'found none started' in bench.call('path_recorder/save').message
    # Earlier stamps are taken again.
    paths = bench.received[topics.PATH]
    bench.send(topics.EXTRUSION, extrusion(0, start_ns=50 * SECOND))
    bench.until(lambda: stamp_to_ns(paths[-1].header.stamp) == 50 * SECOND)


def test_a_capture_of_the_future_is_refused(graph: Any, tmp_path: Path) -> None:
    """It would count ink as a gap that was laid after the capture, but before its stamp."""
    bench = thickness_bench(graph, tmp_path)
    bench.send(topics.PATH, BEAD_PATH)
    bench.send_capture(FUTURE_NS)
    bench.until(lambda: bench.diagnosed('refused: capture') == '1')
    assert 'found one of the future' in bench.diagnosed('last refusal')
    bench.send_capture(STAMP_NS)
    assert_profile_comes(bench, STAMP_NS)


def test_a_clock_that_goes_back_forgets_the_path(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, use_sim_time=True, patience=0.1)
    bench.send(topics.PATH, BEAD_PATH)
    for seconds in (100, 50):
        bench.send('/clock', Clock(clock=ns_to_stamp(seconds * SECOND)), kind=Clock, qos=10)
        bench.until(lambda seconds=seconds: bench.node.get_clock().now().nanoseconds
                    == seconds * SECOND)
    bench.send_capture(STAMP_NS)
    bench.until(lambda: bench.diagnosed('captures before a print') == '1')
    assert bench.received[topics.PROFILE] == []
