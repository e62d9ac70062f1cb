"""Which stroke of a test print each sample of its profile is of."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.design.deviation import path_pieces, placed, REACH_M
from bpc_perception.core.design.registration import Registration
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.testprints.plan import TestPrint


@dataclass(frozen=True)
class MatchedPrint:
    """A test print beside the profile of its recording, of N samples.

    Attributes:
        test: as it was planned.
        profile: as it was measured.
        stroke: (N,) index of the planned stroke that each sample is of; -1 = of none, or travel.
        along: (N,) arc length from the start of that stroke [m]; NaN = of none.
    """

    test: TestPrint
    profile: ThicknessProfile
    stroke: Index
    along: Array

    def on(self, index: int) -> Flags:
        """Return which samples (N,) are of a planned stroke."""
        return np.asarray(self.stroke == index)

    def judged(self, index: int) -> Flags:
        """Return which samples (N,) are of the part of a planned stroke that is judged."""
        begin, end = self.test.plans[index].judged
        return self.on(index) & (self.along >= begin) & (self.along <= end)

    def profile_of(self, *strokes: int) -> ThicknessProfile:
        """Return the profile with all but these planned strokes as travel."""
        return replace(self.profile, stroke=np.where(np.isin(self.stroke, strokes),
                                                     self.profile.stroke, 0))


def match(test: TestPrint, profile: ThicknessProfile, place: Registration) -> MatchedPrint:
    """Return which planned stroke each sample of a profile is of.

    A recorded stroke is of that planned one which most of its samples lie on.
    """
    pieces, _ = placed(test.design, place.T_base_design)
    near = path_pieces(profile.points, profile.stroke, pieces)
    stroke = np.full(len(profile), -1)
    along = np.full(len(profile), np.nan)
    for number in np.unique(profile.stroke[near >= 0]).tolist():
        own = np.flatnonzero((profile.stroke == number) & (near >= 0))
        most = int(np.bincount(pieces.stroke[near[own]]).argmax())
        part = pieces.where(pieces.stroke == most)
        piece = part.closest(profile.points[own])
        offset, ahead = part.offsets(profile.points[own], piece)
        found = np.linalg.norm(offset, axis=1) <= REACH_M
        stroke[own[found]] = most
        along[own[found]] = (part.arc_length[piece] + ahead)[found]
    return MatchedPrint(test, profile, stroke, along)
