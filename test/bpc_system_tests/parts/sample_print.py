"""The sample print as it is measured, and a printer that publishes it to those who look."""

from __future__ import annotations

from dataclasses import replace
import time
from typing import Any

import cv2
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from bpc_interfaces.msg import RateAdvice, ThicknessProfile
from bpc_perception.core.config import BASE, RecorderConfig, ThicknessConfig
from bpc_perception.core.parameter import flatten
from bpc_perception.core.session import Result
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure
from bpc_perception.messages import topics
from bpc_perception.messages.advice import advice_to_message
from bpc_perception.messages.profile import profile_to_message
from bpc_perception.messages.views import overlay_message
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.offline import measure_bag
from bpc_perception.runtime.isolated_graph import Graph
from bpc_system_tests.parts.command_line import SAMPLE

LENGTH, STEP = 2.0, 2e-4  # of the path of a long print, between its samples [m]
CAPTURES = 200  # of a long print
LIFETIME_NS = 60 * 10**9  # of advice, so that it holds however slow the machine is


def settings() -> ThicknessConfig:
    """Of the thickness node, as in the sample recording."""
    return configure(ThicknessConfig(), 'thickness', SAMPLE / 'params.yaml')


def sample_results() -> list[Result]:
    """Every capture of the sample print, measured."""
    return list(measure_bag(
        Bag(SAMPLE), load_hand_eye(SAMPLE / 'hand_eye.calib'), settings(),
        configure(RecorderConfig(), 'path_recorder', SAMPLE / 'params.yaml')))


def long_print(result: Result, capture: int) -> Result:
    """A capture of a print of LENGTH that goes round in this result's path again and again."""
    profile = result.profile
    assert profile is not None
    count = round(LENGTH / STEP * (capture + 1) / CAPTURES)
    again = np.arange(count) % len(profile)
    arrays = {name: getattr(profile, name)[again] for name in (
        'points', 'extruding', 'status', 'thickness', 'sigma', 'left', 'right', 'left_points',
        'right_points')}
    return replace(result, profile=replace(
        profile, capture=capture, arc_length=np.arange(count) * STEP,
        time=np.arange(count) * 0.01, **arrays))


def enlarged(result: Result, factor: int) -> Result:
    """The same as a camera with so many times the pixels sees it."""
    capture = result.capture
    # Pixel centres have integer coordinates.
    K = np.diag((factor, factor, 1.0)) @ capture.camera.K
    K[:2, 2] += (factor - 1) / 2
    camera = replace(capture.camera, K=K, width=factor * capture.camera.width,
                     height=factor * capture.camera.height)
    image, cloud = (np.asarray(cv2.resize(field, (camera.width, camera.height)), field.dtype)
                     for field in (capture.image, capture.cloud))
    return replace(result, capture=replace(capture, image=image, cloud=cloud, camera=camera))


class Printer:
    """What a page listens to and calls, without the nodes: it says what it is told to say.

    Attributes:
        overlays: the publisher of the overlay.
        called: the services that were called, in order.
    """

    def __init__(self, graph: Graph) -> None:
        node = graph.make(Node, 'printer')
        self._profiles = node.create_publisher(ThicknessProfile, topics.PROFILE,
                                               topics.RESULT_QOS)
        self._advice = node.create_publisher(RateAdvice, topics.ADVICE, topics.RESULT_QOS)
        self._diagnostics = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self.overlays = node.create_publisher(Image, topics.OVERLAY, topics.VIEW_QOS)
        self.called: list[str] = []
        for name in ('capture', 'path_recorder/start', 'path_recorder/stop',
                     'path_recorder/save'):
            node.create_service(Trigger, name, self._answering(name))
        node.create_service(GetParameters, 'thickness/get_parameters', _tell_settings)

    @property
    def heard(self) -> bool:
        """Whether somebody listens to all of it but the overlay."""
        return all(publisher.get_subscription_count()
                   for publisher in (self._profiles, self._advice, self._diagnostics))

    def publish(self, result: Result) -> None:
        """Publish a capture's result as if it had been taken now."""
        assert result.profile is not None
        assert result.advice is not None
        now_ns = time.time_ns()
        self._profiles.publish(profile_to_message(replace(result.profile, stamp_ns=now_ns), BASE))
        self._advice.publish(advice_to_message(replace(
            result.advice, stamp_ns=now_ns, valid_until_ns=now_ns + LIFETIME_NS)))
        if self.overlays.get_subscription_count():
            self.overlays.publish(overlay_message(result, BASE))

    def say(self, name: str, level: bytes = DiagnosticStatus.OK, words: str = 'ok') -> None:
        """Speak on /diagnostics as a node."""
        self._diagnostics.publish(DiagnosticArray(status=[
            DiagnosticStatus(name=name, level=level, message=words)]))

    def _answering(self, name: str) -> Any:
        def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            self.called.append(name)
            response.success, response.message = True, f'{name} done'
            return response
        return answer


def _tell_settings(request: GetParameters.Request,
                   response: GetParameters.Response) -> GetParameters.Response:
    """Answer as the thickness node does, which has numbers and words."""
    values = {name: value for name, _, value in flatten(settings())}
    for name in request.names:
        value = values[name]
        response.values.append(
            ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=value)
            if isinstance(value, str) else
            ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value))
    return response
