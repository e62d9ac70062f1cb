"""The receiver's time of what a device stamps with its own clock."""

from __future__ import annotations


class ClockOffset:
    """Maps a device's clock onto the receiver's.

    A message is never received before it was sent. So the smallest difference between receipt and
    device time within a stretch of time has the least delay, and the rest is jitter [Cristian
    1989, one way]. The smallest difference of the last two stretches counts, so that the slow
    drift of two quartz clocks is followed. A later device time is never mapped to an earlier time.

    Delay that grows, as of a busy computer, is still delay. A clock was set, or the device started
    anew, where its time goes back; or where the difference rises at once and does not fall again.
    """

    STRETCH_NS = 10 * 10**9
    JUMP_NS = 10**9  # at once: a delay, or a clock that was set
    SETTLING_NS = 2 * 10**9  # after which it was the clock

    def __init__(self) -> None:
        self._least: list[int] = []  # smallest difference in each of the last two stretches [ns]
        self._begun_ns = 0  # when the newest stretch began
        self._latest_ns = 0  # newest device time
        self._latest_offset_ns = 0  # newest difference
        self._mapped_ns = 0  # what the newest device time was mapped to
        self._jumped_ns: int | None = None  # when the difference rose at once

    def map(self, device_ns: int, received_ns: int) -> int | None:
        """Return the time by the receiver's clock [ns] at which a device had this time.

        None = unknown: the message was held up, or the device's clock was set.

        Args:
            device_ns: by the device's clock [ns].
            received_ns: when its message came, by the receiver's clock [ns].
        """
        offset = received_ns - device_ns
        self._follow_jump(offset, received_ns)
        if self._was_set(device_ns, received_ns):
            self._least.clear()
            self._mapped_ns, self._jumped_ns = 0, None
        # A message with less delay than all before shows that those were mapped too late.
        later = device_ns > self._latest_ns
        self._latest_ns, self._latest_offset_ns = device_ns, offset
        if self._jumped_ns is not None:
            return None
        if not self._least or received_ns - self._begun_ns > self.STRETCH_NS:
            self._least = [*self._least[-1:], offset]
            self._begun_ns = received_ns
        self._least[-1] = min(self._least[-1], offset)
        self._mapped_ns = max(device_ns + min(self._least), self._mapped_ns + later)
        return self._mapped_ns

    def _follow_jump(self, offset: int, received_ns: int) -> None:
        """Take note of a difference [ns] that rose at once, and of one that fell again."""
        if not self._least:
            return
        if self._jumped_ns is None and offset - self._latest_offset_ns > self.JUMP_NS:
            self._jumped_ns = received_ns
        elif offset - min(self._least) <= self.JUMP_NS:
            self._jumped_ns = None

    def _was_set(self, device_ns: int, received_ns: int) -> bool:
        """Return whether the device's clock was set, or the device started anew."""
        stayed = (self._jumped_ns is not None
                  and received_ns - self._jumped_ns > self.SETTLING_NS)
        return device_ns < self._latest_ns or stayed

    @property
    def offset_ns(self) -> int | None:
        """The receiver's clock minus the device's [ns]; None before the first message."""
        return min(self._least) if self._least else None
