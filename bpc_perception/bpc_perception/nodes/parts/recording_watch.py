"""Say what a recording lacks: whole captures, and the inputs that it is measured from."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
import time

from bpc_perception.core.capture.pairing import StampPairer
from bpc_perception.messages import topics
from bpc_perception.messages.stamps import stamp_in
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.transport.dds_profiles import lost_captures_hint

TORN = ('captures that are not recorded whole: expected image and cloud of each, found part of '
        'them; take fewer captures a second, or a region of each; ')
TORN_PATIENCE_NS = 2 * 10**9  # between the first and the last topic of a capture
MOST_INCOMPLETE = 100  # captures: as many camera infos may come ahead of what is large
MISSING_INPUT_PATIENCE_S = 3.0  # from the first capture until a silent input is missing


class RecordingWatch:
    """Watches what a recorder hears."""

    def __init__(self, diagnostics: Diagnostics, captures: Mapping[str, str],
                 needed: set[str]) -> None:
        """Begin to watch.

        Args:
            diagnostics: on which it is said.
            captures: topics of the camera, by their names among ours.
            needed: topics without which a recording cannot be measured.
        """
        self._diagnostics = diagnostics
        self._image, self._info = captures[topics.IMAGE], captures[topics.CAMERA_INFO]
        self._captures = frozenset(captures.values())
        self._pairer: StampPairer[None] = StampPairer(tuple(captures.values()), MOST_INCOMPLETE)
        self._missing = needed
        self._first_capture = inf  # [s], steady

    def heard(self, topic: str, data: bytes) -> None:
        """Take note of a serialized message, recorded or not."""
        self._missing.discard(topic)
        if topic in self._captures:
            self._pairer.add(topic, stamp_in(data), None, time.monotonic_ns())
        if topic == self._image:
            self._first_capture = min(self._first_capture, time.monotonic())

    def check(self) -> None:
        """Say what is missing by now."""
        # The camera info always comes, but not all else.
        for lacking in self._pairer.expired(time.monotonic_ns() - TORN_PATIENCE_NS):
            if self._info not in lacking:
                self._diagnostics.refuse(TORN + lost_captures_hint())
        if self._missing and time.monotonic() > self._first_capture + MISSING_INPUT_PATIENCE_S:
            self._diagnostics.warn(
                f'{" and ".join(sorted(self._missing))}: expected messages beside the captures, '
                'found none; without them the recording cannot be measured'
                '; start their nodes, or name their topics with --remap')
            self._missing.clear()
