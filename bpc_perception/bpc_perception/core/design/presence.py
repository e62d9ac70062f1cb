"""What became of each place of the design: printed, missing, not seen, or not there yet."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

import numpy as np

from bpc_perception.core.arrays import Flags, Index
from bpc_perception.core.design.deviation import Deviations, path_pieces, REACH_M
from bpc_perception.core.design.pieces import Pieces
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile

# Along a stroke, from a sample that tells of a place: corners that are cut leave so much out.
ALONG_M = 1e-3
LEAST_THERE = 10  # pieces that tell that the print has come there: one may be of another stroke


class Presence(IntEnum):
    """What is known of a place of the design."""

    PRINTED = 0  # ink is seen
    YET_TO_COME = 1  # the print goes on, and has not come there
    SKIPPED = 2  # no ink was commanded there, though the print went on or is over
    NOT_SEEN = 3  # ink was commanded there, and whether it lies there is not known
    SEEN_MISSING = 4  # ink was commanded there, and bed is seen: GAP
    NOT_RECORDED = 5  # it comes before the recording, which begins with ink


@dataclass(frozen=True)
class Missing:
    """A part of a design's stroke that is not printed, as far as is known.

    Attributes:
        stroke: number of the design's stroke, from 0.
        layer: its number.
        presence: why it is here; never PRINTED.
        start, end: arc lengths along the stroke [m].
        count: of the pieces that tell.
        middle: where it is, in the base frame [m].
    """

    stroke: int
    layer: int
    presence: Presence
    start: float
    end: float
    count: int
    middle: tuple[float, float, float]


def presence_of(profile: ThicknessProfile, path: DepositionPath, pieces: Pieces,
                deviations: Deviations, reach: float = REACH_M) -> Index:
    """Return what became of each piece (M,) of a design: values of Presence.

    Args:
        profile: of the print.
        path: of the print, which may go on beyond the profile. Where the extruder's state is not
            known, ink may have been commanded.
        pieces: of the design, in the base frame.
        deviations: of the profile from it.
        reach: within which ink is of the design [m].
    """
    found = np.full(len(pieces), Presence.YET_TO_COME, np.intp)
    maybe = np.asarray(path.extruding | ~path.extruder_known, np.intp)
    near = path_pieces(path.points, maybe, pieces)
    offset = pieces.offsets(path.points, np.maximum(near, 0))[0]
    near[np.linalg.norm(offset, axis=1) > reach] = -1
    there = np.unique(deviations.piece[deviations.piece >= 0])
    if path.finished:
        found[:] = Presence.SKIPPED
    elif len(there) >= LEAST_THERE:
        found[:there[-LEAST_THERE]] = Presence.SKIPPED
    laid = near[near >= 0]
    if len(laid) and maybe[0]:
        found[:laid[0]] = Presence.NOT_RECORDED
    found[_around(pieces, near)[0]] = Presence.NOT_SEEN
    told, sample = _around(pieces, deviations.piece)
    status = profile.status[sample]
    found[told] = np.select(
        (status == Status.MEASURED, status == Status.GAP),
        (Presence.PRINTED, Presence.SEEN_MISSING), Presence.NOT_SEEN)
    return found


def missing_in(pieces: Pieces, presence: Index) -> tuple[Missing, ...]:
    """Return the parts of strokes that are not printed, in the order of the design.

    Args:
        pieces: M of the design.
        presence: (M,) what became of each.
    """
    changes = (np.diff(presence, prepend=-1) != 0) | pieces.opens
    borders = [*np.flatnonzero(changes).tolist(), len(pieces)]
    return tuple(
        Missing(int(pieces.stroke[one]), int(pieces.layer[one]), Presence(int(presence[one])),
                float(pieces.arc_length[one] - pieces.half[one]),
                float(pieces.arc_length[two - 1] + pieces.half[two - 1]), two - one,
                tuple(pieces.middle[(one + two) // 2].tolist()))
        for one, two in pairwise(borders) if presence[one] != Presence.PRINTED)


def _around(pieces: Pieces, piece: Index) -> tuple[Flags, Index]:
    """Return which pieces (M,) samples tell of, and the nearest sample (T,) of those.

    Args:
        pieces: M of the design.
        piece: (N,) that each sample is of; -1 = none.
    """
    sample = np.flatnonzero(piece >= 0)
    told = np.zeros(len(pieces), bool)
    if not len(sample):
        return told, sample
    sample = sample[np.argsort(piece[sample], kind='stable')]
    at = piece[sample]
    place = np.searchsorted(at, np.arange(len(pieces)))
    before, after = np.maximum(place - 1, 0), np.minimum(place, len(at) - 1)
    # Along all ink, with strokes far apart.
    along = pieces.ink + pieces.stroke * 2 * ALONG_M
    nearer = np.abs(along[at[after]] - along) < np.abs(along - along[at[before]])
    nearest = np.where(nearer, after, before)
    told = np.abs(along[at[nearest]] - along) <= ALONG_M
    return told, sample[nearest[told]]
