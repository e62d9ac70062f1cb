"""The page node without its server: what cannot be shown is refused, and the node goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

pytest.importorskip('rclpy')
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image

from bpc_interfaces.msg import RateAdvice, ThicknessProfile
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


@pytest.mark.parametrize(('hear', 'kind'), [
    (lambda node: node._on_advice(RateAdvice()), 'rate_advice'),
    (lambda node: node._on_profile(serialize_message(ThicknessProfile(time=[0.0]))),
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
    hear(node)
    node._unpack()  # a refused profile is not unpacked again
    assert node._diagnostics._refusals == {kind: 1}
