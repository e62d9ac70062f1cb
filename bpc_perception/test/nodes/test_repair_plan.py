"""The plan of repair, published with each profile and when the print ends."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from node_builders import BASE, BEAD_WIDTH_M, STAMP_NS, thickness_bench
import numpy as np
from perception_builders import band_image, BED, capture_of, pixel_path, SECOND
import pytest

from bpc_interfaces.msg import RepairPlan as RepairPlanMsg
from bpc_perception.core.repair.plan import NextLayer, Obstacle
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.results.repair import repair_from_message

pytestmark = pytest.mark.ros
FIRST, LAST = 70, 99  # columns of a gap
PATH = (40, 55), (120, 55)
SPEED, FLOW = 0.01, 1e-8  # of the path


def send(bench: Any, finished: bool, number: int) -> None:
    bench.send(topics.PATH, path_to_message(pixel_path(*PATH, 81, finished=finished), BASE))
    bench.until(lambda: bench.node._session._path is not None
                and bench.node._session._path.finished == finished)
    image = band_image()
    image[:, FIRST:LAST + 1] = BED
    stamp_ns = STAMP_NS + number * SECOND
    for name, message in zip(topics.CAMERA, capture_to_messages(capture_of(image, stamp_ns)),
                             strict=True):
        bench.send(name, message)


def test_a_gap_is_proposed_to_fill_and_said_to_be_final_when_the_print_ends(
        graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, advice__target_thickness=BEAD_WIDTH_M)
    heard = bench.listen(topics.REPAIR, RepairPlanMsg, topics.REPAIR_QOS)
    send(bench, finished=False, number=0)
    bench.until(lambda: heard)
    going_on = repair_from_message(heard[0])
    assert going_on.fills == ()
    assert list(heard[0].layer_finished) == [False]
    layer, = going_on.layers
    fill, = layer.fills
    spacing = np.linalg.norm(np.diff(pixel_path(*PATH, 81).points[:2], axis=0))
    start, end = (pixel_path((at, 55), (at, 55), 1).points[0] for at in (FIRST, LAST))
    assert np.linalg.norm(fill.points - start, axis=1).min() < spacing
    assert np.linalg.norm(fill.points - end, axis=1).min() < spacing
    assert fill.end - fill.start == pytest.approx(np.linalg.norm(end - start) + spacing,
                                                  abs=1.5 * spacing)
    assert fill.speed == pytest.approx(SPEED)
    assert fill.flow.max() == pytest.approx(FLOW)
    assert layer.state.next_layer == NextLayer.NO
    assert Obstacle.GAP in layer.state.obstacles
    # The print ends without another capture.
    bench.send(topics.PATH, path_to_message(pixel_path(*PATH, 81), BASE))
    bench.until(lambda: len(heard) > 1)
    ended = repair_from_message(heard[1])
    assert ended.stamp_ns == going_on.stamp_ns
    assert len(ended.fills) == 1
    bench.node._clear()
    bench.until(lambda: not heard[-1].print_id)
    assert repair_from_message(heard[-1]).layers == ()


def test_a_controller_that_comes_late_has_the_plan(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, advice__target_thickness=BEAD_WIDTH_M)
    first = bench.listen(topics.REPAIR, RepairPlanMsg, topics.REPAIR_QOS)
    send(bench, finished=True, number=0)
    bench.until(lambda: first)
    print_id = first[0].print_id
    first.clear()  # what comes now is for another subscriber
    late = bench.listen(topics.REPAIR, RepairPlanMsg, topics.REPAIR_QOS)
    bench.until(lambda: late)
    assert late[0].print_id == print_id
