"""A printer that publishes results to a live page, in place of the nodes."""

from __future__ import annotations

from dataclasses import replace
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from bpc_interfaces.msg import DesignComparison, PrintVerdict, RateAdvice, ThicknessProfile
from bpc_perception.core.config import BASE
from bpc_perception.core.parameter import flatten
from bpc_perception.core.result import Result
from bpc_perception.messages import topics
from bpc_perception.messages.profile import profile_to_message
from bpc_perception.messages.results.advice import advice_to_message
from bpc_perception.messages.results.design import design_to_message
from bpc_perception.messages.results.verdict import verdict_to_message
from bpc_perception.messages.views import overlay_message
from bpc_perception.runtime.isolated_graph import Graph
from bpc_system_tests.parts.sample_print import settings

ADVICE_LIFETIME_NS = 60 * 10**9  # long, so that advice holds on a slow machine, too


class FakePrinter:
    """All that a page listens to and calls, without the nodes; it publishes what the test says.

    Attributes:
        overlays: publisher of the overlay.
        called: services that were called, in order.
    """

    def __init__(self, graph: Graph) -> None:
        node = graph.make(Node, 'printer')
        self._profiles = node.create_publisher(ThicknessProfile, topics.PROFILE,
                                               topics.RESULT_QOS)
        self._advice = node.create_publisher(RateAdvice, topics.ADVICE, topics.RESULT_QOS)
        self._verdicts = node.create_publisher(PrintVerdict, topics.VERDICT, topics.RESULT_QOS)
        self._designs = node.create_publisher(DesignComparison, topics.DESIGN, topics.RESULT_QOS)
        self._diagnostics = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.overlays = node.create_publisher(Image, topics.OVERLAY, topics.VIEW_QOS)
        self.called: list[str] = []
        for name in ('capture', 'path_recorder/start', 'path_recorder/stop',
                     'path_recorder/save'):
            node.create_service(Trigger, name, self._answering(name))
        node.create_service(GetParameters, 'thickness/get_parameters', _get_parameters)

    @property
    def heard(self) -> bool:
        """Whether there are subscribers of everything except the overlay."""
        return all(publisher.get_subscription_count()
                   for publisher in (self._profiles, self._advice, self._verdicts,
                                     self._designs, self._diagnostics))

    def publish(self, result: Result) -> None:
        """Publish the result of a capture as if it had been taken now."""
        assert result.profile is not None
        assert result.advice is not None
        assert result.verdict is not None
        now_ns = time.time_ns()
        self._profiles.publish(profile_to_message(replace(result.profile, stamp_ns=now_ns), BASE))
        self._advice.publish(advice_to_message(replace(
            result.advice, stamp_ns=now_ns, valid_until_ns=now_ns + ADVICE_LIFETIME_NS)))
        self._verdicts.publish(verdict_to_message(
            replace(result.verdict, stamp_ns=now_ns), BASE))
        if result.design is not None:
            self._designs.publish(design_to_message(
                result.design.findings, result.profile.print_id, now_ns, BASE))
        if self.overlays.get_subscription_count():
            self.overlays.publish(overlay_message(result))

    def say(self, name: str, level: bytes = DiagnosticStatus.OK, words: str = 'ok') -> None:
        """Publish a status on /diagnostics in the name of a node."""
        self._diagnostics.publish(DiagnosticArray(status=[
            DiagnosticStatus(name=name, level=level, message=words)]))

    def _answering(self, name: str) -> Any:
        """Return a service callback that notes the call."""
        def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            self.called.append(name)
            response.success, response.message = True, f'{name} done'
            return response
        return answer


def _get_parameters(request: GetParameters.Request,
                   response: GetParameters.Response) -> GetParameters.Response:
    """Answer as the thickness node does, whose parameters are numbers and words."""
    values = {name: value for name, _, value in flatten(settings())}
    for name in request.names:
        value = values[name]
        response.values.append(
            ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value)
            if isinstance(value, str) else
            ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value))
    return response
