"""What can happen to the messages of a print on their way, by name.

Each takes the messages of a print in the order of recording, and returns what is left of them.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import numpy as np

from bpc_perception.messages import topics
from bpc_perception.messages.capture import image_to_rgb
from bpc_perception.messages.stamps import ns_to_stamp, stamp_to_ns
from bpc_perception.recording.bag import BagMessage

Messages = list[BagMessage]
Misfortune = Callable[[Messages, np.random.Generator], Messages]

POSE, STATE = f'/{topics.POSE}', f'/{topics.EXTRUSION}'
IMAGE, INFO, CLOUD = (f'/{name}' for name in topics.CAMERA)
CAPTURE = (IMAGE, INFO, CLOUD)
KINDS = ((POSE,), (STATE,), CAPTURE, (POSE, STATE), (POSE, STATE, *CAPTURE))
LONGEST_S = 2.0


def dropped(messages: Messages, rng: np.random.Generator) -> Messages:
    """Some are lost, one by one, or all of a while."""
    chosen = _kind(rng)
    share = float(rng.choice((0.1, 0.5, 0.9)))
    within = _while(messages, rng) if rng.random() < 0.5 else (0, 2**63)
    share = share if within[1] == 2**63 else 1.0
    return [entry for entry in messages if not (
        entry.topic in chosen and within[0] <= entry.log_ns < within[1] and rng.random() < share)]


def part_lost(messages: Messages, rng: np.random.Generator) -> Messages:
    """One part of some captures is lost."""
    part = str(rng.choice(CAPTURE))
    return [entry for entry in messages if entry.topic != part or rng.random() < 0.6]


def repeated(messages: Messages, rng: np.random.Generator) -> Messages:
    """Some come again later, as they are or with a new stamp."""
    chosen, fresh = _kind(rng), rng.random() < 0.5
    again = []
    for entry in messages:
        if entry.topic in chosen and rng.random() < 0.2:
            log_ns = entry.log_ns + round(rng.uniform(0, 1) * 1e9)
            again.append(_stamped(entry, log_ns) if fresh else entry._replace(log_ns=log_ns))
    return _in_order(messages + again)


def frozen(messages: Messages, rng: np.random.Generator) -> Messages:
    """A source repeats its last message for a while, with new stamps."""
    chosen, (start, end) = _kind(rng), _while(messages, rng)
    last: dict[str, BagMessage] = {}
    result = []
    for entry in messages:
        if entry.topic in chosen and start <= entry.log_ns < end and entry.topic in last:
            stamp_ns = stamp_to_ns(entry.message.header.stamp)
            result.append(_stamped(last[entry.topic], entry.log_ns, stamp_ns))
            continue
        last[entry.topic] = entry
        result.append(entry)
    return result


def late(messages: Messages, rng: np.random.Generator) -> Messages:
    """A source is held up for a while, and then delivers all at once."""
    chosen, (start, end) = _kind(rng), _while(messages, rng)
    return _in_order([entry._replace(log_ns=end) if entry.topic in chosen
                      and start <= entry.log_ns < end else entry for entry in messages])


def shifted(messages: Messages, rng: np.random.Generator) -> Messages:
    """The clock of a source is another, all the time or from a moment on."""
    chosen = _kind(rng)
    shift_ns = round(float(rng.choice((-2, -0.5, -0.2, -0.05, 0.05, 0.2, 0.5, 2))) * 1e9)
    since = _while(messages, rng)[0] if rng.random() < 0.5 else 0
    return [_stamped(entry, entry.log_ns, stamp_to_ns(entry.message.header.stamp) + shift_ns)
            if entry.topic in chosen and entry.log_ns >= since else entry for entry in messages]


def swapped(messages: Messages, rng: np.random.Generator) -> Messages:
    """Neighbours are recorded in another order."""
    reach_ns = float(rng.choice((0.02, 0.2, 1.0))) * 1e9
    return sorted(messages, key=lambda entry: entry.log_ns + rng.uniform(0, reach_ns))


def exposed(messages: Messages, rng: np.random.Generator) -> Messages:
    """The picture is too dark or too bright, or gets brighter."""
    gain = rng.uniform(1, 4) if rng.random() < 0.7 else rng.uniform(0.02, 1)
    growth = float(rng.choice((0.0, 0.1)))
    start = messages[0].log_ns
    return _with_images(messages, lambda image, entry: np.clip(
        image * gain * (1 + growth * (entry.log_ns - start) * 1e-9), 0, 255))


def covered(messages: Messages, rng: np.random.Generator) -> Messages:
    """Something flat lies on the bed, or on the ink, from a moment on."""
    since = _while(messages, rng)[0]
    colour = rng.uniform(0, 255, 3)
    u, v = rng.integers(0, 120), rng.integers(0, 90)
    width, height = rng.integers(5, 60, 2)

    def cover(image: Any, entry: BagMessage) -> Any:
        if entry.log_ns >= since:
            image[v:v + height, u:u + width] = colour
        return image

    return _with_images(messages, cover)


def mirrored(messages: Messages, rng: np.random.Generator) -> Messages:
    """Rows or columns of image, cloud or both come in another order."""
    which, axis = rng.integers(1, 4), int(rng.integers(2))
    result = []
    for entry in messages:
        if entry.topic == IMAGE and which & 1:
            entry = _with_data(entry, np.flip(_pixels(entry), axis))
        if entry.topic == CLOUD and which & 2:
            entry = _with_data(entry, np.flip(_pixels(entry), axis))
        result.append(entry)
    return result


def scaled(messages: Messages, rng: np.random.Generator) -> Messages:
    """Intrinsics, positions or rates are of another scale."""
    what = str(rng.choice(('intrinsics', 'pose', 'rate')))
    factor = float(rng.choice((0.001, 0.5, 0.8, 0.95, 1.05, 1.2, 2.0, 1000.0)))
    result = []
    for entry in messages:
        entry = BagMessage(entry.topic, entry.log_ns, deepcopy(entry.message)
                           if entry.topic in (INFO, POSE, STATE) else entry.message)
        if what == 'intrinsics' and entry.topic == INFO:
            entry.message.k = [value * factor for value in entry.message.k[:8]] + [1.0]
        if what == 'pose' and entry.topic == POSE:
            place = entry.message.pose.position
            place.x, place.y, place.z = place.x * factor, place.y * factor, place.z * factor
        if what == 'rate' and entry.topic == STATE:
            entry.message.flow_rate *= factor
            entry.message.plunger_velocity *= factor
        result.append(entry)
    return result


def spiked(messages: Messages, rng: np.random.Generator) -> Messages:
    """Single values are wrong by far."""
    result = []
    for entry in messages:
        if entry.topic in (POSE, STATE) and rng.random() < 0.02:
            entry = BagMessage(entry.topic, entry.log_ns, deepcopy(entry.message))
            wild = float(rng.choice((np.nan, np.inf, 0.0, -1.0, 1e9)))
            if entry.topic == POSE:
                setattr(entry.message.pose.position, str(rng.choice(('x', 'y', 'z'))), wild)
            else:
                entry.message.flow_rate = wild
        result.append(entry)
    return result


MISFORTUNES: dict[str, Misfortune] = {
    made.__name__: made for made in (
        dropped, part_lost, repeated, frozen, late, shifted, swapped, exposed, covered, mirrored,
        scaled, spiked)}


def _kind(rng: np.random.Generator) -> tuple[str, ...]:
    return KINDS[rng.integers(len(KINDS))]


def _while(messages: Messages, rng: np.random.Generator) -> tuple[int, int]:
    """Return a random while [ns]."""
    start = int(rng.integers(messages[0].log_ns, messages[-1].log_ns))
    return start, start + round(rng.uniform(0.05, LONGEST_S) * 1e9)


def _in_order(messages: Messages) -> Messages:
    return sorted(messages, key=lambda entry: entry.log_ns)


def _stamped(entry: BagMessage, log_ns: int, stamp_ns: int | None = None) -> BagMessage:
    """Return a message recorded at another time, with another stamp; None = as it was recorded."""
    message = type(entry.message)()
    for name in message.get_fields_and_field_types():  # the data of captures is not copied
        setattr(message, name, getattr(entry.message, name))
    message.header = deepcopy(entry.message.header)
    message.header.stamp = ns_to_stamp(log_ns if stamp_ns is None else stamp_ns)
    return BagMessage(entry.topic, log_ns, message)


def _with_images(messages: Messages, change: Callable[[Any, BagMessage], Any]) -> Messages:
    """Return the messages with their images (H, W, 3) changed, as floats."""
    result = []
    for entry in messages:
        if entry.topic == IMAGE:
            changed = change(image_to_rgb(entry.message).astype(float), entry)
            entry = _with_data(entry, np.rint(changed).astype(np.uint8))
            entry.message.encoding, entry.message.step = 'rgb8', 3 * entry.message.width
        result.append(entry)
    return result


def _pixels(entry: BagMessage) -> Any:
    """Return the bytes (H, W, B) of an image or an organized cloud."""
    message = entry.message
    return np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, -1)


def _with_data(entry: BagMessage, pixels: Any) -> BagMessage:
    changed = _stamped(entry, entry.log_ns, stamp_to_ns(entry.message.header.stamp))
    changed.message.data = array('B', np.ascontiguousarray(pixels, np.uint8).tobytes())
    return changed
