"""A recorded print measured without a graph: the same core in the same order as the nodes."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import islice
import logging
from typing import Any

import numpy as np

from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.geometry import transform
from bpc_perception.core.path.tracker import JumpError, PrintTracker
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Result, Session
from bpc_perception.messages import topics
from bpc_perception.messages.capture_pairing import CapturePairer
from bpc_perception.messages.extruder import extruder_from_message
from bpc_perception.messages.flange_poses import FlangePoses
from bpc_perception.messages.path import path_from_message
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns
from bpc_perception.recording.bag import Bag, BagError
from bpc_perception.recording.contents import find_topic, find_topics, is_recorded

logger = logging.getLogger(__name__)

# More than live: a recorder's simulated time may come late to it, or its clock be somewhat slow.
MAXIMUM_LEAD_NS = 10**9
FIRST, RECENT = 15, 101  # messages, of which the first are read ahead; they may be five captures


def measure_bag(bag: Bag, hand_eye: HandEye, config: ThicknessConfig,
                recorder: RecorderConfig) -> Iterator[Result]:
    """Yield what comes of each complete capture of a recording, in order.

    The path is assembled from the recorded poses and extruder states; a recording that has no
    poses but the assembled path is measured along that.

    A capture waits for its part of the path no longer than live, by the time of recording.

    Raises BagError when a topic that is needed is missing or empty.
    """
    names = find_topics(bag, topics.CAMERA)
    poses = FlangePoses(recorder.pose, recorder.base_frame)
    assembled = not is_recorded(bag, poses.topic, poses.message_class) and is_recorded(
        bag, topics.PATH, topics.RESULTS[topics.PATH])
    if assembled:
        names[find_topic(bag, topics.PATH, topics.RESULTS[topics.PATH])] = topics.PATH
    else:
        names |= find_topics(bag, {poses.topic: poses.message_class,
                                   topics.EXTRUSION: topics.PRINT[topics.EXTRUSION]})
    silent = [topic for topic, name in names.items()
              if name not in topics.CAMERA and bag.count(topic) == 0]
    if silent:
        raise BagError(f'{bag.path}: expected messages on {" and ".join(silent)}, found none')
    tip = np.array(recorder.nozzle_offset)
    tracker, pairer, session = PrintTracker(recorder.path), CapturePairer(), Session(
        config, hand_eye)
    # Of time that jumps, as where the recorder's clock is set, only so much counts at once: no
    # capture's patience ends at a stroke.
    longest_ns = round(config.patience * 0.5e9)
    last_ns = now_ns = 0
    late: set[str] = set()  # of which that has been said
    for topic, log_ns, message in _of_the_past(bag.messages(set(names))):
        name = names[topic]
        now_ns += max(-longest_ns, min(log_ns - last_ns, longest_ns))
        last_ns = log_ns
        taken = True
        try:
            if name == poses.topic:
                stamp_ns, pose = poses.read(message, log_ns)
                taken = session.add_flange_pose(stamp_ns, pose)
                taken = tracker.add_pose(stamp_ns, transform(pose, tip)) and taken
            elif name == topics.EXTRUSION:
                taken = tracker.add_extruder(extruder_from_message(message))
            elif name == topics.PATH:
                session.set_path(path_from_message(message))
            elif (capture := pairer.add(name, message)) is not None:
                session.add_capture(capture, now_ns)
        except (ConversionError, JumpError) as error:
            logger.warning('%s', error)
        if not taken and name not in late:
            late.add(name)
            logger.warning('%s: expected what is later than the last and within its reach, found '
                           'some late, twice or a jump', topic)
        for problem in pairer.give_up():
            logger.warning('%s', problem)
        if session.waiting:
            if not assembled and (path := tracker.path()) is not None:
                session.set_path(path)
            yield from session.results(now_ns)
    for problem in pairer.give_up(before_ns=1):  # nothing more will come
        logger.warning('%s', problem)
    yield from session.results(finish=True)


def _of_the_past(messages: Iterator[tuple[str, int, Any]]) -> Iterator[tuple[str, int, Any]]:
    """Leave out, with a warning, what is stamped in the future of its recording, as live.

    Where that holds for most messages, the first or the latest, the clock of the recording is not
    that of the stamps, and nothing can be said.
    """
    first = deque(islice(messages, FIRST))
    ahead = deque((_is_ahead(log_ns, message) for _, log_ns, message in first), RECENT)
    last_ns = 0
    while entry := first.popleft() if first else next(messages, None):
        topic, log_ns, message = entry
        if log_ns < last_ns - MAXIMUM_LEAD_NS:  # that clock was set back
            ahead.clear()
        last_ns = log_ns
        ahead.append(_is_ahead(log_ns, message))
        if ahead[-1] and 2 * sum(ahead) <= len(ahead):
            logger.warning('%s: expected a stamp of the past, found one of the future', topic)
        else:
            yield entry


def _is_ahead(log_ns: int, message: Any) -> bool:
    header = getattr(message, 'header', None)  # or else it is stamped when it comes
    return header is not None and stamp_to_ns(header.stamp) - log_ns > MAXIMUM_LEAD_NS
