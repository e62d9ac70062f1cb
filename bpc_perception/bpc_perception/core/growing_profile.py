"""A profile that is passed on by parts: which samples changed, and the whole made of them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from bpc_perception.core.arrays import Index
from bpc_perception.core.profile import ThicknessProfile

# All others have one element a sample.
OF_THE_WHOLE = frozenset(('stamp_ns', 'print_id', 'print_start_ns', 'capture', 'method', 'shift',
                          'tip_height', 'processing_time'))
OF_EACH_SAMPLE = tuple(field.name for field in fields(ThicknessProfile)
                       if field.name not in OF_THE_WHOLE)
MOST_WAITING = 10  # changes of a profile that is not known yet


@dataclass(frozen=True)
class ProfileChange:
    """What changed in a profile since the one before.

    Attributes:
        base_ns: stamp of the profile before [ns].
        index: (M,) places of the samples that changed or are new, increasing.
        part: the profile with these samples alone.
    """

    base_ns: int
    index: Index
    part: ThicknessProfile

    def of(self, before: ThicknessProfile) -> bool:
        """Return whether it changes this profile, and leaves no place without a sample."""
        added = self.index[self.index >= len(before)]
        return (self.part.print_id == before.print_id and self.base_ns == before.stamp_ns
                and np.array_equal(added, len(before) + np.arange(len(added))))


def samples_of(profile: ThicknessProfile, index: Index) -> ThicknessProfile:
    """Return a profile with some of its samples (M,) alone."""
    part: dict[str, Any] = {name: getattr(profile, name)[index] for name in OF_EACH_SAMPLE}
    return replace(profile, **part)


def change_between(before: ThicknessProfile, after: ThicknessProfile) -> ProfileChange | None:
    """Return what changed; None where it is not one print that grew."""
    if before.print_id != after.print_id or len(before) > len(after):
        return None
    same = np.ones(len(before), bool)
    for name in OF_EACH_SAMPLE:
        old, new = getattr(before, name), getattr(after, name)[:len(before)]
        equal = (old == new) | ((old != old) & (new != new))  # NaN is not NaN
        same &= equal if equal.ndim == 1 else equal.all(axis=1)
    index = np.concatenate((np.flatnonzero(~same), np.arange(len(before), len(after))))
    return ProfileChange(before.stamp_ns, index, samples_of(after, index))


def with_change(before: ThicknessProfile, change: ProfileChange) -> ThicknessProfile:
    """Return the whole profile after a change of ``before``, which stays as it is."""
    added = change.index >= len(before)
    whole: dict[str, Any] = {}
    for name in OF_EACH_SAMPLE:
        part = getattr(change.part, name)
        whole[name] = np.concatenate((getattr(before, name), part[added]))
        whole[name][change.index] = part
    return replace(change.part, **whole)


class GrowingProfile:
    """The newest profile, as it is known from whole ones and from changes, in whatever order.

    Attributes:
        profile: the newest; None = none is known.
    """

    def __init__(self) -> None:
        self.profile: ThicknessProfile | None = None
        self._waiting: deque[ProfileChange] = deque(maxlen=MOST_WAITING)

    @property
    def incomplete(self) -> bool:
        """Whether changes came of a profile that is not known."""
        return bool(self._waiting)

    def set_whole(self, profile: ThicknessProfile) -> list[ThicknessProfile]:
        """Take a whole profile; return the profiles that are new with it, in order.

        One of a print as it was before is old news.
        """
        known = self.profile
        if known is not None and (known.print_id == profile.print_id
                                  and profile.stamp_ns <= known.stamp_ns):
            return []
        self.profile = profile
        of_others = [change for change in self._waiting
                     if change.part.print_id != profile.print_id]
        for change in of_others:
            self._waiting.remove(change)
        return [profile, *self._catch_up()]

    def add_change(self, change: ProfileChange) -> list[ThicknessProfile]:
        """Take a change; return the profiles that are new with it, in order.

        It waits where the profile that it changes is not known yet.
        """
        self._waiting.append(change)
        return self._catch_up()

    def _catch_up(self) -> list[ThicknessProfile]:
        """Make the changes that can be made, and forget those that were overtaken."""
        new = []
        known = self.profile
        for change in sorted(self._waiting, key=lambda each: each.part.stamp_ns):
            if known is None:
                break
            if change.of(known):
                known = with_change(known, change)
                new.append(known)
            elif change.part.stamp_ns > known.stamp_ns:
                continue
            self._waiting.remove(change)
        self.profile = known
        return new
