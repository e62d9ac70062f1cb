"""The camera driver with a recording as its camera."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
from perception_builders import band_image, capture_of, SECOND, START_NS
import pytest

pytest.importorskip('rclpy')
from node_builders import Bench, record_captures
from rclpy.parameter import Parameter

from bpc_perception.drivers.cameras.bag import BagCamera
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_from_messages, capture_to_messages
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.nodes.camera_driver import CameraDriverNode
from bpc_perception.recording.bag import Bag, BagError

pytestmark = pytest.mark.ros


def stamps(messages: list[Any]) -> list[int]:
    return [(stamp_to_ns(message.header.stamp) - START_NS) // SECOND for message in messages]


def test_a_recording_is_delivered_to_those_who_listen_to_all_of_it(graph: Any,
                                                                  tmp_path: Path) -> None:
    bench = Bench(graph, CameraDriverNode, back_end='bag', bag=record_captures(tmp_path))
    images = bench.listen(topics.IMAGE, topics.CAMERA[topics.IMAGE], topics.CAMERA_QOS)
    ticks: list[int] = []
    bench.peer.create_timer(0.05, lambda: ticks.append(1))
    bench.until(lambda: len(ticks) == 4)  # the driver has looked several times by now
    assert images == []
    for name in (topics.CAMERA_INFO, topics.CLOUD):
        bench.listen(name, topics.CAMERA[name], topics.CAMERA_QOS)
    bench.until(lambda: all(len(bench.received[name]) == 3 for name in topics.CAMERA))
    for name in topics.CAMERA:
        assert stamps(bench.received[name]) == [0, 1, 2]
    assert images[0] == capture_to_messages(capture_of(band_image(), START_NS))[0]


def test_a_capture_can_be_asked_for(graph: Any, tmp_path: Path) -> None:
    bench = Bench(graph, CameraDriverNode, back_end='bag', bag=record_captures(tmp_path, 2))
    images = bench.listen(topics.IMAGE, topics.CAMERA[topics.IMAGE], topics.CAMERA_QOS)
    for number in (1, 2):
        answer = bench.call('capture')
        assert (answer.success, answer.message) == (True, '')
        bench.until(lambda number=number: len(images) == number)
    assert stamps(images) == [0, 1]
    answer = bench.call('capture')
    assert not answer.success
    assert answer.message.startswith('capture: expected a recorded capture')
    bench.until(lambda: bench.diagnosed('refused: capture') == '1')
    assert bench.diagnosed('captures') == '2'


def test_a_capture_is_handed_over_before_it_is_published(graph: Any, tmp_path: Path) -> None:
    order: list[str] = []

    class Turn(Event):
        def wait(self, timeout: float | None = None) -> bool:
            order.append('waited' if timeout else 'went on')
            return True

    def hand_over(capture: Any) -> Event:
        order.append(f'handed over {(capture.stamp_ns - START_NS) // SECOND}')
        return Turn()

    bag = record_captures(tmp_path, 2)
    bench = Bench(graph, partial(CameraDriverNode, hand_over), back_end='bag', bag=bag, rate=0.0)
    bench.until(lambda: len(order) == 4)  # though nobody listens
    assert order == ['handed over 0', 'went on', 'handed over 1', 'went on']
    order.clear()
    images = bench.listen(topics.IMAGE, topics.CAMERA[topics.IMAGE], topics.CAMERA_QOS)
    bench.node._camera = BagCamera(Bag(bag))
    bench.until(lambda: len(images) == 2)
    assert order == ['handed over 0', 'waited', 'handed over 1', 'waited']


def test_a_region_of_captures_keeps_its_place(graph: Any, tmp_path: Path) -> None:
    region = [21, 40, 110, 33]
    bench = Bench(graph, CameraDriverNode, back_end='bag', bag=record_captures(tmp_path, 2),
                  region=region)
    for name in topics.CAMERA:
        bench.listen(name, topics.CAMERA[name], topics.CAMERA_QOS)
    bench.until(lambda: all(len(bench.received[name]) == 2 for name in topics.CAMERA))
    whole = capture_of(band_image(), START_NS)
    part = capture_from_messages(*(bench.received[name][0] for name in topics.CAMERA))
    assert part.image.tolist() == whole.image[40:73, 21:131].tolist()
    np.testing.assert_array_equal(part.cloud, whole.cloud[40:73, 21:131])
    # A point is seen at the pixel at which it lies in the cloud.
    np.testing.assert_allclose(part.camera.pixels(part.cloud[12, 34].astype(float)), (34, 12),
                               atol=1e-3)
    bench.node.set_parameters([Parameter('region', value=[100, 0, 61, 10])])
    bench.node._camera = BagCamera(Bag(record_captures(tmp_path / 'again', 1)))
    bench.until(lambda: bench.diagnosed('refused: region') == '1')
    assert bench.diagnosed('last refusal').endswith('found 61 x 10 at (100, 0)')


def test_an_unknown_back_end_is_refused(graph: Any) -> None:
    with pytest.raises(ValueError, match=r'back_end: expected one of .*bag.* found .*webcam'):
        graph.make(CameraDriverNode, back_end='webcam')


def test_a_missing_recording_is_refused(graph: Any, tmp_path: Path) -> None:
    with pytest.raises(BagError, match='expected a bag, found nothing there'):
        graph.make(CameraDriverNode, back_end='bag', bag=str(tmp_path / 'none'))


def test_a_negative_rate_is_refused(graph: Any, tmp_path: Path) -> None:
    node = graph.make(CameraDriverNode, back_end='bag', bag=record_captures(tmp_path, 1))
    result, = node.set_parameters([Parameter('rate', value=-1.0)])
    assert not result.successful
