"""A long profile by parts: the thickness node sends them, and whoever follows knows the whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from node_builders import BASE, Bench, STAMP_NS, thickness_bench
import numpy as np
from perception_builders import pixel_path, SECOND
import pytest
from rclpy.node import Node

from bpc_interfaces.msg import ThicknessProfileUpdate
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.profile import profile_from_message
from bpc_perception.nodes.parts import profile_follower
from bpc_perception.nodes.parts.profile_follower import ProfileFollower

pytestmark = pytest.mark.ros


class Long:
    """A node that sends all but the first profile by parts."""

    def __init__(self, graph: Any, folder: Path) -> None:
        self.graph, self.captures = graph, 0
        self.bench: Bench = thickness_bench(graph, folder, longest_whole_profile=0)
        self.wholes = self.bench.received[topics.PROFILE]
        self.updates = self.bench.listen(topics.PROFILE_UPDATE, ThicknessProfileUpdate,
                                         topics.UPDATE_QOS)
        self.path = path_to_message(
            pixel_path((40, 55), (120, 55), 81, finished=False), BASE)
        self.bench.send(topics.PATH, self.path)

    def follow(self, name: str) -> list[ThicknessProfile]:
        """Return the list of profiles that a follower tells."""
        node, found = self.graph.make(Node, name), []
        follower = ProfileFollower(node, found.append, pytest.fail)
        self.bench.until(follower._client.service_is_ready)
        for topic in topics.PROFILE, topics.PROFILE_UPDATE:
            self.bench.until(lambda topic=topic: self.bench.node.count_subscribers(topic)
                             == self.bench.peer.count_subscribers(topic) > 1)
        return found

    def capture(self) -> int:
        """Have one more capture measured; return its stamp [ns]."""
        stamp_ns = STAMP_NS + self.captures * SECOND
        self.bench.send_capture(stamp_ns)
        self.captures += 1
        self.bench.until(lambda: len(self.bench.received[topics.ADVICE]) == self.captures)
        return stamp_ns


def test_who_follows_gets_each_profile_once(graph: Any, tmp_path: Path) -> None:
    long = Long(graph, tmp_path)
    found = long.follow('follower')
    stamps = [long.capture() for _ in range(4)]
    long.bench.until(lambda: len(found) == 4 and len(long.updates) == 3)
    assert [profile.stamp_ns for profile in found] == stamps
    assert len(long.wholes) == 1
    # What is seen again as it was is not sent again.
    assert all(len(update.index) < len(found[0]) for update in long.updates)
    answer = long.bench.call(topics.SEND_PROFILE)
    assert answer.success
    long.bench.until(lambda: len(long.wholes) == 2)
    whole = profile_from_message(long.wholes[-1])
    for name in 'time', 'thickness', 'sigma', 'status', 'seen_in', 'left_points':
        np.testing.assert_array_equal(getattr(found[-1], name), getattr(whole, name), name)


def test_who_comes_late_asks_for_the_whole(graph: Any, tmp_path: Path) -> None:
    long = Long(graph, tmp_path)
    long.capture()
    late = long.follow('late')
    stamp_ns = long.capture()
    long.bench.until(lambda: late)
    assert [profile.stamp_ns for profile in late] == [stamp_ns]
    assert len(late[0]) == len(long.path.time)


def test_from_the_end_on_the_whole_comes(graph: Any, tmp_path: Path) -> None:
    long = Long(graph, tmp_path)
    long.capture()
    long.capture()
    assert len(long.wholes) == 1
    long.path.finished = True
    long.bench.send(topics.PATH, long.path)
    long.bench.until(lambda: long.bench.node._ended)
    for number in (2, 3):  # also what is seen of it later
        stamp_ns = long.capture()
        long.bench.until(lambda number=number: len(long.wholes) == number)
        assert profile_from_message(long.wholes[-1]).stamp_ns == stamp_ns
    long.bench.node._clear()
    long.bench.until(lambda: len(long.wholes) == 4)
    assert long.wholes[-1].print_id == ''


def test_what_was_sent_by_parts_comes_whole_before_it_is_cleared(graph: Any,
                                                                 tmp_path: Path) -> None:
    long = Long(graph, tmp_path)
    stamps = [long.capture(), long.capture()]
    long.bench.node._clear()
    long.bench.until(lambda: len(long.wholes) == 3)
    assert [whole.print_id for whole in long.wholes] == ['print', 'print', '']
    assert profile_from_message(long.wholes[1]).stamp_ns == stamps[1]


def test_it_is_asked_again_where_no_answer_came(graph: Any, tmp_path: Path,
                                                monkeypatch: pytest.MonkeyPatch) -> None:
    """As where the node died with the request under way."""
    long = Long(graph, tmp_path)
    long.capture()
    monkeypatch.setattr(profile_follower, 'PATIENCE_S', 0.0)
    monkeypatch.setattr(long.bench.node._results._profiles, '_send_whole', lambda _: None)
    late = long.follow('late')
    long.capture()
    assert not late
    monkeypatch.undo()
    monkeypatch.setattr(profile_follower, 'PATIENCE_S', 0.0)
    long.capture()
    long.bench.until(lambda: late)


def test_without_a_print_there_is_no_whole_to_send(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path)
    answer = bench.call(topics.SEND_PROFILE)
    assert not answer.success
    assert 'found none measured; ask after' in answer.message
