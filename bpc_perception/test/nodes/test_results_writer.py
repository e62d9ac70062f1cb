"""The results writer as a node in this process."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.config import BASE, FLANGE
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.files.hand_eye_file import save_hand_eye
from bpc_perception.messages.profile import profile_to_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.nodes.results_writer import MOST_WAITING, ResultsWriterNode
from bpc_perception.runtime.isolated_graph import Graph

pytestmark = pytest.mark.ros


def test_profiles_without_an_image_fill_no_memory(graph: Graph, tmp_path: Path) -> None:
    """Of a camera whose image nobody hears, the newest profiles wait."""
    file = tmp_path / 'cell.calib'
    save_hand_eye(file, HandEye(True, np.eye(4)), 'cell', BASE, FLANGE, 'camera')
    node = graph.make(ResultsWriterNode, hand_eye_file=str(file), prints=str(tmp_path / 'prints'))
    message = profile_to_message(profile_of([2e-3] * 3), BASE)
    for stamp_ns in range(1, 3 * MOST_WAITING):
        message.header.stamp = ns_to_stamp(stamp_ns)
        node._on_part(node._profiles, message)
    assert list(node._profiles) == list(range(2 * MOST_WAITING, 3 * MOST_WAITING))
    assert not (tmp_path / 'prints').exists()
