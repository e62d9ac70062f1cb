"""A recording for each print, in the folder of that print."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from pathlib import Path

from bpc_perception.recording.bag_writer import BagWriter, begin_recording
from bpc_perception.recording.inputs import PRINT_ID
from bpc_perception.recording.print_folder import free_recording, print_folder

HISTORY_NS = 10 * 10**9  # before the start of a print that is recorded, too
# So long after its end a print is recorded on. If it goes on later, it is recorded from there on.
AFTER_NS = 60 * 10**9

_Entry = tuple[int, str, bytes]  # time of receipt [ns], topic, serialized message


class PrintBags:
    """Writes messages into the recording of the print that they belong to.

    Between prints messages are only remembered: those of robot and extruder for a while, and the
    newest of each topic of the camera, which shows the bed as it was.
    """

    def __init__(self, prints: Path, types: Mapping[str, str], inputs: Collection[str],
                 large: Collection[str], beside: Mapping[str, bytes]) -> None:
        """Begin without a print.

        Args:
            prints: where the folders of the prints are.
            types: of all topics, such as ``sensor_msgs/msg/Image``.
            inputs: topics that are remembered.
            large: topics of which the newest message is remembered.
            beside: further files of each recording, name to content.
        """
        self.path = prints
        self._types = types
        self._inputs = inputs
        self._beside = beside
        self._history: deque[_Entry] = deque()
        self._newest: dict[str, _Entry | None] = dict.fromkeys(large)
        self._print_id = ''
        self._bag: BagWriter | None = None
        self._ended_ns: int | None = None
        self._behind = True  # whether there is something remembered that it lacks
        self._written_ns = 0  # when the newest message in it came

    @property
    def print_id(self) -> str:
        """Identifier of the print that is recorded; empty = none was begun."""
        return self._print_id

    def follow(self, print_id: str, finished: bool, log_ns: int) -> None:
        """Take note of how a print is by now [ns]; begin a recording if it is a new one.

        Raises OSError.
        """
        if print_id and print_id != self._print_id:
            self.close()
            self._print_id, self._ended_ns = print_id, None
            self._behind, self._written_ns = True, 0
            folder = print_folder(self.path, print_id)
            folder.mkdir(parents=True, exist_ok=True)
            beside = {**self._beside, PRINT_ID: print_id.encode()}
            self._bag = begin_recording(free_recording(folder), self._types, beside)
        if not finished:
            self._ended_ns = None
        elif self._ended_ns is None:
            self._ended_ns = log_ns

    def write(self, topic: str, log_ns: int, message: bytes) -> None:
        """Append a serialized message, received at a time [ns]; or remember it. Raises OSError."""
        over = self._ended_ns is not None and log_ns - self._ended_ns > AFTER_NS
        if self._bag is not None and not over:
            if self._behind:
                for each in self._remembered():
                    self._bag.write(each[1], each[0], each[2])
            self._bag.write(topic, log_ns, message)
            self._written_ns = log_ns
        self._behind = self._bag is None or over
        self._remember((log_ns, topic, message))

    @property
    def written(self) -> tuple[dict[str, int], int]:
        """Messages written by topic, and the size of the file [bytes], of the newest recording."""
        return self._bag.written if self._bag is not None else ({}, 0)

    @property
    def in_place(self) -> bool:
        """Whether the newest recording is still found where it was begun."""
        return self._bag is None or self._bag.in_place

    def flush(self) -> None:
        """Hand everything written so far to the operating system. Raises OSError."""
        if self._bag is not None:
            self._bag.flush()

    def close(self) -> None:
        """Complete the newest recording. Raises OSError."""
        bag, self._bag = self._bag, None
        if bag is not None:
            bag.close()

    def _remember(self, entry: _Entry) -> None:
        log_ns, topic, _ = entry
        if topic in self._newest:
            self._newest[topic] = entry
        elif topic in self._inputs:
            self._history.append(entry)
            while log_ns - self._history[0][0] > HISTORY_NS:
                self._history.popleft()

    def _remembered(self) -> list[_Entry]:
        """Return what is remembered and not in the newest recording yet, as it came."""
        entries = [*self._history, *(entry for entry in self._newest.values() if entry)]
        return sorted((entry for entry in entries if entry[0] > self._written_ns),
                      key=lambda entry: entry[0])
