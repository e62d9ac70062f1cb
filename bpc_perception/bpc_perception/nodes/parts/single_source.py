"""Subscribe to a topic that only one publisher may have at a time, such as that of a robot."""

from __future__ import annotations

from collections.abc import Callable
import time
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from bpc_perception.core.watch.one_source import OneSource
from bpc_perception.runtime.diagnostics import Diagnostics


def subscribe_single_source(node: Node, kind: Any, topic: str, take: Callable[[Any], None],
                            qos: QoSProfile, diagnostics: Diagnostics,
                            concerns: Callable[[Any], bool] = lambda _: True,
                            **options: Any) -> None:
    """Hand messages to ``take``, unless two publishers send at a time: these are refused.

    They contradict each other, and nothing in a message says whose it is. Messages that do not
    concern the subscriber may come from anybody.
    """
    source = OneSource()

    def received(*given: Any) -> None:
        # The events executor hands over both in one tuple, other executors one by one.
        message, information = given if len(given) == 2 else given[0]
        if not concerns(message):
            return
        number = information['publication_sequence_number']  # None = the middleware has none
        if number is None or source.takes(number, time.monotonic()):
            take(message)
        else:
            diagnostics.refuse(f'{topic}: expected messages of one publisher, found those of '
                               'two; end one of them')

    subscription = node.create_subscription(kind, topic, received, qos, **options)
    # By its signature it would be taken for one that wants messages alone.
    subscription._callback_type = Subscription.CallbackType.WithMessageInfo
