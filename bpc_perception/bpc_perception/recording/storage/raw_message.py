"""What lies in a storage file, before anybody knows what it means."""

from __future__ import annotations

from typing import NamedTuple

CDR, PACKED = 'cdr', 'cdr-bpc-planes'  # others shall not take what is packed for a message


class BagError(ValueError):
    """A recording is not what was expected; the message names both."""


class Channel(NamedTuple):
    """A topic with the type of its messages.

    Attributes:
        topic: the recorded topic.
        type_name: such as ``sensor_msgs/msg/Image``.
        definition: the text of the type; empty when the storage has none.
        definition_encoding: the language of that text.
        encoding: how the messages are serialized; PACKED = some are packed as well.
        metadata: what else the storage says of the topic, such as QoS; names and texts.
    """

    topic: str
    type_name: str
    definition: bytes = b''
    definition_encoding: str = 'ros2msg'
    encoding: str = CDR
    metadata: tuple[tuple[str, str], ...] = ()


class RawMessage(NamedTuple):
    """A message as it lies in the file.

    Attributes:
        channel: its topic and type.
        log_ns: time of recording [ns].
        data: the serialized message, which may be packed; see ``unpacked``.
        publish_ns: time of publication [ns].
        sequence: number that the publisher gave it.
    """

    channel: Channel
    log_ns: int
    data: bytes
    publish_ns: int
    sequence: int = 0

    @property
    def topic(self) -> str:
        """The recorded topic."""
        return self.channel.topic

    @property
    def type_name(self) -> str:
        """The type, such as ``sensor_msgs/msg/Image``."""
        return self.channel.type_name
