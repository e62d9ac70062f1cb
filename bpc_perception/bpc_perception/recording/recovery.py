"""Make a whole recording of what a torn one still holds, with all that it says of itself."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
import logging
from pathlib import Path
import shutil
from typing import Any

from mcap.records import Metadata

from bpc_perception.recording import inputs
from bpc_perception.recording.atomic import atomic_bag
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.storage.files import description, is_storage_file, METADATA
from bpc_perception.recording.storage.packing import unpacked
from bpc_perception.recording.storage.raw_message import (
    BagError,
    CDR,
    PACKED,
    RawMessage,
)
from bpc_perception.recording.storage.storage import open_storage

logger = logging.getLogger(__name__)
# Written anew, since it counts the messages: of these two, only what the recorder's user said.
DESCRIPTION = 'rosbag2'
KEPT_OF_METADATA = ('custom_data', 'ros_distro')


@dataclass(frozen=True)
class Recovered:
    """What a recovered recording has.

    Attributes:
        messages: number of messages by topic.
        left_out: names of what lies beside the recording and is not in the new one.
    """

    messages: dict[str, int]
    left_out: list[str]


def recover_bag(path: Path, out: Path) -> Recovered:
    """Copy all that is readable of a recording into a new bag, unpacked.

    Types, encodings, QoS, times of publication, attachments and metadata stay as they are. The
    files of bpc beside the recording are copied too. Raises BagError, OSError.
    """
    files = Bag(path).files
    folder = files[0].parent
    messages: Counter[str] = Counter()
    said = description(folder)
    about = {name: said[name] for name in KEPT_OF_METADATA if _is_plain(said.get(name))}
    with atomic_bag(out, about) as writer:
        for file in files:
            storage = open_storage(file)
            for record in storage.beside_messages():
                if not (isinstance(record, Metadata) and record.name == DESCRIPTION):
                    writer.copy_beside(record)
            for raw in storage.messages():
                try:
                    writer.copy(plain(raw))
                except BagError as error:
                    logger.warning('%s: left out a message on %s: %s', file, raw.topic, error)
                else:
                    messages[raw.topic] += 1
        beside = sorted(each.name for each in folder.iterdir() if not (
            is_storage_file(each) or each.name == METADATA)) if path.is_dir() else []
        for name in inputs.KEPT_BESIDE:
            if name in beside:
                shutil.copy(folder / name, writer.path)
    return Recovered(dict(messages),
                     [name for name in beside if name not in inputs.KEPT_BESIDE])


def plain(raw: RawMessage) -> RawMessage:
    """Return a message as its publisher serialized it. Raises BagError when it is damaged."""
    channel = raw.channel
    if channel.encoding == PACKED:
        channel = channel._replace(encoding=CDR)
    return raw._replace(channel=channel, data=unpacked(raw.data))


def _is_plain(said: Any) -> bool:
    """Return whether it is a text, or texts by name: aliases could make a billion of it."""
    texts = said.items() if isinstance(said, dict) else [(said, said)]
    return all(isinstance(each, str) for entry in texts for each in entry)
