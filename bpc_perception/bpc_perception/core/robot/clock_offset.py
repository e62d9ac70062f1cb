"""The time of a device's own clock on ours, from when its messages came."""

from __future__ import annotations


class ClockOffset:
    """Maps a device's clock onto the receiver's.

    A message is never received before it was sent. So of a stretch of time the smallest
    difference between receipt and device time is the one with the least delay, and the rest is
    jitter [Cristian 1989, one way]. Of the last two stretches it is taken, so that the slow
    drift of two quartz clocks is followed. What comes later is never put earlier.
    """

    STRETCH_NS = 10 * 10**9
    JUMP_NS = 10**9  # a device whose clock is off by more than this was set, or started anew

    def __init__(self) -> None:
        self._least: list[int] = []
        self._begun_ns = 0
        self._latest_ns = 0
        self._mapped_ns = 0

    def map(self, device_ns: int, received_ns: int) -> int:
        """The receiver's time [ns] of a device time, whose message came at ``received_ns``."""
        offset = received_ns - device_ns
        if self._least and (device_ns < self._latest_ns
                            or abs(offset - min(self._least)) > self.JUMP_NS):
            self._least.clear()
            self._mapped_ns = 0
        # A message that came quicker than all before shows that those were put too late.
        later = device_ns > self._latest_ns
        self._latest_ns = device_ns
        if not self._least or received_ns - self._begun_ns > self.STRETCH_NS:
            self._least = [*self._least[-1:], offset]
            self._begun_ns = received_ns
        self._least[-1] = min(self._least[-1], offset)
        self._mapped_ns = max(device_ns + min(self._least), self._mapped_ns + later)
        return self._mapped_ns

    @property
    def offset_ns(self) -> int | None:
        """Our clock less the device's, as it is taken now; None before the first message."""
        return min(self._least) if self._least else None
