"""Publish profiles: short ones whole, of a long one what changed, and the whole when wanted."""

from __future__ import annotations

from rclpy.node import Node
from std_srvs.srv import Trigger

from bpc_interfaces.msg import (
    ThicknessProfile as ThicknessProfileMsg,
    ThicknessProfileUpdate as ThicknessProfileUpdateMsg,
)
from bpc_perception.core.growing_profile import change_between, ProfileChange
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.messages import topics
from bpc_perception.messages.profile import change_to_message, profile_to_message


class ProfilePublisher:
    """Publishes the profiles that a node measures, in a frame."""

    def __init__(self, node: Node, frame_id: str) -> None:
        self._frame_id = frame_id
        self._newest: ThicknessProfile | None = None  # of a print
        self._whole_sent = True  # whether the newest was sent as a whole
        self._wholes = node.create_publisher(ThicknessProfileMsg, topics.PROFILE,
                                             topics.RESULT_QOS)
        self._updates = node.create_publisher(ThicknessProfileUpdateMsg, topics.PROFILE_UPDATE,
                                              topics.UPDATE_QOS)
        node.create_service(Trigger, topics.SEND_PROFILE, self._on_request)

    @property
    def told(self) -> bool:
        """Whether the last that was published is of a print."""
        return self._newest is not None

    def publish(self, profile: ThicknessProfile, longest: int) -> None:
        """Publish a profile; of one with more samples than ``longest`` what changed alone."""
        change = self._change_to(profile) if len(profile) > longest else None
        if change is None and (newest := self._newest) and newest.print_id != profile.print_id:
            self.complete()
        self._newest, self._whole_sent = profile, change is None
        if change is None:
            self._send_whole(profile)
        else:
            self._updates.publish(change_to_message(change, profile, self._frame_id))

    def complete(self) -> None:
        """Publish as a whole what was sent by parts."""
        if self._newest is not None and not self._whole_sent:
            self._send_whole(self._newest)
            self._whole_sent = True

    def clear(self, stamp_ns: int) -> None:
        """Publish that from this time on [ns] there is no print."""
        self.complete()
        self._newest = None
        self._send_whole(ThicknessProfile.none(stamp_ns))

    def _change_to(self, profile: ThicknessProfile) -> ProfileChange | None:
        return change_between(self._newest, profile) if self._newest is not None else None

    def _send_whole(self, profile: ThicknessProfile) -> None:
        self._wholes.publish(profile_to_message(profile, self._frame_id))

    def _on_request(self, _: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        answer.success = self._newest is not None
        if self._newest is None:
            answer.message = 'profile: expected a print, found none measured; ask after a capture'
        else:
            self._send_whole(self._newest)
        return answer
