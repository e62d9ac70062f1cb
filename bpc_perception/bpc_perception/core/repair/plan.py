"""What is proposed for the layers of a print: strokes that fill it, and whether to go on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

from bpc_perception.core.arrays import Array


class FillKind(IntEnum):
    """What a stretch lacks; the numbers are those of RepairPlan.msg."""

    GAP = 0
    THIN = 1


class NotFilled(IntEnum):
    """Why a stretch that lacks ink is not filled; the numbers are those of RepairPlan.msg."""

    ALLOWED = 0
    SHORT = 1
    END_NOT_SEEN = 2
    FLOW_NOT_KNOWN = 3
    AREA_NOT_KNOWN = 4
    ENOUGH_INK = 5
    COVERED = 6
    WIDTH_NOT_KNOWN = 7
    CONTRADICTION = 8


class NextLayer(IntEnum):
    """Whether the next layer can be laid; the numbers are those of RepairPlan.msg."""

    NOT_KNOWN = 0
    YES = 1
    NO = 2


class Obstacle(IntEnum):
    """Why the next layer cannot be laid, or it is not known; the numbers of RepairPlan.msg."""

    GAP = 0
    HIGH = 1
    LOW = 2
    NOT_ENOUGH_SEEN = 3
    HEIGHT_NOT_KNOWN = 4
    CONTRADICTION = 5


FORBIDS = frozenset((Obstacle.GAP, Obstacle.HIGH, Obstacle.LOW))


@dataclass(frozen=True)
class Fill:
    """A stroke that lays what a stretch lacks.

    Attributes:
        kind: what it lacks.
        stroke, layer: in which it lies.
        start, end: arc lengths of the print's path between which ink is lacking [m].
        arc_length: (K,) of the way, from before the start to behind the end [m].
        points: (K, 3) of the way: nozzle tip in the robot base frame [m].
        area: (K,) volume of ink that is lacking per length, from each point to the next [m^2]; 0
            where the way only joins the ink at the sides, and at the last point.
        speed: with which the nozzle passed there [m/s].
    """

    kind: FillKind
    stroke: int
    layer: int
    start: float
    end: float
    arc_length: Array
    points: Array
    area: Array
    speed: float

    @property
    def flow(self) -> Array:
        """Flow (K,) from each point to the next [m^3/s]."""
        return self.area * self.speed

    @property
    def volume(self) -> float:
        """Volume that is lacking [m^3]."""
        return float(self.area[:-1] @ (self.arc_length[1:] - self.arc_length[:-1]))


@dataclass(frozen=True)
class Unfilled:
    """A stretch that lacks ink and is not filled.

    Attributes:
        kind: what it lacks.
        stroke, layer: in which it lies.
        start, end: arc lengths between which it is [m].
        middle: where it is: nozzle tip in the robot base frame [m].
        reason: why not.
    """

    kind: FillKind
    stroke: int
    layer: int
    start: float
    end: float
    middle: tuple[float, float, float]
    reason: NotFilled


@dataclass(frozen=True)
class LayerState:
    """A layer as the next one finds it.

    Attributes:
        next_layer: whether that can be laid.
        obstacles: why not, or why it is not known.
        seen: share of its samples that are measured, or known to be gap; NaN without any.
        longest_gap, longest_unseen: lengths of path without ink, and without an answer [m].
        height: that ink of the layer has, or shall have [m]; NaN = not known.
        highest, lowest: heights of ink that were measured [m]; NaN = none.
    """

    next_layer: NextLayer
    obstacles: tuple[Obstacle, ...]
    seen: float
    longest_gap: float
    longest_unseen: float
    height: float
    highest: float
    lowest: float


@dataclass(frozen=True)
class LayerRepair:
    """What is proposed for a layer.

    Attributes:
        number: of the layer, 0 = on the bed.
        finished: whether the print has ended, or gone on with a higher layer.
        state: as the next layer finds it.
        fills: strokes to fill, in the order of the path.
        unfilled: what lacks ink and is not filled, likewise.
    """

    number: int
    finished: bool
    state: LayerState
    fills: tuple[Fill, ...]
    unfilled: tuple[Unfilled, ...]


@dataclass(frozen=True)
class RepairPlan:
    """What is proposed for a print, by what was seen of it in one capture.

    Attributes:
        stamp_ns: stamp of the capture [ns].
        print_id: identifier of the print.
        laying: whether ink was being laid at the capture.
        layers: from the bed upward, also those that go on.
    """

    stamp_ns: int
    print_id: str
    laying: bool
    layers: tuple[LayerRepair, ...]

    @classmethod
    def none(cls, stamp_ns: int) -> RepairPlan:
        """Return that from this time on [ns] there is no print."""
        return cls(stamp_ns, '', False, ())

    @property
    def finished(self) -> tuple[LayerRepair, ...]:
        """The layers that are finished: only for them anything is proposed."""
        return tuple(each for each in self.layers if each.finished)

    @property
    def fills(self) -> tuple[Fill, ...]:
        """The strokes to fill of all finished layers."""
        return tuple(fill for layer in self.finished for fill in layer.fills)

    def at_its_end(self) -> RepairPlan:
        """Return the plan where nothing more comes; not if ink was still laid at the capture."""
        if self.laying:
            return self
        return replace(self, layers=tuple(replace(each, finished=True) for each in self.layers))
