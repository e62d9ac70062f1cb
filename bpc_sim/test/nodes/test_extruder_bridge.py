"""The extruder bridge on pseudo-terminals, with the faults of real wires."""

from __future__ import annotations

from collections.abc import Iterator
import importlib
import os
from pathlib import Path
import sys
import time
from typing import Any

import numpy as np
import pytest

from bpc_perception.runtime.isolated_graph import Graph
from bpc_sim.doubles.extruder import TicDouble, Wire

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.drivers.extruders import ports
from bpc_perception.messages import topics
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.nodes.extruder_bridge import ExtruderBridgeNode

pytestmark = pytest.mark.ros
STEPS_PER_S = 100.0  # half a turn per second: 0.5 mm/s with a lead of 1 mm
GEOMETRY = {'plunger__lead': 1e-3, 'plunger__bore': 0.02}
VELOCITY, FLOW = 5e-4, np.pi / 4 * 0.02**2 * 5e-4  # [m/s], [m^3/s]


class Bench:
    """A bridge, and what it has published."""

    def __init__(self, graph: Graph, **parameters: Any) -> None:
        self.graph = graph
        self.bridge = graph.make(ExtruderBridgeNode, **GEOMETRY, **parameters)
        self.peer: Node = graph.make(Node, 'peer')
        self.states: list[ExtrusionState] = []
        self.values: dict[str, str] = {}
        self.said: list[str] = []
        self.peer.create_subscription(
            ExtrusionState, topics.EXTRUSION, self.states.append, topics.EXTRUSION_QOS)
        self.peer.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self.peer.create_timer(0.1, self.bridge._diagnostics.publish)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.said.append(status.message)
            self.values = {value.key: value.value for value in status.values}

    def until(self, condition: Any) -> None:
        self.graph.spin_until(condition)

    def more(self, count: int = 5) -> list[ExtrusionState]:
        """Wait for more states, and return them."""
        begin = len(self.states)
        self.until(lambda: len(self.states) >= begin + count)
        return self.states[begin:]


@pytest.fixture(params=['serial', 'tic'])
def wire(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Wire]:
    """An extruder that pushes from now on."""
    start = time.time()
    tic = TicDouble(lambda now: (STEPS_PER_S * (now - start), STEPS_PER_S))
    with Wire(tic, tmp_path / 'ttyACM0', lines=request.param == 'serial') as made:
        yield made


def bench(graph: Graph, wire: Wire, **parameters: Any) -> Bench:
    back_end = 'serial' if wire._lines else 'tic'
    return Bench(graph, back_end=back_end, port=str(wire._port), timeout=0.3, **parameters)


def test_states_are_those_of_the_device(graph: Graph, wire: Wire) -> None:
    found = bench(graph, wire)
    states = found.more(20)
    for state in states:
        assert state.extruding
        assert state.plunger_velocity == pytest.approx(VELOCITY)
        assert state.flow_rate == pytest.approx(FLOW)
        assert state.error_status == 0
        assert not state.position_uncertain
    stamps_ns = [stamp_to_ns(state.header.stamp) for state in states]
    stamps = (np.array(stamps_ns) - stamps_ns[0]) * 1e-9
    positions = np.array([state.plunger_position for state in states])
    slope = np.polyfit(stamps, positions, 1)[0]
    assert slope == pytest.approx(VELOCITY, rel=0.25)  # a busy machine is not exact
    assert np.all(np.diff(positions) >= 0)
    # To the nanosecond: after a first message that was held up, two are no farther apart.
    assert np.all(np.diff(stamps_ns) > 0)
    found.until(lambda: found.values.get('step mode') == '3')
    assert found.values['operation state'] == 'normal'
    assert found.values['supply [V]'] == '9.12'


@pytest.mark.parametrize('wire', ['serial'], indirect=True)
def test_a_state_that_comes_twice_is_published_once(graph: Graph, wire: Wire) -> None:
    wire.copies = 2
    found = bench(graph, wire)
    stamps_ns = [stamp_to_ns(state.header.stamp) for state in found.more(20)]
    assert np.all(np.diff(stamps_ns) > 0)
    found.until(lambda: int(found.values.get('repeated', 0)) >= 10)


