"""The newest stretch of a profile, which advice looks at."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.profile import Status, ThicknessProfile


@dataclass(frozen=True)
class Window:
    """The newest stretch on which ink was to be laid, and what is measured there.

    Attributes:
        extent: arc lengths from and to [m]; NaN = none.
        count: MEASURED samples.
        coverage: their share of all samples.
        width: median thickness [m]; NaN = none measured.
        offset: median distance of the deposit's middle from the path, positive to the left [m].
        age: from the laying of the newest MEASURED sample to the capture [s].
        longest_gap: length of the longest gap [m].
    """

    extent: tuple[float, float]
    count: int
    coverage: float
    width: float
    offset: float
    age: float
    longest_gap: float


def laid_before(profile: ThicknessProfile, acquisition_time: float) -> ThicknessProfile:
    """Return a profile without what was laid while the camera looked, for this time [s].

    Ink that is not there yet is no gap.
    """
    began = (profile.stamp_ns - profile.print_start_ns) * 1e-9 - acquisition_time
    return replace(profile, status=np.where(
        profile.time > began, Status.NO_DATA, profile.status).astype(np.uint8))


def look_back(profile: ThicknessProfile, length: float, start: float) -> Window:
    """Return the newest stretch of this length [m], after arc length ``start`` [m].

    The length is that of strokes: travel between them does not count.
    """
    index = np.flatnonzero(
        profile.extruding & (profile.stroke > 0) & (profile.arc_length >= start))
    arc, stroke = profile.arc_length[index], profile.stroke[index]
    laid = np.append(0.0, np.cumsum(np.where(np.diff(stroke) == 0, np.diff(arc), 0.0)))
    inside = np.zeros(len(profile), bool)
    inside[index[laid[:len(index)] >= laid[-1] - length]] = True
    arc = profile.arc_length[inside]
    extent = (float(arc[0]), float(arc[-1])) if len(arc) else (np.nan, np.nan)
    measured = inside & (profile.status == Status.MEASURED)
    count = int(measured.sum())
    gaps = profile.runs_of(inside & profile.missing)
    longest_gap = float(np.diff(gaps).max(initial=0))
    if not count:
        return Window(extent, 0, 0.0, np.nan, np.nan, np.nan, longest_gap)
    age = (profile.stamp_ns - profile.print_start_ns) * 1e-9 - float(profile.time[measured][-1])
    return Window(
        extent, count, count / int(inside.sum()), float(np.median(profile.thickness[measured])),
        float(np.median(profile.left[measured] - profile.right[measured])) / 2, age, longest_gap)
