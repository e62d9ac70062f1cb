"""The contract of all camera back ends, and the further behaviour of the Zivid back end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
import sys
import time
from typing import Any

import numpy as np
import pytest

from bpc_perception.core.capture.capture import Capture
from bpc_perception.runtime.isolated_graph import Graph
from bpc_sim.doubles.srgb import linear_to_srgb, srgb_to_linear
from bpc_sim.doubles.zivid import still_scene, ZividDouble
from bpc_sim.printer.scenarios import SCENARIOS

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from bpc_perception.drivers import back_ends, Camera, CameraError, prepare_camera
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages, image_to_rgb
from bpc_perception.nodes.camera_driver import CameraDriverNode
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


@pytest.fixture
def zivid(monkeypatch: pytest.MonkeyPatch) -> ZividDouble:
    """A fast Zivid camera, and its package."""
    double = ZividDouble(still_scene(SEEN), acquisition=0.04, processing=0.02)
    for name, module in double.modules().items():
        monkeypatch.setitem(sys.modules, name, module)
    return double


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


# The Zivid camera.


def opened(graph: Graph, **parameters: Any) -> Any:
    return prepare_camera('zivid', graph.make(Node, 'owner', **parameters))()


def test_the_stamp_is_the_middle_of_the_acquisition(graph: Graph, zivid: ZividDouble) -> None:
    zivid.acquisition, zivid.processing = 0.2, 0.1
    camera = opened(graph)
    before = time.time()
    capture = camera.capture(0)
    assert capture.stamp_ns * 1e-9 == pytest.approx(before + 0.1, abs=0.05)
    zivid.throttling = 0.3  # before the acquisition begins
    before = time.time()
    assert camera.capture(0).stamp_ns * 1e-9 == pytest.approx(before + 0.4, abs=0.05)
    assert 'cool down' in str(camera.notes()['WARN'])


def test_a_camera_that_is_gone_comes_back(graph: Graph, zivid: ZividDouble) -> None:
    camera = opened(graph)
    camera.capture(0)
    zivid.plugged = False
    with pytest.raises(CameraError, match='expected a capture, found: Camera is not connected'):
        camera.capture(0)
    with pytest.raises(CameraError, match='expected a camera, found none; looked for again in'):
        camera.capture(0)
    end = time.monotonic() + 5
    while 'WARN' not in (notes := camera.notes()):
        assert time.monotonic() < end
        assert not camera.due(0)
        time.sleep(0.02)
    assert 'No Zivid cameras are connected' in str(notes['WARN'])
    zivid.plugged = True
    while zivid.connections < 2:
        assert time.monotonic() < end
        camera.due(0)
        time.sleep(0.02)
    camera.capture(0)


def test_a_failure_while_processing_is_no_capture(graph: Graph, zivid: ZividDouble) -> None:
    camera = opened(graph)
    zivid.fails_while_processing = True
    with pytest.raises(CameraError, match='Error while processing the capture'):
        camera.capture(0)


def test_started_before_the_camera_is_there(graph: Graph, zivid: ZividDouble) -> None:
    zivid.plugged = False
    camera = opened(graph)
    with pytest.raises(CameraError, match='No Zivid cameras are connected'):
        camera.connect()
    zivid.plugged = True
    camera.connect()
    camera.connect()
    assert zivid.connections == 1
    camera.close()


def test_the_node_is_active_before_the_camera_is_there(graph: Graph, zivid: ZividDouble) -> None:
    zivid.plugged = False
    node = graph.make(CameraDriverNode, back_end='zivid')
    assert node.state == 'active'
    assert 'No Zivid cameras' in node._diagnostics._last_warning
    zivid.plugged = True
    end = time.monotonic() + 5
    while not zivid.connections:
        assert time.monotonic() < end
        node._camera.due(0)


def test_a_manager_is_told_that_there_is_no_camera(graph: Graph, zivid: ZividDouble) -> None:
    zivid.plugged = False
    node = graph.make(CameraDriverNode, back_end='zivid', autostart=False)
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE
    assert 'No Zivid cameras are connected' in str(node._failure)
    assert zivid.application is None
    zivid.plugged = True
    for round_ in (1, 2):
        assert node.trigger_configure() == TransitionCallbackReturn.SUCCESS
        assert zivid.connections == round_
        assert node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
        assert zivid.application is None


def test_another_serial_number_is_not_taken(graph: Graph, zivid: ZividDouble) -> None:
    with pytest.raises(CameraError, match='1234 not found'):
        opened(graph, serial_number='1234').connect()
    assert zivid.connections == 0


def test_intrinsics_of_another_resolution_are_not_taken(graph: Graph,
                                                        zivid: ZividDouble) -> None:
    camera = opened(graph)
    zivid.intrinsics_scale = 2.0
    np.testing.assert_allclose(camera.capture(0).camera.K, SEEN.camera.K)  # estimated
    zivid.estimate_scale = 2.0
    with pytest.raises(CameraError, match='expected intrinsics that put the cloud onto its pix'):
        camera.capture(0)
    zivid.intrinsics_scale = 1.0
    camera.capture(0)
    assert zivid.connections == 1  # the camera was there all the time


@pytest.mark.parametrize(('text', 'words'), [
    ('Settings: {Acquisitions: [{Acquisition: {}}]}', 'settings of the colour image as well'),
    ('nothing', 'expected capture settings of Zivid'),
])
def test_unfit_settings_are_refused(graph: Graph, zivid: ZividDouble, tmp_path: Path,
                                    text: str, words: str) -> None:
    assert zivid.plugged
    (tmp_path / 'settings.yml').write_text(text)
    with pytest.raises(ValueError, match=words):
        opened(graph, settings_file=str(tmp_path / 'settings.yml'))
    assert zivid.application is None  # it can be tried again


def test_colours_are_brighter_if_asked_for(graph: Graph, zivid: ZividDouble) -> None:
    assert zivid.plugged
    found = opened(graph, color_space='srgb').capture(0).image
    np.testing.assert_array_equal(found, linear_to_srgb(SEEN.image))
    assert np.median(found) > np.median(SEEN.image)


def test_settings_are_read_from_a_file(graph: Graph, zivid: ZividDouble, tmp_path: Path) -> None:
    assert zivid.plugged
    (tmp_path / 'settings.yml').write_text(
        'Settings: {Acquisitions: [{Acquisition: {}}], Color: {Acquisitions: []}}')
    opened(graph, settings_file=str(tmp_path / 'settings.yml')).capture(0)


def test_without_the_package_it_is_refused(graph: Graph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'zivid', None)
    with pytest.raises(ValueError, match='expected the package zivid and the SDK'):
        opened(graph)


def test_srgb_is_as_the_standard_has_it() -> None:
    assert linear_to_srgb(np.array([[[0, 55, 255]]], np.uint8)).tolist() == [[[0, 128, 255]]]
    assert srgb_to_linear(np.array([[[0, 128, 255]]], np.uint8)).tolist() == [[[0, 55, 255]]]


def test_the_node_publishes_snr_and_says_how_the_camera_is(graph: Graph,
                                                           zivid: ZividDouble) -> None:
    node = graph.make(CameraDriverNode, back_end='zivid')
    peer: Node = graph.make(Node, 'peer')
    values: dict[str, str] = {}
    images: dict[str, list[Image]] = {topics.IMAGE: [], topics.SNR: []}
    for name, received in images.items():
        peer.create_subscription(Image, name, received.append, topics.CAMERA_QOS)
    peer.create_subscription(
        DiagnosticArray, '/diagnostics', lambda message: values.update(
            {value.key: value.value for value in message.status[0].values}), 10)
    peer.create_timer(0.1, node._diagnostics.publish)
    client = peer.create_client(Trigger, 'capture')
    graph.spin_until(lambda: client.service_is_ready()
                     and all(node.count_subscribers(name) for name in images))
    future = client.call_async(Trigger.Request())
    graph.spin_until(lambda: all(images.values()) and future.done())
    assert future.result().success
    snr, = images[topics.SNR]
    assert (snr.encoding, snr.header) == ('32FC1', images[topics.IMAGE][0].header)
    np.testing.assert_array_equal(image_to_rgb(images[topics.IMAGE][0]), SEEN.image)
    graph.spin_until(lambda: 'model' in values)
    assert values['model'] == 'Zivid 2 M70'
    assert values['serial number'] == zivid.serial_number
    assert values['temperature, lens [degrees C]'] == '36.5'
