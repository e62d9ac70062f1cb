"""Measure a recorded print without a graph: the same core in the same order as the nodes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain, islice
import logging
from typing import Any

import numpy as np

from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.geometry import transform
from bpc_perception.core.path.leaps import LEAPT
from bpc_perception.core.path.tracker import JumpError, PrintTracker
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Result, Session
from bpc_perception.messages import topics
from bpc_perception.messages.capture_pairing import CapturePairer
from bpc_perception.messages.extruder import extruder_from_message
from bpc_perception.messages.flange_poses import FlangePoses
from bpc_perception.messages.path import path_from_message
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.recording.bag import Bag, BagError, BagMessage
from bpc_perception.recording.contents import find_topics, is_recorded

logger = logging.getLogger(__name__)

# More than live: a recorder may get simulated time late, or its clock may be somewhat slow.
MAXIMUM_LEAD_NS = 10**9
# Most of the first or of the latest messages tell whether stamps and recording share a clock. The
# first are read ahead, up to five captures, and must stay few.
FIRST_COUNT, RECENT_COUNT = 15, 101


def measure_bag(bag: Bag, hand_eye: HandEye, config: ThicknessConfig, recorder: RecorderConfig,
                print_id: str = '') -> Iterator[Result]:
    """Measure each complete capture of a recording, and yield the results in order.

    The path is assembled from the recorded poses and extruder states. Prints that the recorder was
    told to start or to stop, as its recorded path shows, begin and end there. A recording that has
    no poses but the assembled path is measured along that path.

    A capture waits for its part of the path no longer than live, by the time of recording.

    With ``print_id`` that print alone is measured. Its recording also has what came shortly before
    and after it, of other prints.

    Raises BagError when a needed topic is missing or empty.
    """
    measurement = _OfflineMeasurement(bag, hand_eye, config, recorder)
    if print_id:
        measurement.take_only(print_id)
    for topic, log_ns, message in _without_future(bag.messages(measurement.topics)):
        yield from measurement.take(topic, log_ns, message)
    yield from measurement.finish()


class _OfflineMeasurement:
    """Hands each recorded message to the path tracker and the session, as the nodes do live.

    Attributes:
        topics: the recorded topics to read.
    """

    def __init__(self, bag: Bag, hand_eye: HandEye, config: ThicknessConfig,
                 recorder: RecorderConfig) -> None:
        cameras = find_topics(bag, topics.CAMERA)
        self._poses = FlangePoses(recorder.pose, recorder.base_frame)
        path_sources = _find_path_sources(bag, self._poses)
        self._bag, self._print_id = bag, ''
        self._assembled = topics.PATH in path_sources.values()  # the recording has the path
        if not self._assembled:
            path_sources |= _find_recorded_path(bag)
        self._names = cameras | path_sources
        self.topics = set(self._names)
        self._tip = np.array(recorder.nozzle_offset)
        self._tracker = PrintTracker(recorder.path)
        self._pairer = CapturePairer()
        self._session = Session(config, hand_eye)
        # When the recorder's clock is set, time jumps. A jump counts for half the patience at
        # most, so that no capture runs out of patience at once.
        self._longest_step_ns = round(config.patience * 0.5e9)
        self._last_log_ns = self._now_ns = 0
        self._warned: set[str] = set()  # relative names of topics with messages not taken
        self._handlers: dict[str, Callable[[Any, int], bool]] = {
            self._poses.topic: self._take_pose,
            topics.EXTRUSION: self._take_extruder_state,
            topics.PATH: self._take_path if self._assembled else self._follow_path,
            **{name: partial(self._take_camera_message, name) for name in topics.CAMERA}}

    def take_only(self, print_id: str) -> None:
        """Start this print when it began live, and give the results of no other."""
        paths = {topic for topic, name in self._names.items() if name == topics.PATH}
        start_ns = next((stamp_to_ns(path.header.stamp)
                         for _, _, path in self._bag.messages(paths)
                         if path.print_id == print_id), None)
        if start_ns is not None:
            self._print_id = print_id
            self._tracker.start(start_ns)

    def take(self, topic: str, log_ns: int, message: Any) -> Iterator[Result]:
        """Take a message recorded at ``log_ns``; yield the results it makes possible."""
        self._advance_clock(log_ns)
        name = self._names[topic]
        try:
            if not self._handlers[name](message, log_ns):
                self._warn_once(name, topic)
        except ConversionError as error:
            logger.warning('%s', error)
        _log_problems(self._pairer.give_up())
        if self._session.waiting:
            if not self._assembled and (path := self._tracker.path()) is not None:
                self._session.set_path(path)
            yield from self._of_the_print(self._session.results(self._now_ns))

    def finish(self) -> Iterator[Result]:
        """Give up incomplete captures, and yield the results of all that still wait."""
        _log_problems(self._pairer.give_up(before_ns=1))  # all: nothing more will come
        yield from self._of_the_print(self._session.results(finish=True))

    def _of_the_print(self, results: Iterator[Result]) -> Iterator[Result]:
        return (result for result in results if result.profile is None
                or self._print_id in ('', result.profile.print_id))

    def _advance_clock(self, log_ns: int) -> None:
        step_ns = log_ns - self._last_log_ns
        self._now_ns += max(-self._longest_step_ns, min(step_ns, self._longest_step_ns))
        self._last_log_ns = log_ns

    # Each handler takes a message and its time of recording [ns]. It returns False when the
    # message is late, comes twice or jumps, and raises ConversionError when it is unusable.

    def _take_pose(self, message: Any, log_ns: int) -> bool:
        stamp_ns, T_base_flange = self._poses.read(message, log_ns)
        taken = self._session.add_flange_pose(stamp_ns, T_base_flange)
        leaps = self._tracker.leaps
        try:
            taken &= self._tracker.add_pose(stamp_ns, transform(T_base_flange, self._tip))
        except JumpError as error:
            logger.warning('%s', error)
        if self._tracker.leaps > leaps:
            logger.warning('%s', LEAPT)
        return taken

    def _take_extruder_state(self, message: Any, _: int) -> bool:
        return self._tracker.add_extruder(extruder_from_message(message))

    def _take_path(self, message: Any, _: int) -> bool:
        self._session.set_path(path_from_message(message))
        return True

    def _follow_path(self, message: Any, _: int) -> bool:
        self._tracker.follow(path_from_message(message))
        return True

    def _take_camera_message(self, name: str, message: Any, _: int) -> bool:
        capture = self._pairer.add(name, message)
        if capture is not None:
            self._session.add_capture(capture, self._now_ns)
        return True

    def _warn_once(self, name: str, topic: str) -> None:
        if name not in self._warned:
            self._warned.add(name)
            logger.warning('%s: expected what is later than the last and within its reach, found '
                           'some late, twice or a jump', topic)


def _find_path_sources(bag: Bag, poses: FlangePoses) -> dict[str, str]:
    """Return the recorded topics that give the path, each with its relative name.

    Raises BagError when one is missing or empty.
    """
    path_class = topics.RESULTS[topics.PATH]
    if (not is_recorded(bag, poses.topic, poses.message_class)
            and is_recorded(bag, topics.PATH, path_class)):
        found = find_topics(bag, {topics.PATH: path_class})
    else:
        found = find_topics(bag, {poses.topic: poses.message_class,
                                  topics.EXTRUSION: topics.PRINT[topics.EXTRUSION]})
    silent = [topic for topic in found if bag.count(topic) == 0]
    if silent:
        raise BagError(f'{bag.path}: expected messages on {" and ".join(silent)}, found none')
    return found


def _find_recorded_path(bag: Bag) -> dict[str, str]:
    """Return the topic of the path as it was recorded, with its relative name, if there is one."""
    path_class = topics.RESULTS[topics.PATH]
    if not is_recorded(bag, topics.PATH, path_class):
        return {}
    return find_topics(bag, {topics.PATH: path_class})


def _log_problems(problems: list[str]) -> None:
    for problem in problems:
        logger.warning('%s', problem)


def _without_future(messages: Iterator[BagMessage]) -> Iterator[BagMessage]:
    """Leave out, with a warning, messages with a stamp in the future of their recording, as live.

    When most of the first or of the latest messages have such stamps, the recorder's clock is not
    the clock of the stamps. Then nothing can be said, and nothing is left out.
    """
    first = deque(islice(messages, FIRST_COUNT))
    ahead = deque((_is_ahead(log_ns, message) for _, log_ns, message in first), RECENT_COUNT)
    last_ns = 0
    for entry in chain(_consume(first), messages):
        topic, log_ns, message = entry
        if log_ns < last_ns - MAXIMUM_LEAD_NS:  # the recorder's clock was set back
            ahead.clear()
        last_ns = log_ns
        ahead.append(_is_ahead(log_ns, message))
        if ahead[-1] and 2 * sum(ahead) <= len(ahead):
            logger.warning('%s: expected a stamp of the past, found one of the future', topic)
        else:
            yield entry


def _consume(entries: deque[BagMessage]) -> Iterator[BagMessage]:
    """Yield and release one entry after the other: captures are large."""
    while entries:
        yield entries.popleft()


def _is_ahead(log_ns: int, message: Any) -> bool:
    header = getattr(message, 'header', None)  # without a header, the time of recording counts
    return header is not None and stamp_to_ns(header.stamp) - log_ns > MAXIMUM_LEAD_NS
