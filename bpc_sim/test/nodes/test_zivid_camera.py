"""The Zivid camera back end: what it does beyond the contract of all back ends."""

from __future__ import annotations

from pathlib import Path
import sys
import time
from typing import Any

import numpy as np
import pytest

from bpc_perception.core.capture.capture import Capture
from bpc_perception.runtime.isolated_graph import Graph
from bpc_sim.doubles.srgb import linear_to_srgb, srgb_to_linear
from bpc_sim.doubles.zivid import ZividDouble
from bpc_sim.printer.scenarios import SCENARIOS

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from bpc_perception.drivers.cameras import CameraError, prepare_camera
from bpc_perception.messages import topics
from bpc_perception.messages.capture import image_to_rgb
from bpc_perception.nodes.camera_driver import CameraDriverNode

pytestmark = pytest.mark.ros
SEEN = SCENARIOS['line'](0.02).capture(2.0, 0)  # as the double of the fixture sees it


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


def test_what_takes_long_to_draw_is_shown_at_its_stamp(graph: Graph, zivid: ZividDouble) -> None:
    still, asked = zivid.see, []

    def slowly(t: float) -> Capture:
        asked.append(t)
        time.sleep(0.3)
        return still(t)

    zivid.see = slowly
    capture = opened(graph).capture(0)
    assert capture.stamp_ns * 1e-9 == pytest.approx(asked[-1], abs=0.05)


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
