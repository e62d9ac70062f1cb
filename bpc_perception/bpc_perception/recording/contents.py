"""Find captures, poses and extruder states in the recording of a print."""

from __future__ import annotations

from collections.abc import Iterator
import logging
from typing import Any

from geometry_msgs.msg import Pose
import numpy as np
from numpy.typing import NDArray

from bpc_interfaces.msg import DepositionPath, ExtrusionState
from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import PoseConfig
from bpc_perception.messages import topics
from bpc_perception.messages.capture_pairing import CapturePairer
from bpc_perception.messages.poses.flange_poses import FlangePoses, LBR_STATE_TYPE
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.messages.types import message_type, MessageTypeError
from bpc_perception.recording.bag import Bag, BagError

logger = logging.getLogger(__name__)

# These types tell by themselves what a topic is about, whatever its name.
UNIQUE_TYPES = {LBR_STATE_TYPE, *map(topics.type_name, (ExtrusionState, DepositionPath))}


def topics_named(bag: Bag, name: str, message_class: Any) -> list[str]:
    """Return the recorded topics of this relative name and type, in any namespace.

    When no topic has the name, a type of UNIQUE_TYPES is enough: the LBR stack uses another name.
    Where another topic is to be read in its place, it is that one.
    """
    kind = topics.type_name(message_class)
    of_kind = [topic for topic, recorded in bag.topics.items() if recorded == kind]
    if name in bag.others:
        other = bag.others[name].lstrip('/')
        return [topic for topic in of_kind if topic.lstrip('/') == other]
    named = [topic for topic in of_kind if f'/{topic.lstrip("/")}'.endswith(f'/{name}')]
    return named or (of_kind if kind in UNIQUE_TYPES else [])


def find_topic(bag: Bag, name: str, message_class: Any) -> str:
    """Return the recorded topic of this relative name and type; see topics_named.

    Raises BagError when there is none or more than one.
    """
    found = topics_named(bag, name, message_class)
    if len(found) != 1:
        choose = (f'; choose one with --remap {name}:=TOPIC' if found else
                  f'; record it, or choose another with --remap {name}:=TOPIC')
        raise BagError(f'{bag.path}: expected one topic {bag.others.get(name, name)} '
                       f'({topics.type_name(message_class)}), found '
                       f'{" and ".join(found) or "none among " + ", ".join(sorted(bag.topics))}'
                       + choose)
    return found[0]


def is_recorded(bag: Bag, name: str, message_class: Any) -> bool:
    """Return whether there is such a topic, and it is not stated to be empty."""
    return any(bag.count(topic) != 0 for topic in topics_named(bag, name, message_class))


def find_topics(bag: Bag, wanted: dict[str, Any]) -> dict[str, str]:
    """Return the recorded topic of each relative name, as recorded name to relative name.

    Raises BagError when one is missing or found more than once.
    """
    return {find_topic(bag, name, kind): name for name, kind in wanted.items()}


def pose_topics(bag: Bag) -> dict[str, Any]:
    """Return the relative names and types of all topics with poses of the robot.

    Raises MessageTypeError when the only such topic has a type that is not installed.
    """
    sources = (*topics.ROBOT.items(), (topics.POSE, Pose))
    found = {name: kind for name, kind in sources if is_recorded(bag, name, kind)}
    if LBR_STATE_TYPE in bag.topics.values():
        try:
            found[topics.LBR_STATE] = message_type(LBR_STATE_TYPE)
        except MessageTypeError:
            if not found:
                raise
    return found


def flange_poses(bag: Bag, config: PoseConfig, base_frame: str) -> tuple[NDArray[np.int64], Array]:
    """Return stamps (N,) [ns] and T_base_flange (N, 4, 4) [m], in the order of the stamps.

    Messages that are no poses are logged. Raises BagError when the source was not recorded or has
    no pose.
    """
    source = FlangePoses(config, base_frame)
    topic = find_topic(bag, source.topic, source.message_class)
    found = {}
    for _, log_ns, message in bag.messages({topic}, light=True):
        if not source.concerns(message):
            continue
        try:
            stamp_ns, pose = source.read(message, log_ns)
        except ConversionError as error:
            logger.warning('%s', error)
            continue
        found[stamp_ns] = pose
    if not found:
        raise BagError(f'{bag.path}: expected poses of the flange on {topic}, found none'
                       '; set pose.source and base_frame to what was recorded')
    stamps = sorted(found)
    return np.array(stamps, np.int64), np.stack([found[stamp] for stamp in stamps])


def captures(bag: Bag) -> Iterator[tuple[int, Capture]]:
    """Yield (time of recording [ns], capture) for each complete capture; log the others."""
    names = find_topics(bag, topics.CAMERA)
    pairer = CapturePairer()
    for topic, log_ns, message in bag.messages(set(names)):
        try:
            capture = pairer.add(names[topic], message)
        except ConversionError as error:
            logger.warning('%s', error)
            continue
        if capture is not None:
            yield log_ns, capture
        for problem in pairer.give_up():
            logger.warning('%s', problem)


def capture_count(bag: Bag) -> int | None:
    """Return the number of captures, complete or not; None when it is not stated."""
    return bag.count(find_topic(bag, topics.IMAGE, topics.CAMERA[topics.IMAGE]))