def test_lost_bytes_cost_states_but_falsify_none(graph: Graph, wire: Wire) -> None:
    found = bench(graph, wire)
    found.more()
    wire.drop = 0.01
    refused = 'refused: line' if wire._lines else 'refused: tic'
    found.until(lambda: int(found.values.get(refused, 0)) >= 3)
    wire.drop = 0.0
    found.more(10)
    for state in found.states:
        assert state.plunger_velocity == pytest.approx(VELOCITY)
        assert state.error_status == 0
    assert np.all(np.diff([state.plunger_position for state in found.states]) >= 0)


@pytest.mark.parametrize('late', [0.11, 0.25, 0.45, 0.8])
def test_a_late_answer_is_not_taken_for_the_next(graph: Graph, tmp_path: Path,
                                                 late: float) -> None:
    start = time.time()
    tic = TicDouble(lambda now: (STEPS_PER_S * (now - start), STEPS_PER_S))
    with Wire(tic, tmp_path / 'ttyACM0', lines=False) as wire:
        found = Bench(graph, back_end='tic', port=str(wire._port), timeout=2.0)
        found.more()
        wire.late = late
        found.until(lambda: int(found.values.get('refused: tic', 0)))
        found.more(20)
    for state in found.states:
        assert state.plunger_velocity == pytest.approx(VELOCITY)
        assert (state.error_status, state.position_uncertain) == (0, False)
    assert np.all(np.diff([state.plunger_position for state in found.states]) >= 0)


def test_a_change_of_step_mode_is_carried_over_and_said(graph: Graph, wire: Wire) -> None:
    found = bench(graph, wire)
    before = found.more()[-1]
    wire.tic.step_mode = 5
    found.until(lambda: any('step mode changed from 3 to 5' in text for text in found.said))
    after = found.more()
    assert after[-1].plunger_velocity == pytest.approx(VELOCITY)
    moved = after[-1].plunger_position - before.plunger_position
    assert 0 < moved < VELOCITY * 10


def test_errors_are_passed_on_and_named(graph: Graph, wire: Wire) -> None:
    found = bench(graph, wire)
    wire.tic.error_status, wire.tic.errors_occurred = 1 << 6, 1 << 20 | 1 << 6
    found.until(lambda: any('the motor is stopped: command timeout' in text
                            for text in found.said))
    assert found.more()[-1].error_status == 1 << 6
    found.until(lambda: found.values['errors occurred'] == 'command timeout, encoder skip')


def test_a_reset_is_said_and_the_position_in_doubt(graph: Graph, wire: Wire) -> None:
    found = bench(graph, wire)
    found.more()
    wire.tic.reset()
    found.until(lambda: found.states[-1].position_uncertain)
    found.until(lambda: any('it was reset' in text for text in found.said))
    assert found.more()[-1].plunger_velocity == pytest.approx(VELOCITY)


def test_unplugged_and_plugged_in_again(graph: Graph, wire: Wire) -> None:
    found = bench(graph, wire)
    found.more()
    wire.unplug()
    found.until(lambda: any('expected' in text for text in found.said))
    found.until(lambda: any('expected the extruder, found' in text for text in found.said))
    count = len(found.states)
    wire.plug()
    found.more()
    assert len(found.states) > count
    assert int(found.values['times opened']) >= 1
    found.until(lambda: int(found.values['times opened']) >= 2)


