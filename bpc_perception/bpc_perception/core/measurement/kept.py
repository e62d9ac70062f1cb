"""What was found of each sample: it stays when ink of a layer above covers it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import places_of
from bpc_perception.core.measurement.samples import Samples, unseen
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status


@dataclass(frozen=True)
class Kept:
    """The best that was found of N samples of a print.

    Attributes:
        print_id: of the print.
        time: (N,) of their path points, increasing [s].
        samples: what was found.
        looks: (N,) in how many captures it was.
    """

    print_id: str
    time: Array
    samples: Samples
    looks: Index

    @classmethod
    def of(cls, path: DepositionPath, samples: Samples) -> Kept:
        """Return what was found at the points of a path."""
        return cls(path.print_id, path.time, samples, answered(samples).astype(np.intp))

    def at(self, path: DepositionPath) -> Kept:
        """Return what is kept for the points of a path; nothing, of points that are new."""
        known = self.time if self.print_id == path.print_id else self.time[:0]
        found = places_of(known, path.time)
        index = np.flatnonzero(found >= 0)
        samples = unseen(len(path)).with_part(index, self.samples.of(found[index]))
        looks = np.zeros(len(path), np.intp)
        looks[index] = self.looks[found[index]]
        return Kept(path.print_id, path.time, samples, looks)

    def with_better(self, index: Index, new: Samples) -> Kept:
        """Return it with what a capture shows at an index (K,), where that is better known."""
        old = self.samples.of(index)
        with np.errstate(invalid='ignore'):
            better = ~answered(old) | (answered(new) & ~(new.sigma > old.sigma))
        looks = self.looks.copy()
        looks[index] += answered(new)
        return replace(self, looks=looks, samples=self.samples.with_part(
            index[better], new.of(np.flatnonzero(better))))

    def where_unseen(self, samples: Samples) -> Samples:
        """Return the samples of a capture (N,), and what was known before where it sees nothing.

        Something stands in front, or the camera looks elsewhere: the ink is still there.
        """
        hidden = np.isin(samples.status, (Status.NO_DATA, Status.OCCLUDED))
        index = np.flatnonzero(hidden & answered(self.samples))
        return samples.with_part(index, self.samples.of(index))


def answered(samples: Samples) -> Flags:
    """Return of which samples (N,) it is known how wide the ink is, or that there is none."""
    return np.isin(samples.status, (Status.MEASURED, Status.GAP))
