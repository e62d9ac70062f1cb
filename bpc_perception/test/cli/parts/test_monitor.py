"""The monitor shows what is wrong, but not over and over, and goes on."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import pytest
from rclpy.node import Node

from bpc_interfaces.msg import (
    RateAdvice as RateAdviceMsg,
    ThicknessProfile as ThicknessProfileMsg,
)
from bpc_perception.cli.parts import monitor
from bpc_perception.cli.parts.recent_warnings import MOST_KINDS
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.messages import topics
from bpc_perception.messages.results.advice import advice_to_message
from bpc_perception.messages.results.repair import repair_to_message
from bpc_perception.messages.results.verdict import verdict_to_message
from bpc_perception.runtime.isolated_graph import Graph

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
    for number in range(2 * MOST_KINDS):
        hear('x' * number)
    assert len(made.warnings) == MOST_KINDS


def test_messages_that_cannot_be_used_are_told_once_and_those_that_follow_are_heard(
        graph: Any, capsys: pytest.CaptureFixture[str]) -> None:
    made = monitor.Monitor(graph.make(Node, 'monitor'), graph.executor, Terminal())
    peer = graph.make(Node, 'peer')
    profiles = peer.create_publisher(ThicknessProfileMsg, topics.PROFILE, topics.RESULT_QOS)
    advice = peer.create_publisher(RateAdviceMsg, topics.ADVICE, topics.RESULT_QOS)
    assert made.spin_until(lambda: profiles.get_subscription_count()
                           and advice.get_subscription_count(), 10)
    for _ in range(2):
        advice.publish(RateAdviceMsg())  # as `ros2 topic pub` sends for {}
        advice.publish(RateAdviceMsg(flow_rate_scale=1.0, speed_scale=1.0, reason=99))
        profiles.publish(ThicknessProfileMsg(time=[0.0]))
    advice.publish(RateAdviceMsg(flow_rate_scale=1.0, speed_scale=1.0, print_id='print'))
    profiles.publish(ThicknessProfileMsg(print_id='print'))
    assert made.spin_until(lambda: made.profiles and made.advice, 10)
    said = capsys.readouterr().out
    for words in ('expected a flow_rate_scale above 0, found 0.0',
                  f'expected a reason up to {max(Reason)}', 'expected arrays of one length'):
        assert said.count(words) == 1, said


def test_a_print_that_was_cleared_is_no_result(
        graph: Any, capsys: pytest.CaptureFixture[str]) -> None:
    made = monitor.Monitor(graph.make(Node, 'monitor'), graph.executor, Terminal())
    made._on_profile(ThicknessProfile.none(5))
    made._on_advice(advice_to_message(RateAdvice.none(5)))
    assert (made.profiles, made.advice, made.print_ids, made.warnings) == ({}, {}, [], [])
    assert capsys.readouterr().out == 'The print was cleared: its advice holds no longer.\n'


def test_what_other_nodes_say_is_one_line_without_control(
        graph: Any, capsys: pytest.CaptureFixture[str]) -> None:
    made = monitor.Monitor(graph.make(Node, 'monitor'), graph.executor, Terminal())
    made._on_diagnostics(DiagnosticArray(status=[DiagnosticStatus(
        level=DiagnosticStatus.WARN, name='camera\x1b[2J', message='late\nOK all is well')]))
    assert capsys.readouterr().out == '  camera\\x1b[2J: late OK all is well\n'


def test_a_profile_that_comes_last_is_shown_with_the_rest(graph: Any) -> None:
    """As where it had to be asked for; and in a loop, nothing of the round before is."""
    made = monitor.Monitor(graph.make(Node, 'monitor'), graph.executor, Terminal())
    profile = ThicknessProfile.none(5)
    rest = (made._on_advice, advice_to_message(replace(RateAdvice.none(5), print_id='print'))), (
        made._on_verdict, verdict_to_message(replace(PrintVerdict.none(5), print_id='print'),
                                             'base')), (
        made._on_repair, repair_to_message(replace(RepairPlan.none(5), print_id='print'), 'base'))
    for hear, message in rest:
        hear(message)
    made._on_profile(replace(profile, print_id='print'))
    assert made.has(5)
    made._on_profile(replace(profile, print_id='print'))
    assert not made.has(5)


def test_of_each_print_the_newest_verdict_is_known(graph: Any) -> None:
    made = monitor.Monitor(graph.make(Node, 'monitor'), graph.executor, Terminal())
    for stamp_ns, name in ((1, 'first'), (2, 'first'), (3, 'second')):
        verdict = replace(PrintVerdict.none(stamp_ns), print_id=name)
        made._on_verdict(verdict_to_message(verdict, 'base'))
    assert [(each.print_id, each.stamp_ns) for each in made.last_verdicts()] == [
        ('first', 2), ('second', 3)]