@pytest.fixture
def by_id(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of lasting names."""
    monkeypatch.setattr(ports, 'BY_ID', tmp_path / 'by-id')
    ports.BY_ID.mkdir()
    return ports.BY_ID


@pytest.mark.parametrize('named', [True, False])
def test_a_device_that_comes_back_under_another_number_is_found(
        graph: Graph, by_id: Path, named: bool) -> None:
    tic = TicDouble(lambda _: (0.0, 0.0))
    with Wire(tic, by_id / 'usb-Arduino_1', lines=True) as wire:
        number = os.path.realpath(wire._port)
        found = Bench(graph, back_end='serial', port=number if named else '', timeout=0.3)
        found.more()
        wire.unplug()
        found.until(lambda: any('by-id has no device' in text for text in found.said))
        taken = os.openpty()  # the number that it had
        wire.plug()
        assert os.path.realpath(wire._port) != number
        found.more()
    for end in taken:
        os.close(end)


def test_devices_that_are_there_are_named_where_none_is_chosen(graph: Graph, by_id: Path) -> None:
    for name in ('usb-Arduino_1', 'usb-Tic_2'):
        (by_id / name).touch()
    found = Bench(graph, back_end='serial')
    found.until(lambda: any('by-id has usb-Arduino_1, usb-Tic_2' in text for text in found.said))
    assert not found.states


def test_a_device_that_falls_silent_is_opened_anew(graph: Graph, wire: Wire) -> None:
    found = bench(graph, wire)
    found.more()
    wire.drop = 1.0
    found.until(lambda: any('expected a state each 0.3 s, found none' in text
                            for text in found.said))
    wire.drop = 0.0
    found.more()


def test_started_before_the_device_is_there(graph: Graph, tmp_path: Path) -> None:
    tic = TicDouble(lambda _: (0.0, 0.0))
    found = Bench(graph, back_end='serial', port=str(tmp_path / 'ttyACM0'))
    found.until(lambda: any('expected the extruder, found' in text for text in found.said))
    with Wire(tic, tmp_path / 'ttyACM0', lines=True):
        state = found.more()[-1]
    assert not state.extruding
    assert state.plunger_velocity == 0


@pytest.mark.parametrize(('back_end', 'package'), [('serial', 'serial'), ('tic', 'ticlib')])
def test_a_package_that_is_missing_is_named(graph: Graph, monkeypatch: pytest.MonkeyPatch,
                                            back_end: str, package: str) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ValueError, match=f'packages of {back_end} to be installed.*{package}'):
        graph.make(ExtruderBridgeNode, back_end=back_end)


def test_no_package_is_loaded_before_it_is_chosen() -> None:
    for name in ('serial', 'ticlib'):
        sys.modules.pop(name, None)
    importlib.reload(importlib.import_module('bpc_perception.drivers.extruders.devices'))
    assert not {'serial', 'ticlib'} & set(sys.modules)


def test_joint_states_serve_as_well(graph: Graph) -> None:
    found = Bench(graph, back_end='joint_state', joint='syringe')
    publisher = found.peer.create_publisher(JointState, topics.PLUNGER, topics.POSE_QOS)
    found.until(publisher.get_subscription_count)
    message = JointState(name=['other', 'syringe'], velocity=[9.0, VELOCITY], position=[9.0, 0.02])
    message.header.stamp.sec = 1234
    publisher.publish(message)
    found.until(lambda: found.states)
    state = found.states[-1]
    assert (state.header.stamp.sec, state.extruding, state.plunger_position) == (1234, True, 0.02)
    assert state.flow_rate == pytest.approx(FLOW)
    publisher.publish(JointState(name=['other'], velocity=[9.0]))
    found.until(lambda: any('syringe: expected this joint, found other' in t for t in found.said))
    publisher.publish(JointState(name=['syringe'], position=[9.0]))
    found.until(lambda: any('syringe: expected a velocity' in t for t in found.said))


def test_a_bool_holds_as_long_as_its_publisher_is_there(graph: Graph) -> None:
    found = Bench(graph, back_end='bool')
    publisher = found.peer.create_publisher(Bool, topics.EXTRUDING, topics.RESULT_QOS)
    found.until(publisher.get_subscription_count)
    publisher.publish(Bool(data=True))
    states = found.more(10)  # published once, repeated since then
    assert all(state.extruding for state in states)
    assert all(np.isnan((s.plunger_velocity, s.plunger_position, s.flow_rate)).all()
               for s in states)
    publisher.publish(Bool(data=False))
    found.until(lambda: not found.states[-1].extruding)
    found.peer.destroy_publisher(publisher)
    found.until(lambda: not found.bridge.count_publishers(topics.EXTRUDING))
    count = len(found.states)
    end = time.monotonic() + 0.2
    found.until(lambda: time.monotonic() > end)
    assert len(found.states) <= count + 2  # messages that were under way
