"""The monitor: what the nodes complain of is shown, but not over and over."""

from __future__ import annotations

from typing import Any

from bpc_perception.cli import monitor
from bpc_perception.cli.terminal import Terminal
from bpc_perception.testing import Graph
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import pytest
from rclpy.node import Node

pytestmark = pytest.mark.ros


def test_a_warning_is_shown_once_a_minute_whatever_its_numbers(
        graph: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert isinstance(graph, Graph)
    now = [0.0]
    made = monitor.Monitor(graph.make(Node, 'monitor'), graph.executor, Terminal())

    def hear(text: str, level: bytes = DiagnosticStatus.WARN) -> str:
        monkeypatch.setattr(monitor.time, 'monotonic', lambda: now[0])
        made._on_diagnostics(DiagnosticArray(status=[
            DiagnosticStatus(level=level, name='camera', message=text)]))
        monkeypatch.undo()
        return capsys.readouterr().out

    assert hear('late: found 0.3 s') == '  camera: late: found 0.3 s\n'
    for now[0] in (30.0, 80.0):  # it goes on
        assert hear('late: found -1.5 s') == ''
    assert hear('no light') == '  camera: no light\n'
    assert hear('ok', DiagnosticStatus.OK) == ''
    assert made.warnings == ['camera: late: found -1.5 s', 'camera: no light']
    now[0] = 141.0
    assert hear('late: found 2 s') == '  camera: late: found 2 s\n'
    for number in range(2 * monitor.WARNINGS):
        hear('x' * number)
    assert len(made.warnings) == monitor.WARNINGS
