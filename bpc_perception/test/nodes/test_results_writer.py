"""The results writer as a node in this process."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
import time

import numpy as np
from perception_builders import profile_of
import pytest
from rclpy.node import Node

from bpc_interfaces.msg import ThicknessProfile
from bpc_perception.core.config import BASE, FLANGE
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.files.hand_eye_file import save_hand_eye
from bpc_perception.messages import topics
from bpc_perception.messages.profile import profile_to_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.nodes.results_writer import MOST_WAITING, ResultsWriterNode, UNDER_WAY_S
from bpc_perception.runtime.isolated_graph import Graph

pytestmark = pytest.mark.ros


def writer(graph: Graph, folder: Path) -> ResultsWriterNode:
    file = folder / 'cell.calib'
    save_hand_eye(file, HandEye(True, np.eye(4)), 'cell', BASE, FLANGE, 'camera')
    node: ResultsWriterNode = graph.make(ResultsWriterNode, hand_eye_file=str(file),
                                         prints=str(folder / 'prints'))
    return node


def test_profiles_without_an_image_fill_no_memory(graph: Graph, tmp_path: Path) -> None:
    """Of a camera whose image nobody hears, the newest profiles wait."""
    node = writer(graph, tmp_path)
    profile = profile_of([2e-3] * 3)
    for stamp_ns in range(1, 3 * MOST_WAITING):
        node._on_profile(replace(profile, stamp_ns=stamp_ns))
    assert list(node._profiles) == list(range(2 * MOST_WAITING, 3 * MOST_WAITING))
    assert not (tmp_path / 'prints').exists()


def test_the_last_results_are_taken_at_the_end_of_a_slow_writer(
        graph: Graph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    node, measuring = writer(graph, tmp_path), graph.make(Node, 'measuring')
    monkeypatch.setattr(node, 'write', lambda: time.sleep(2 * UNDER_WAY_S))
    publisher = measuring.create_publisher(ThicknessProfile, topics.PROFILE, topics.RESULT_QOS)
    graph.spin_until(publisher.get_subscription_count)
    message = profile_to_message(profile_of([2e-3] * 3), BASE)
    for stamp_ns in range(5):
        message.header.stamp = ns_to_stamp(stamp_ns)
        publisher.publish(message)
    while not node._timer.is_ready():  # to write comes before what is waiting
        time.sleep(0.01)
    node.finish()
    assert list(node._profiles) == list(range(5))
