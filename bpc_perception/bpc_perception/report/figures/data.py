"""What these figures and those for papers share: interrupted lines, ranges of axes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.units import MM_PER_M

LEAST_OFFSET_MM = 0.05  # a smaller range would show mere noise
RANGE_MARGIN = 0.25  # of what is shown, above and below
LEAST_MARGIN = 0.03  # of the largest thickness: more would show mere noise
EMPTY_CEILING_MM = 1.0  # of an axis on which nothing is drawn


def pen_up(values: Array, chosen: NDArray[np.bool_]) -> Array:
    """Return a line through the chosen samples, which is interrupted where none is chosen.

    Each run of chosen samples is extended half-way to its neighbours, as far as these are known,
    so that a single sample can be seen.

    Args:
        values: (N, K); the first two columns are the place.
        chosen: (N,).

    Returns:
        (M, K), with a row of NaN behind each run.
    """
    middles = (values[1:] + values[:-1]) / 2
    nothing = np.full((1, values.shape[1]), np.nan)
    borders = np.flatnonzero(np.diff(np.concatenate(
        ([False], chosen, [False])).astype(np.int8))).reshape(-1, 2)
    parts = []
    for start, end in borders:
        before = middles[start - 1:start] if start else nothing[:0]
        parts += [part for part in (before, values[start:end], middles[end - 1:end])
                  if np.isfinite(part[:, :2]).any()]
        parts.append(nothing)
    return np.concatenate(parts) if parts else nothing[:0]


def on_map(profile: ThicknessProfile) -> NDArray[np.bool_]:
    """Return which samples (N,) a map shows: strokes of which something was seen, and ooze.

    A purge line out of the picture, and the ways to it, would make the print small.
    """
    seen = np.unique(profile.stroke[profile.status != Status.NO_DATA])
    strokes = np.isin(profile.stroke, seen[seen > 0])
    return np.asarray(strokes | (profile.status == Status.OOZE))


def thickness_ceiling(profile: ThicknessProfile, targets: WidthTargets | None) -> float:
    """Return up to where thickness is shown at first [mm], so that outliers do not flatten it."""
    target = 0.0 if targets is None else float(targets.thickness.max())
    usual = np.fmax(profile.summary.thickness_median, target)
    if not usual > 0:
        return EMPTY_CEILING_MM
    highest = np.nanmax(np.append(profile.thickness + np.nan_to_num(profile.sigma), usual))
    return 1.1 * MM_PER_M * float(min(highest, 2 * usual))


def thickness_range(profile: ThicknessProfile,
                    targets: WidthTargets | None) -> tuple[float, float]:
    """Return between which thicknesses a curve is shown at first [mm].

    Near enough for one standard deviation to be seen, with the target, and without outliers.
    """
    wanted = np.empty(0) if targets is None else targets.thickness
    known = np.isfinite(profile.sigma)
    low, high = profile.thickness[known] - profile.sigma[known], (
        profile.thickness[known] + profile.sigma[known])
    if not len(low) + len(wanted):
        return 0.0, EMPTY_CEILING_MM
    ends = (float(np.append(wanted, np.percentile(low, 1) if len(low) else []).min()),
            float(np.append(wanted, np.percentile(high, 99) if len(low) else []).max()))
    margin = max(RANGE_MARGIN * (ends[1] - ends[0]), LEAST_MARGIN * ends[1])
    return MM_PER_M * max(0.0, ends[0] - margin), MM_PER_M * (ends[1] + margin)


def offset_range(profile: ThicknessProfile) -> tuple[float, float]:
    """Return between which offsets are shown at first [mm]: without outliers, wider than noise."""
    offset = np.abs(np.append(profile.left - profile.right, 0.0)) / 2 * MM_PER_M
    largest = 1.5 * max(float(np.nanpercentile(offset, 99)), LEAST_OFFSET_MM)
    return -largest, largest
