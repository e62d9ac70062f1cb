"""The contract that every camera back end has to keep."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
import time
from typing import Any

import numpy as np
import pytest

from bpc_perception.core.capture.capture import Capture
from bpc_perception.runtime.isolated_graph import Graph
from bpc_sim.doubles.zivid import ZividDouble
from bpc_sim.printer.scenarios import SCENARIOS

pytest.importorskip('rclpy')
from rclpy.node import Node

from bpc_perception.drivers.cameras import back_ends, Camera, CameraError, prepare_camera
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.bag_writer import BagWriter

pytestmark = pytest.mark.ros
JOB = SCENARIOS['line'](0.02)
SEEN = JOB.capture(2.0, 0)


@dataclass
class Rig:
    """A camera, and the scene in front of it."""

    graph: Graph
    camera: Camera
    truth: Callable[[], Capture]
    double: ZividDouble | None = None

    def capture(self) -> Capture:
        return self.camera.capture(time.time_ns())


@pytest.fixture(params=back_ends())
def rig(request: pytest.FixtureRequest, graph: Graph, tmp_path: Path) -> Iterator[Rig]:
    """A camera of each back end that can deliver captures."""
    name, double = request.param, None
    parameters: dict[str, Any] = {}
    if name == 'bag':
        with BagWriter(tmp_path / 'bag') as bag:
            for topic, kind in topics.CAMERA.items():
                bag.add_topic(f'/{topic}', topics.type_name(kind))
            for number in range(3):
                capture = JOB.capture(2.0, 0, time.time_ns() - (3 - number) * 10**9)
                for topic, message in zip(topics.CAMERA, capture_to_messages(capture),
                                          strict=True):
                    bag.write(f'/{topic}', capture.stamp_ns + 10**8, message)
        parameters = {'bag': str(tmp_path / 'bag')}
    elif name == 'synthetic':
        parameters = {'scenario': 'line', 'speed': 0.02,
                      'start_time_ns': time.time_ns() - 100 * 10**9}
    else:
        double = request.getfixturevalue('zivid')
    camera = prepare_camera(name, graph.make(Node, 'owner', **parameters))()
    camera.connect()
    yield Rig(graph, camera, lambda: SEEN, double)
    camera.close()


def test_a_capture_is_as_the_core_wants_it(rig: Rig) -> None:
    capture = rig.capture()
    height, width = SEEN.image.shape[:2]
    assert capture.image.shape == (height, width, 3)
    assert capture.image.dtype == np.uint8
    assert capture.cloud.shape == (height, width, 3)
    assert capture.cloud.dtype == np.float32
    assert (capture.camera.width, capture.camera.height) == (width, height)
    assert capture.frame_id.endswith('optical_frame')
    assert type(capture.stamp_ns) is int


def test_the_cloud_is_in_metres_on_its_own_pixels(rig: Rig) -> None:
    capture = rig.capture()
    finite = np.isfinite(capture.cloud).all(axis=2)
    assert finite.mean() > 0.5
    assert 0.2 < np.median(capture.cloud[finite][:, 2]) < 1.0
    # A missing point is NaN, never zero.
    assert not np.any(capture.cloud[finite] == 0.0, axis=1).all()
    v, u = np.nonzero(finite)
    uv = capture.camera.pixels(capture.cloud[finite].astype(float))
    np.testing.assert_allclose(np.median(np.abs(uv - np.stack((u, v), 1)), axis=0), 0, atol=0.1)


def test_ink_and_bed_have_their_colours(rig: Rig) -> None:
    """Colours are not darkened, and red and blue are not swapped."""
    capture = rig.capture()
    bed = np.median(capture.image.reshape(-1, 3), axis=0)
    np.testing.assert_allclose(bed, np.median(SEEN.image.reshape(-1, 3), axis=0), atol=3)
    ink = capture.image[np.ptp(capture.image.astype(int), axis=2) > 80]
    assert len(ink) > 100
    assert np.median(ink[:, 2]) > np.median(ink[:, 0])  # blue ink


def test_stamps_are_not_in_the_future_and_grow(rig: Rig) -> None:
    first, second = rig.capture(), rig.capture()
    assert first.stamp_ns < second.stamp_ns <= time.time_ns()


def test_due_is_asked_at_any_time(rig: Rig) -> None:
    assert isinstance(rig.camera.due(time.time_ns()), bool)
    assert rig.camera.notes() is not None
    rig.capture()
    assert isinstance(rig.camera.due(time.time_ns()), bool)


def test_connecting_and_closing_twice_does_no_harm(rig: Rig) -> None:
    rig.camera.connect()
    rig.capture()
    rig.camera.close()
    rig.camera.close()


# The simulated camera cannot fail.
@pytest.mark.parametrize('rig', ['bag', 'zivid'], indirect=True)
def test_what_fails_raises_a_camera_error(rig: Rig) -> None:
    for _ in range(3):
        rig.capture()
    if rig.double is not None:
        rig.double.plugged = False
    with pytest.raises(CameraError, match=r'expected .*found'):
        rig.capture()


# A recording that is damaged in the middle.


def test_a_damaged_recording_is_said_and_the_driver_lives(graph: Graph, tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as bag:
        for topic, kind in topics.CAMERA.items():
            bag.add_topic(f'/{topic}', topics.type_name(kind))
        for message in (capture_to_messages(SEEN), [b'\x00\x01\x00\x00no image'] * 3):
            for topic, part in zip(topics.CAMERA, message, strict=True):
                bag.write(f'/{topic}', 10**9, part)
    camera = prepare_camera('bag', graph.make(Node, 'owner', bag=str(tmp_path / 'bag')))()
    assert len(Bag(tmp_path / 'bag').topics) == 3
    np.testing.assert_array_equal(camera.capture(2 * 10**9).image, SEEN.image)
    assert camera.due(2 * 10**9)
    with pytest.raises(CameraError, match=r'recording: .*expected a sensor_msgs/msg/Image'):
        camera.capture(2 * 10**9)
    assert not camera.due(2 * 10**9)
    with pytest.raises(CameraError, match='found none left'):
        camera.capture(2 * 10**9)
