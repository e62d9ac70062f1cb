"""The page node without its server: what cannot be shown is refused, and the node goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytest.importorskip('rclpy')
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image

from bpc_interfaces.msg import RateAdvice, ThicknessProfile
from bpc_perception.core.advice.rate_advice import RateAdvice as NoAdvice
from bpc_perception.core.profile import ThicknessProfile as NoProfile
from bpc_perception.messages.profile import profile_to_message
from bpc_perception.messages.results.advice import advice_to_message
from bpc_perception.nodes import page

pytestmark = pytest.mark.ros


class NoServer:
    """Stands in for a server without browsers."""

    def __init__(self, *_: Any) -> None:
        self.address = ''

    def notify(self) -> None:
        pass

    def close(self) -> None:
        pass


def profile_comes(node: page.PageNode, message: ThicknessProfile) -> None:
    node._profiles._on_message(ThicknessProfile, serialize_message(message))


@pytest.mark.parametrize(('hear', 'kind'), [
    (lambda node: node._on_advice(RateAdvice()), 'rate_advice'),
    (lambda node: profile_comes(node, ThicknessProfile(time=[0.0])),
     'thickness_profile'),
    (lambda node: node._on_overlay(Image(encoding='mono8')), 'image'),
    (lambda node: node._on_overlay(Image(  # nothing is left of it when it is made smaller
        encoding='rgb8', width=5000, height=1, step=15000, data=bytes(15000))), 'overlay'),
], ids=['advice', 'profile', 'overlay', 'thin overlay'])
def test_what_cannot_be_shown_is_refused(graph: Any, monkeypatch: pytest.MonkeyPatch,
                                         hear: Callable[[page.PageNode], None],
                                         kind: str) -> None:
    monkeypatch.setattr(page, 'PageServer', NoServer)
    node = graph.make(page.PageNode)
    node._on_watchers(1)
    node._follow_watchers()
    hear(node)
    node._profiles.pause(False)  # a refused profile is not unpacked again
    assert node._diagnostics._refusals == {kind: 1}


@pytest.mark.parametrize('hear', [
    lambda node: node._on_advice(advice_to_message(NoAdvice.none(5))),
    lambda node: profile_comes(node, profile_to_message(NoProfile.none(5), 'b')),
], ids=['advice', 'profile'])
def test_a_print_that_was_cleared_is_shown_no_longer(
        graph: Any, monkeypatch: pytest.MonkeyPatch,
        hear: Callable[[page.PageNode], None]) -> None:
    monkeypatch.setattr(page, 'PageServer', NoServer)
    node = graph.make(page.PageNode)
    node._on_watchers(1)
    node._follow_watchers()
    profile_comes(node, ThicknessProfile(print_id='print'))
    node._on_advice(RateAdvice(print_id='print', flow_rate_scale=1.0, speed_scale=1.0))
    assert None not in (node._board.profile, node._board.advice)
    hear(node)
    assert (node._board.profile, node._board.advice, node._board.overlay) == (None, None, None)
    black = Image(encoding='rgb8', width=1, height=1, step=3, data=bytes(3))
    node._on_overlay(black)  # the last view of a print that is gone
    assert node._board.overlay is None
