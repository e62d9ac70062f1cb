"""Edges of the ink on either side of a path, to a fraction of a pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.measurement.cross_section.edges.continuity import (
    follow_along_path,
    Located,
)
from bpc_perception.core.measurement.cross_section.edges.crossing import find_crossing
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)

Kind = TypeVar('Kind', np.float32, np.bool_)

SETTLED_PX = 2.0  # a shorter stretch of bed is noise
GLARE_PX = 7.0  # a shorter stretch of bed with ink behind it may be glare


@dataclass(frozen=True)
class Edges:
    """First edges outward from N path points on one side.

    Attributes:
        distance: (N,) from the path [m]; NaN = none found.
        sigma: (N,) its 1-sigma uncertainty from noise [m].
        hidden, outside, joined: (N,) whether an obstacle, the image's border or ink up to
            another pass of the path comes first.
    """

    distance: Array
    sigma: Array
    hidden: Flags
    outside: Flags
    joined: Flags


@dataclass(frozen=True)
class _Outward:
    """What is seen from N path points outward, first on their right, then on their left.

    Attributes:
        share: (2N, K) of ink in each sample.
        nearer, farther: (2N,) first sample behind which there is bed for long enough to be no
            noise, and to be no glare; K = none.
        border: (2N,) first sample that belongs to another pass; K = none,
        nearing: (2N,) and first one from which on that comes nearer. A section beside a crossing
            runs beside the other pass: the bed there has one level.
        hidden, outside, joined: (2N,) what comes before the edge, see Edges.
    """

    share: Floats
    nearer: Index
    farther: Index
    border: Index
    nearing: Index
    hidden: Flags
    outside: Flags
    joined: Flags


def find_edges(sections: Sections, noise: Array, ink: Floats) -> tuple[Edges, Edges]:
    """Find the first edges outward on the right and on the left.

    Behind an edge the bed has to be seen for a while. A stretch too short for that, with ink
    again behind it, may be glare on the bead, or bed before a drop spilled beside it: then the
    nearer or the farther edge is right, whichever goes on along the path.

    Args:
        sections: N sections with M samples each.
        noise: (N,) 1-sigma noise of a share of ink.
        ink: (N, M) share of ink in each sample, NaN = not seen.
    """
    seen = _look_outward(sections, ink)
    sure = seen.nearer == seen.farther
    near = _locate(seen, seen.nearer, np.ones(len(sure), bool), sections, noise)
    far = _locate(seen, seen.farther, ~sure, sections, noise).or_else(near, sure)
    count = len(noise)
    right, left = (
        Edges(*follow_along_path(sections, noise, seen.share[side], near.part(side),
                                 far.part(side), sure[side]),
              seen.hidden[side], seen.outside[side], seen.joined[side])
        for side in (slice(None, count), slice(count, None)))
    return right, left


def _look_outward(sections: Sections, ink: Floats) -> _Outward:
    """Look outward from the path on both sides for what comes first."""
    middle = sections.on_path

    def outward(values: NDArray[Kind]) -> NDArray[Kind]:
        return np.concatenate((values[:, middle::-1], values[:, middle:]))

    share = outward(ink)
    count = share.shape[1]
    border, nearing = (_first_run(outward(flags), 1)
                       for flags in (sections.foreign, sections.nearing))
    bed = share < 0.5  # False where it is not seen
    bed |= np.arange(count) >= border[:, None]
    nearer, farther = (_first_run(bed, round(length / SAMPLE_STEP_PX))
                       for length in (SETTLED_PX, GLARE_PX))
    before = np.arange(count) < nearer[:, None]
    hidden: Flags = np.any(outward(sections.hidden) & before, axis=1)
    outside: Flags = np.any(outward(~sections.inside) & before, axis=1)
    joined = (nearer >= border) & (border < count) & ~hidden & ~outside
    return _Outward(share, nearer, farther, border, nearing, hidden, outside, joined)


def _locate(seen: _Outward, first: Index, asked: Flags, sections: Sections,
            noise: Array) -> Located:
    """Locate the edges near the samples ``first`` (2N,); NaN where not asked (2N,), or none."""
    step = SAMPLE_STEP_PX * sections.pixel
    noise = np.tile(noise, 2)
    known = ~(seen.hidden | seen.outside | seen.joined)
    row = np.flatnonzero(asked & known & (first > 0) & (first < seen.border))
    distance, sigma = np.full((2, len(first)), np.nan)
    place, slope = find_crossing(seen.share[row], first[row], seen.nearing[row], noise[row])
    distance[row], sigma[row] = place * step, noise[row] * step / slope
    return Located(distance, sigma)


def _first_run(flags: Flags, length: int) -> Index:
    """Return where (N,) the first run of ``length`` True starts in each row (N, K); K = none."""
    # Eroded to where the next samples are all True; beyond the end of a row they are.
    full = np.ones((len(flags), flags.shape[1] + 1), np.uint8)
    full[:, :-1] = cv2.erode(flags.view(np.uint8), np.ones((1, length), np.uint8), anchor=(0, 0),
                             borderType=cv2.BORDER_CONSTANT, borderValue=1)
    return np.argmax(full.view(bool), axis=1)
