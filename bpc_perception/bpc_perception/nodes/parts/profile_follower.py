"""Follow the profiles of a print: short ones come whole, of a long one what changed."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import time
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from bpc_interfaces.msg import (
    ThicknessProfile as ThicknessProfileMsg,
    ThicknessProfileUpdate as ThicknessProfileUpdateMsg,
)
from bpc_perception.core.growing_profile import GrowingProfile
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.messages.profile import change_from_message, profile_from_message
from bpc_perception.messages.stamps import ConversionError

PATIENCE_S = 2.0  # after which it is asked again: the node may have died


class ProfileFollower:
    """Subscribes to profiles and their updates, and reports each profile as a whole, once.

    Where parts are missing it asks for the whole. While it is paused it unpacks nothing, and
    keeps the newest message alone.

    Args:
        node: the node that subscribes.
        on_profile: gets each profile; one without identifier when the print was cleared.
        on_refusal: gets the reason why a message cannot be used.
    """

    def __init__(self, node: Node, on_profile: Callable[[ThicknessProfile], None],
                 on_refusal: Callable[[ConversionError], None]) -> None:
        self._on_profile = on_profile
        self._on_refusal = on_refusal
        self._paused = False
        self._packed: tuple[Any, bytes] | None = None  # type and message, until it is unpacked
        self._asked = -np.inf  # when, steady [s]
        self._client = node.create_client(Trigger, topics.SEND_PROFILE)
        self.clear()
        for kind, topic, qos in (
                (ThicknessProfileMsg, topics.PROFILE, topics.RESULT_QOS),
                (ThicknessProfileUpdateMsg, topics.PROFILE_UPDATE, topics.UPDATE_QOS)):
            node.create_subscription(kind, topic, partial(self._on_message, kind), qos, raw=True)

    def clear(self) -> None:
        """Forget the print."""
        self._known = GrowingProfile()
        self._packed = None

    def pause(self, paused: bool) -> None:
        """Begin or end a pause; at its end the newest message is unpacked."""
        self._paused = paused
        self._unpack()

    def _on_message(self, kind: Any, packed: bytes) -> None:
        self._packed = kind, packed
        self._unpack()

    def _unpack(self) -> None:
        if self._paused or self._packed is None:
            return
        kind, packed = self._packed
        self._packed = None
        message = deserialize_message(packed, kind)
        try:
            news = (self._known.set_whole(profile_from_message(message))
                    if kind is ThicknessProfileMsg
                    else self._known.add_change(change_from_message(message)))
        except ConversionError as error:
            self._on_refusal(error)
            return
        for profile in news:
            self._on_profile(profile)
        if self._known.incomplete:
            self._ask()

    def _ask(self) -> None:
        """Ask for the whole profile, unless it may be under way; it comes as a message."""
        now = time.monotonic()
        if now - self._asked > PATIENCE_S and self._client.service_is_ready():
            self._asked = now
            self._client.call_async(Trigger.Request()).add_done_callback(_take_answer)


def _take_answer(answered: Any) -> None:
    answered.result()  # an error of the call is one of ours
