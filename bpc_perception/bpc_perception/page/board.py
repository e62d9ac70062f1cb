"""What the page knows of a print: written by the node's thread, read by the server's.

Each attribute is replaced as a whole and never changed in place, so that neither thread waits for
the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime
from enum import IntEnum
import time

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.design.comparison import DesignFindings
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.wording import ALARMS, REASONS

WIDEST_OVERLAY_PX = 1600  # larger ones are made smaller
JPEG_QUALITY = 85  # up to 100
MOST_EVENTS = 30  # the newest are kept
STALE_AFTER_S, ERROR_AFTER_S = 3.0, 10.0  # without a word from a node that speaks once a second
# Nodes without which nothing is measured: they are missed even if they never spoke.
NEEDED_NODES = ('path_recorder', 'thickness')
SUPERVISOR = 'supervisor: '  # in front of the name of a node for which the supervisor speaks


class Level(IntEnum):
    """The state of a node; the first four are those of DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3
    UNHEARD = 4


@dataclass(frozen=True)
class Health:
    """What a node said about itself last, and when, by the steady clock [s]."""

    level: Level
    words: str
    heard: float

    def now(self, at: float) -> tuple[Level, str]:
        """Return level and words at a steady time [s]; silence counts more than the last word."""
        age = at - self.heard
        if age > STALE_AFTER_S:
            level = Level.ERROR if age > ERROR_AFTER_S else Level.STALE
            return level, f'silent for {age:.0f} s'
        return self.level, self.words


@dataclass(frozen=True)
class Event:
    """Something that a person should know.

    Attributes:
        source: node, or 'advice'.
        words: what happened.
        alarm: whether it is worse than a warning.
        at: time of day of the last time.
        times: how often it happened.
    """

    source: str
    words: str
    alarm: bool
    at: str
    times: int = 1

    @property
    def kind(self) -> tuple[str, str]:
        """What events of one kind share: the source, and the words before the first colon."""
        return self.source, self.words.split(':')[0]


@dataclass(frozen=True)
class Overlay:
    """The camera's image with what was measured, as JPEG."""

    stamp_ns: int
    jpeg: bytes


@dataclass(frozen=True)
class TargetBand:
    """The target thickness along the path with its dead band, as a share of the target.

    A deviation within the dead band is not corrected; NaN = not known.
    """

    targets: WidthTargets
    dead_band: float


class Board:
    """The newest of everything; see the module for threads.

    Attributes:
        now_ns: the node's clock [ns], which a recording may slow down or stop.
        profile, advice, verdict, design, overlay, target: None until there is one.
        nodes: what each node said last, by name.
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
        self.verdict: PrintVerdict | None = None
        self.design: DesignFindings | None = None
        self.overlay: Overlay | None = None
        self.target: TargetBand | None = None
        self.events: tuple[Event, ...] = ()

    def forget_print(self) -> None:
        """Show no print any more; what happened to it can still be read."""
        self.profile = self.advice = self.verdict = self.design = self.overlay = None

    def advise(self, advice: RateAdvice) -> None:
        """Take new advice; an alarm is an event, counted while it lasts."""
        self.advice = advice
        if advice.reason in ALARMS:
            self._add_event('advice', REASONS[advice.reason], alarm=True)

    def hear(self, name: str, level: Level, words: str) -> None:
        """Take what a node says about itself."""
        self.nodes = {**self.nodes, name: Health(level, words, time.monotonic())}
        if level in (Level.WARN, Level.ERROR):  # what is stale has not begun yet
            self._add_event(name.removeprefix(SUPERVISOR), words, alarm=level == Level.ERROR)

    def _add_event(self, source: str, words: str, alarm: bool) -> None:
        """Add an event; it takes the place of those of its kind."""
        event = Event(source, words, alarm, f'{datetime.now():%H:%M:%S}')
        same = [other for other in self.events if other.kind == event.kind]
        event = replace(event, times=1 + sum(other.times for other in same))
        others = (other for other in self.events if other not in same)
        self.events = (event, *others)[:MOST_EVENTS]

    def health(self) -> dict[str, tuple[Level, str]]:
        """Return level and words of each node now, by name."""
        at = time.monotonic()
        unheard = dict.fromkeys(NEEDED_NODES, (Level.UNHEARD, 'not heard yet'))
        alive = {name: health.now(at) for name, health in sorted(self.nodes.items())
                 if not name.startswith(SUPERVISOR)}
        # The dead do not speak for themselves.
        dead = {name.removeprefix(SUPERVISOR): health.now(at)
                for name, health in self.nodes.items()
                if name.startswith(SUPERVISOR) and health.level == Level.ERROR}
        return unheard | alive | dead


def overlay_of(stamp_ns: int, image: NDArray[np.uint8]) -> Overlay:
    """Make an overlay of an image RGB (H, W, 3), no wider than WIDEST_OVERLAY_PX."""
    height, width = image.shape[:2]
    if width > WIDEST_OVERLAY_PX:
        size = (WIDEST_OVERLAY_PX, round(height * WIDEST_OVERLAY_PX / width))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    _, jpeg = cv2.imencode('.jpg', cv2.cvtColor(image, cv2.COLOR_RGB2BGR),
                           [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return Overlay(stamp_ns, jpeg.tobytes())
