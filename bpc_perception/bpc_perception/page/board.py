"""What the page knows of a print: written by the node's thread, read by the server's.

Each attribute is replaced as a whole and never changed in place, so that neither thread waits for
the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from enum import IntEnum
import time

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.display.wording import ALARMS, REASONS

WIDEST = 1600  # overlay [pixels]; larger ones are made smaller
QUALITY = 85  # of its JPEG, up to 100
EVENTS = 30  # the newest that are kept
LATE, SILENT = 3.0, 10.0  # of a node that speaks once a second [s]
# Nodes without which nothing is measured: missed where they never spoke.
NEEDED = ('path_recorder', 'thickness')
SUPERVISOR = 'supervisor: '  # in front of the name of a node that it speaks for


class Level(IntEnum):
    """How a node is; the first four are those of DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3
    UNHEARD = 4


@dataclass(frozen=True)
class Health:
    """What a node said of itself last, and when, by the steady clock [s]."""

    level: Level
    words: str
    heard: float

    def now(self, at: float) -> tuple[Level, str]:
        """Level and words at a steady time [s]: who is silent is no longer what it was."""
        age = at - self.heard
        if age > LATE:
            return (Level.ERROR if age > SILENT else Level.STALE), f'silent for {age:.0f} s'
        return self.level, self.words


@dataclass(frozen=True)
class Event:
    """Something that a person should know of; how often it came, and when last."""

    source: str
    words: str
    alarm: bool
    at: str
    times: int = 1


@dataclass(frozen=True)
class Overlay:
    """The camera's image with what was measured, as JPEG."""

    stamp_ns: int
    jpeg: bytes


@dataclass(frozen=True)
class Goal:
    """The thickness wanted along the path, and the share by which it may be missed."""

    targets: WidthTargets
    dead_band: float


class Board:
    """The newest of everything; see the module on threads.

    Attributes:
        now_ns: the node's clock [ns], which a recording may slow down or stop.
        profile, advice, overlay, goal: None until there is one.
        nodes: by name.
        events: the newest first.
    """

    def __init__(self, now_ns: Callable[[], int]) -> None:
        self.now_ns = now_ns
        self.nodes: dict[str, Health] = {}
        self.clear()

    def clear(self) -> None:
        """Forget the print."""
        self.profile: ThicknessProfile | None = None
        self.advice: RateAdvice | None = None
        self.overlay: Overlay | None = None
        self.goal: Goal | None = None
        self.events: tuple[Event, ...] = ()

    def advise(self, advice: RateAdvice) -> None:
        """Take new advice; an alarm is an event, counted while it lasts."""
        self.advice = advice
        if advice.reason in ALARMS:
            self.tell('advice', REASONS[advice.reason], alarm=True)

    def hear(self, name: str, level: Level, words: str) -> None:
        """Take what a node says of itself."""
        self.nodes = {**self.nodes, name: Health(level, words, time.monotonic())}
        if level in (Level.WARN, Level.ERROR):  # what is stale has not begun yet
            self.tell(name.removeprefix(SUPERVISOR), words, alarm=level == Level.ERROR)

    def tell(self, source: str, words: str, alarm: bool) -> None:
        """Keep an event; of one kind, told by the words before the first colon, the last."""
        kind = (source, words.split(':')[0])
        same = [event for event in self.events
                if (event.source, event.words.split(':')[0]) == kind]
        event = Event(source, words, alarm, f'{datetime.now():%H:%M:%S}',
                      1 + sum(event.times for event in same))
        self.events = (event, *(event for event in self.events if event not in same))[:EVENTS]

    def health(self) -> dict[str, tuple[Level, str]]:
        """Level and words of each node now, by name."""
        at = time.monotonic()
        unheard = dict.fromkeys(NEEDED, (Level.UNHEARD, 'not heard yet'))
        said = {name: health.now(at) for name, health in sorted(self.nodes.items())
                if not name.startswith(SUPERVISOR)}
        # The dead do not speak for themselves.
        dead = {name.removeprefix(SUPERVISOR): health.now(at)
                for name, health in self.nodes.items()
                if name.startswith(SUPERVISOR) and health.level == Level.ERROR}
        return unheard | said | dead


def overlay_of(stamp_ns: int, image: NDArray[np.uint8]) -> Overlay:
    """An overlay from an image RGB (H, W, 3)."""
    height, width = image.shape[:2]
    if width > WIDEST:
        size = (WIDEST, round(height * WIDEST / width))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    _, jpeg = cv2.imencode('.jpg', cv2.cvtColor(image, cv2.COLOR_RGB2BGR),
                           [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return Overlay(stamp_ns, jpeg.tobytes())
