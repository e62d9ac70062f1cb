"""The managed lifecycle of the camera driver: alone, and driven by a lifecycle manager."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from threading import Event
from typing import Any

import pytest

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from node_builders import record_captures
from rclpy.node import Node
from std_srvs.srv import Trigger

from bpc_perception.core.capture.capture import Capture
from bpc_perception.drivers.cameras.bag import BagCamera
from bpc_perception.nodes.camera_driver import CameraDriverNode

pytestmark = pytest.mark.ros
CAPTURES = 3
CONFIGURE, CLEAN_UP, ACTIVATE, DEACTIVATE, SHUT_DOWN = (
    Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_CLEANUP,
    Transition.TRANSITION_ACTIVATE, Transition.TRANSITION_DEACTIVATE,
    Transition.TRANSITION_INACTIVE_SHUTDOWN)


class Manager:
    """A camera driver that hands its captures over, and the manager of its lifecycle."""

    def __init__(self, graph: Any, bag: Path, autostart: bool = False) -> None:
        self.graph = graph
        self.captures: list[Capture] = []
        self.node = graph.make(partial(CameraDriverNode, self.take), back_end='bag',
                               bag=str(bag), autostart=autostart)
        self.peer: Node = graph.make(Node, 'peer')
        self.notes: dict[str, str] = {}
        self.peer.create_subscription(DiagnosticArray, '/diagnostics', self.read, 10)
        self.peer.create_timer(0.1, self.node._diagnostics.publish)

    def take(self, capture: Capture) -> Event:
        self.captures.append(capture)
        return Event()

    def read(self, message: DiagnosticArray) -> None:
        self.notes.update((item.key, item.value) for item in message.status[0].values)

    def call(self, kind: Any, name: str, request: Any) -> Any:
        client = self.peer.create_client(kind, name)
        self.graph.spin_until(client.service_is_ready)
        future = client.call_async(request)
        self.graph.spin_until(future.done)
        self.peer.destroy_client(client)
        return future.result()

    def change(self, transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return bool(self.call(ChangeState, 'camera_driver/change_state', request).success)

    def state(self) -> str:
        return str(self.call(GetState, 'camera_driver/get_state',
                             GetState.Request()).current_state.label)

    def capture(self) -> str:
        """Request a capture; return why there is none, or an empty string."""
        answer = self.call(Trigger, 'capture', Trigger.Request())
        assert answer.success == (not answer.message)
        return str(answer.message)

    def see(self, **notes: str) -> None:
        """Wait until the diagnostics have these notes."""
        self.graph.spin_until(lambda: notes.items() <= self.notes.items())

    def look(self) -> None:
        """Give the node time to look for captures several times."""
        ticks: list[int] = []
        timer = self.peer.create_timer(0.05, lambda: ticks.append(1))
        self.graph.spin_until(lambda: len(ticks) == 4)
        self.peer.destroy_timer(timer)


def test_it_works_by_itself_unless_told_otherwise(graph: Any, tmp_path: Path) -> None:
    record_captures(tmp_path, CAPTURES)
    manager = Manager(graph, tmp_path / 'bag', autostart=True)
    graph.spin_until(lambda: len(manager.captures) == CAPTURES)
    assert manager.state() == 'active'
    manager.see(state='active', captures=str(CAPTURES))


def test_a_manager_drives_it(graph: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[BagCamera] = []
    monkeypatch.setattr(BagCamera, 'close', lambda camera: closed.append(camera))
    record_captures(tmp_path, CAPTURES)
    manager = Manager(graph, tmp_path / 'bag')
    assert manager.state() == 'unconfigured'
    for round_ in (1, 2):
        assert 'active, found it unconfigured' in manager.capture()
        assert manager.change(CONFIGURE)
        manager.see(state='inactive')
        manager.look()
        assert 'active, found it inactive' in manager.capture()
        assert len(manager.captures) == (round_ - 1) * CAPTURES

        assert manager.change(ACTIVATE)
        graph.spin_until(lambda round_=round_: len(manager.captures) == round_ * CAPTURES)
        assert 'found none left' in manager.capture()
        manager.see(state='active')

        assert manager.change(DEACTIVATE)
        manager.see(state='inactive')
        assert len(closed) == round_ - 1
        assert manager.change(CLEAN_UP)
        manager.see(state='unconfigured')
        assert len(closed) == round_
    assert manager.change(CONFIGURE)
    assert manager.change(SHUT_DOWN)
    assert manager.state() == 'finalized'
    assert len(closed) == 3


def test_nothing_comes_while_deactivated(graph: Any, tmp_path: Path) -> None:
    record_captures(tmp_path, CAPTURES)
    manager = Manager(graph, tmp_path / 'bag', autostart=True)
    graph.spin_until(lambda: manager.captures)
    assert manager.change(DEACTIVATE)
    manager.captures.clear()
    camera = manager.node._camera
    camera._last_ns = 2**62  # the clock seems to have gone back: the recording begins anew
    manager.look()
    assert manager.captures == []
    assert manager.change(ACTIVATE)
    graph.spin_until(lambda: len(manager.captures) == CAPTURES)
    assert manager.node._camera is camera  # it was held all the time


def test_a_failed_configuration_says_why_and_can_be_repeated(graph: Any, tmp_path: Path) -> None:
    manager = Manager(graph, tmp_path / 'bag')
    for count in ('1', '2'):
        assert not manager.change(CONFIGURE)
        manager.see(**{'state': 'unconfigured', f'refused: {tmp_path}/bag': count})
        assert 'expected a bag, found nothing there' in manager.notes['last refusal']
    record_captures(tmp_path, CAPTURES)
    assert manager.change(CONFIGURE)
    assert manager.change(ACTIVATE)
    graph.spin_until(lambda: len(manager.captures) == CAPTURES)


def test_what_nobody_expected_is_logged_and_leaves_the_camera_closed(
        graph: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capfd: pytest.CaptureFixture[str]) -> None:
    def connect(_: BagCamera) -> None:
        raise ZeroDivisionError('a bug')

    record_captures(tmp_path, CAPTURES)
    manager = Manager(graph, tmp_path / 'bag')
    with monkeypatch.context() as patch:
        patch.setattr(BagCamera, 'connect', connect)
        assert not manager.change(CONFIGURE)
    assert manager.state() == 'unconfigured'
    assert manager.node._camera is None
    manager.see(**{'last refusal': 'a bug'})
    assert 'ZeroDivisionError: a bug' in capfd.readouterr().err
    assert manager.change(CONFIGURE)


def test_an_impossible_transition_is_refused_and_the_node_lives(graph: Any,
                                                                tmp_path: Path) -> None:
    record_captures(tmp_path, CAPTURES)
    manager = Manager(graph, tmp_path / 'bag')
    assert not manager.change(ACTIVATE)
    assert not manager.change(99)
    manager.see(**{'refused: transition': '2'})
    assert manager.notes['last refusal'].endswith('possible while unconfigured, found 99')
    assert manager.change(CONFIGURE)
