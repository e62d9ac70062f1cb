"""Make captures of the camera's messages, which come on one topic each."""

from __future__ import annotations

from typing import Any

from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.capture.pairing import StampPairer
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_from_messages
from bpc_perception.messages.stamps import stamp_to_ns


class CapturePairer:
    """Pairs image, camera info and cloud of one stamp."""

    def __init__(self) -> None:
        self._pairer: StampPairer[Any] = StampPairer(tuple(topics.CAMERA))

    def add(self, name: str, message: Any, received_ns: int = 0) -> Capture | None:
        """Take a message of a camera topic; return the capture that it completes, if any.

        Raises ConversionError when the messages of one stamp make no capture.
        """
        stamp_ns = stamp_to_ns(message.header.stamp)
        parts = self._pairer.add(name, stamp_ns, message, received_ns)
        if parts is None:
            return None
        return capture_from_messages(
            parts[topics.IMAGE], parts[topics.CAMERA_INFO], parts[topics.CLOUD])

    def overtaken(self, stamp_ns: int) -> int:
        """Forget captures older than this with nothing but a camera info; return their number.

        Queues hold many camera infos, but few images and clouds: newer ones pushed those out.
        """
        return self._pairer.overtaken(stamp_ns, topics.CAMERA_INFO)

    def give_up(self, before_ns: int = 0, hint: str = '') -> list[str]:
        """Forget captures begun before this time, or the oldest of many; return what they lack.

        The hint says what to do where the camera info came, which is small, but not all else.
        """
        return [f'capture: expected {", ".join(topics.CAMERA)} of one stamp, '
                f'found no {" and no ".join(missing)}'
                + (f'; {hint}' if hint and topics.CAMERA_INFO not in missing else '')
                for missing in self._pairer.expired(before_ns)]

    def clear(self) -> None:
        """Forget everything."""
        self._pairer.clear()
