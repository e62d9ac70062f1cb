"""Measure a recorded print without a graph: the same core in the same order as the nodes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Set
from functools import partial
from itertools import chain
import logging
from typing import Any

import numpy as np

from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.geometry import transform
from bpc_perception.core.path.leaps import LEAPT
from bpc_perception.core.path.tracker import JumpError, PrintTracker
from bpc_perception.core.result import Result
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Session
from bpc_perception.core.watch.clocks import ADVICE, Clocks
from bpc_perception.files.design.wanted import wanted_design
from bpc_perception.messages import topics
from bpc_perception.messages.capture_pairing import CapturePairer
from bpc_perception.messages.extruder import extruder_from_message
from bpc_perception.messages.path import path_from_message
from bpc_perception.messages.poses.flange_poses import FlangePoses
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.recording.bag import Bag, BagError, BagMessage
from bpc_perception.recording.contents import find_topics, is_recorded

logger = logging.getLogger(__name__)

Noted = tuple[BagMessage, int | None]  # a message, and its stamp if that tells anything [ns]

# The first messages tell which clocks there are. They are read ahead, up to five captures of three
# messages, and must stay few.
FIRST_COUNT, FIRST_OF_CAMERA = 45, 15


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
    messages = bag.messages(measurement.topics, light=True)
    for topic, log_ns, message in _without_future(messages, measurement.camera):
        yield from measurement.take(topic, log_ns, message)
    yield from measurement.finish()


class _OfflineMeasurement:
    """Hands each recorded message to the path tracker and the session, as the nodes do live.

    Attributes:
        topics: the recorded topics to read.
        camera: those of the camera.
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
        self.topics, self.camera = set(self._names), set(cameras)
        self._tip = np.array(recorder.nozzle_offset)
        self._tracker = PrintTracker(recorder.path)
        self._pairer = CapturePairer()
        self._session = Session(config, hand_eye, design=wanted_design(config.design))
        # When the recorder's clock is set, time jumps. A jump counts for half the patience at
        # most, so that no capture runs out of patience at once.
        self._longest_step_ns = round(config.patience * 0.5e9)
        self._last_log_ns = self._now_ns = 0
        self._state_stamps: list[int] = []
        self._longest_hold = recorder.path.extrusion_timeout
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
        if topic in self.camera:
            _log_problems(self._pairer.give_up())
        if self._session.waiting:
            if not self._assembled and (path := self._tracker.path()) is not None:
                self._session.set_path(path)
            yield from self._of_the_print(self._session.results(self._now_ns))

    def finish(self) -> Iterator[Result]:
        """Give up incomplete captures, and yield the results of all that still wait."""
        _log_problems(self._pairer.give_up(before_ns=1))  # all: nothing more will come
        self._warn_of_seldom_states()
        yield from self._of_the_print(self._session.results(finish=True))

    def _warn_of_seldom_states(self) -> None:
        apart = np.diff(np.sort(self._state_stamps)) * 1e-9
        if len(apart) and np.median(apart) > self._longest_hold:
            logger.warning('%s: expected a state each %g s or more often, found them too far '
                           'apart, %.1f s: most of the time it is not known whether ink flows'
                           '; let it publish more often, or raise path.extrusion_timeout',
                           topics.EXTRUSION, self._longest_hold, np.median(apart))

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
        if not self._poses.concerns(message):
            return True
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
        state = extruder_from_message(message)
        self._state_stamps.append(state.stamp_ns)
        return self._tracker.add_extruder(state)

    def _take_path(self, message: Any, _: int) -> bool:
        path = path_from_message(message)
        if path.print_id:
            self._session.set_path(path)
        else:  # it was cleared
            self._session.clear()
        return True

    def _follow_path(self, message: Any, _: int) -> bool:
        path = path_from_message(message)
        self._tracker.follow(path)
        if not path.print_id:  # it was cleared
            self._session.clear()
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
                           'some late, twice or a jump; let one alone publish it', topic)


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
        raise BagError(f'{bag.path}: expected messages on {" and ".join(silent)}, found none'
                       '; see that their nodes run while you record')
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


def _without_future(messages: Iterator[BagMessage], camera: Set[str]) -> Iterator[BagMessage]:
    """Leave out, with a warning, messages with a stamp in the future of their recording, as live.

    The recorder's clock may be another than that of the stamps; see Clocks. Warn of topics that
    are late by a clock of their own.
    """
    clocks, named = Clocks(camera), set()
    noted = ((entry, _note(clocks, entry)) for entry in messages)
    for entry, stamp_ns in chain(_consume(_first(noted, camera)), noted):
        topic, log_ns, _ = entry
        lead = 0.0 if stamp_ns is None else clocks.lead(topic, log_ns, stamp_ns)
        lag = 0.0 if stamp_ns is None else clocks.lag(topic, log_ns)
        if not lead and not lag:
            yield entry
        elif topic not in named:
            named.add(topic)
            expected, found = (
                ('a stamp of the past', f'one {lead:.2f} s in the future by the clock of the '
                 'others') if lead else
                ('stamps by the clock of the others', f'them {lag:.2f} s behind'))
            logger.warning('%s: expected %s, found %s; such messages are left out; %s', topic,
                           expected, found, ADVICE)
    for topic, lag in clocks.late().items():
        if topic in named:
            continue
        logger.warning('%s: expected stamps by the clock of the others, found them %.2f s '
                       'behind; %s', topic, lag, ADVICE)


def _first(noted: Iterator[Noted], camera: Set[str]) -> deque[Noted]:
    """Return the first entries, of which few are captures."""
    first, captures = deque[Noted](), 0
    for entry, stamp_ns in noted:
        topic, _, _ = entry
        first.append((entry, stamp_ns))
        captures += topic in camera
        if len(first) == FIRST_COUNT or captures == FIRST_OF_CAMERA:
            break
    return first


def _note(clocks: Clocks, entry: BagMessage) -> int | None:
    """Take note of a message; return its stamp [ns] if that can be held against the clocks."""
    topic, log_ns, message = entry
    header = getattr(message, 'header', None)
    if header is None:
        return None  # the time of recording counts
    if hasattr(message, 'print_id'):
        return None  # a path has the stamp of the print's start
    stamp_ns = stamp_to_ns(header.stamp)
    return stamp_ns if clocks.note(topic, log_ns, stamp_ns) else None


def _consume(entries: deque[Noted]) -> Iterator[Noted]:
    """Yield and release one entry after the other: captures are large."""
    while entries:
        yield entries.popleft()
