"""Bags of text messages on the topic /words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from std_msgs.msg import String

from bpc_perception.recording.bag import Bag

STRING = 'std_msgs/msg/String'


def words(count: int) -> list[String]:
    """Return messages of a few kilobytes."""
    return [String(data=f'word {number} ' * 500) for number in range(count)]


def texts(bag: Path) -> list[Any]:
    """Return the messages of /words as our reader reads them."""
    return [message for _, _, message in Bag(bag).messages({'/words'})]
