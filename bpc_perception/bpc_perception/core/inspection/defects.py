"""Find defects: where the print is out of its tolerances, from where to where, and how far.

As in the inspection of beads of glue: samples side by side along the path, each judged by itself,
and a defect is a number of them in a row. A sample is outside only where its uncertainty leaves
no doubt [ISO 14253-1: to prove a fault, the band is widened by the uncertainty].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.ndimage import median_filter

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.config import ToleranceConfig
from bpc_perception.core.design.comparison import DesignComparison, DesignFindings
from bpc_perception.core.design.presence import Missing, Presence
from bpc_perception.core.profile import Cause, Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

SURE_SIGMAS = 2.0  # by which a value is out of its band: 95 %
LEAST_KNOWN = 2  # samples out of their band, between which nothing is known
BRIDGED_M = 2e-3  # without an answer within one defect
SURROUNDINGS_M = 1e-2  # of a neck, with whose median it is compared
LEAST_SKIPPED_M = 2e-3  # of a design: less may be a corner that is cut
MISSING_SHARE = 0.8  # of a stroke on which bed is seen: the rest is hardly more


class DefectKind(IntEnum):
    """What is wrong; the numbers are those of PrintVerdict.msg."""

    THIN = 0
    THICK = 1
    LOW = 2
    HIGH = 3
    OFF_PATH = 4
    GAP = 5
    NECK = 6
    OOZE = 7
    MISSING_STROKE = 8
    OFF_DESIGN = 9
    SKIPPED = 10


@dataclass(frozen=True)
class Defect:
    """Something wrong along a stretch of the print.

    Attributes:
        kind: what.
        stroke: number of the stroke; 0 = travel. What was skipped has that of the design's stroke.
        layer: of the stroke, or of the last one before the travel.
        start, end: arc lengths, along the design's stroke of what was skipped [m].
        worst: what is farthest out of its band: a width, height, or offset (to the left > 0), or
            the length of a gap, of ooze, or of a stroke that is missing or skipped [m].
        limit: what it may be there [m].
        samples: how many samples are wrong; of what was skipped, how many pieces of the design.
        middle: where it is, in the base frame [m].
    """

    kind: DefectKind
    stroke: int
    layer: int
    start: float
    end: float
    worst: float
    limit: float
    samples: int
    middle: tuple[float, float, float]

    def is_part_of(self, other: Defect) -> bool:
        """Return whether it overlaps another of its kind."""
        return (self.kind == other.kind and self.start <= other.end and other.start <= self.end
                and (self.kind != DefectKind.SKIPPED or self.stroke == other.stroke))


@dataclass(frozen=True)
class Check:
    """What a value is compared with, sample by sample.

    Attributes:
        kind: of the defect where it is out of its band.
        value: (N,) [m]; NaN = not known.
        limit: (N,) [m].
        excess: (N,) how far the value is out of its band, beyond doubt if above 0 [m]; NaN = not
            known.
    """

    kind: DefectKind
    value: Array
    limit: Array
    excess: Array


def checks_of(profile: ThicknessProfile, targets: WidthTargets | None,
              tolerance: ToleranceConfig,
              design: DesignComparison | None = None) -> Iterator[Check]:
    """Yield the checks that are made sample by sample; without a target, width has none."""
    if targets is not None and tolerance.width:
        target = targets.at(profile.arc_length)
        yield from _band(profile.thickness, profile.sigma, target, tolerance.width,
                         (DefectKind.THIN, DefectKind.THICK))
    if tolerance.target_height and tolerance.height:
        target = np.full(len(profile), tolerance.target_height)
        yield from _band(profile.height, profile.height_sigma, target, tolerance.height,
                         (DefectKind.LOW, DefectKind.HIGH))
    if tolerance.offset:
        limit = tolerance.offset * (profile.thickness if targets is None else
                                    targets.at(profile.arc_length))
        yield _offset(profile, limit)
        if design is not None and design.deviations is not None:
            away = design.deviations.bead
            yield Check(DefectKind.OFF_DESIGN, away, limit * np.sign(away),
                        np.abs(away) - limit - SURE_SIGMAS * profile.sigma / 2)
    if tolerance.neck:
        usual = _surroundings(profile)
        limit = (1 - tolerance.neck) * usual
        yield Check(DefectKind.NECK, profile.thickness, limit,
                    limit - profile.thickness - SURE_SIGMAS * profile.sigma)


def _band(value: Array, sigma: Array, target: Array, share: float,
          kinds: tuple[DefectKind, DefectKind]) -> Iterator[Check]:
    """Yield the checks on both limits of a band around a target (N,) [m]."""
    low, high = (1 - share) * target, (1 + share) * target
    doubt = SURE_SIGMAS * sigma
    yield Check(kinds[0], value, low, low - value - doubt)
    yield Check(kinds[1], value, high, value - high - doubt)


def _offset(profile: ThicknessProfile, limit: Array) -> Check:
    """Return the check of the bead's middle against the path."""
    offset = (profile.left - profile.right) / 2
    excess = np.abs(offset) - limit - SURE_SIGMAS * profile.sigma / 2
    # As far off as that no sample tells its width; the ink of all together tells the shift.
    far = profile.cause == Cause.OFF_PATH
    shift = float(np.linalg.norm(profile.shift))
    beyond = np.nan_to_num(shift - limit, nan=np.inf)
    return Check(DefectKind.OFF_PATH, np.where(far, shift, offset),
                 np.where(far, limit, limit * np.sign(offset)), np.where(far, beyond, excess))


def _surroundings(profile: ThicknessProfile) -> Array:
    """Return the median width (N,) of what was measured around each sample of a stroke [m]."""
    usual = np.full(len(profile), np.nan)
    measured = profile.status == Status.MEASURED
    for stroke in samples_of_strokes(profile):
        own = stroke[measured[stroke]]
        step = np.median(np.diff(profile.arc_length[own])) if len(own) > 1 else 0.0
        if step > 0:
            size = 2 * round(SURROUNDINGS_M / 2 / float(step)) + 1
            usual[own] = median_filter(profile.thickness[own], size, mode='reflect')
    return usual


def samples_of_strokes(profile: ThicknessProfile) -> list[Index]:
    """Return the places of the samples of each stroke, in the order of their numbers."""
    order = np.argsort(profile.stroke, kind='stable')
    order = order[profile.stroke[order] > 0]
    if not len(order):
        return []
    return np.split(order, np.flatnonzero(np.diff(profile.stroke[order])) + 1)


def inner(profile: ThicknessProfile, ends: float) -> Flags:
    """Return which samples (N,) of strokes lie farther than ``ends`` [m] from both their ends."""
    arc, strokes = profile.arc_length, profile.strokes
    inside = np.zeros(len(profile), bool)
    laid = profile.stroke > 0
    place = np.searchsorted(strokes.number, profile.stroke[laid])
    start, end = strokes.commanded[place].T
    inside[laid] = np.minimum(arc[laid] - start, end - arc[laid]) >= ends
    return inside


def find_defects(profile: ThicknessProfile, checks: Sequence[Check], inside: Flags,
                 tolerance: ToleranceConfig) -> list[Defect]:
    """Return the defects of a print, in the order of the path.

    Args:
        profile: N samples.
        checks: that are made sample by sample.
        inside: (N,) samples for which these are made.
        tolerance: how far the print may be off.
    """
    found = [defect for check in checks
             for defect in _in_a_row(profile, check, inside, tolerance.samples)]
    thin = [each for each in found if each.kind == DefectKind.THIN]
    found = [each for each in found if each.kind != DefectKind.NECK
             or not any(one.start <= each.end and each.start <= one.end for one in thin)]
    missing = (_missing_strokes(profile, tolerance.gap_length)
               if tolerance.missing_strokes else [])
    if tolerance.gap_length:
        absent = {each.stroke for each in missing}
        found += [gap for gap in _runs(profile, DefectKind.GAP, profile.gaps, tolerance.gap_length)
                  if gap.stroke not in absent]
    if tolerance.ooze_length:
        found += _runs(profile, DefectKind.OOZE, profile.ooze, tolerance.ooze_length)
    return sorted([*found, *missing], key=lambda each: (each.start, each.kind))


def _in_a_row(profile: ThicknessProfile, check: Check, judged: Flags,
              fewest: int) -> Iterator[Defect]:
    """Yield the runs of at least ``fewest`` samples that are out of their band.

    Where between and beside them it is not known for lack of confidence, as in a steep neck, two
    of them are enough.
    """
    inked = profile.status != Status.GAP  # where bed is seen, a width of 0 is not thin
    known = np.flatnonzero(judged & inked & ~np.isnan(check.excess))
    if not len(known):
        return
    outside = check.excess[known] > 0
    arc, stroke = profile.arc_length[known], profile.stroke[known]
    spacing = float(np.median(np.diff(profile.arc_length))) if len(profile) > 1 else 0.0
    apart = ((np.diff(outside) != 0) | (np.diff(stroke) != 0)
             | (np.diff(arc) > max(BRIDGED_M, 1.5 * spacing)))
    for run in np.split(np.arange(len(known)), np.flatnonzero(apart) + 1):
        own = known[run]
        if (outside[run[0]] and len(run) >= min(fewest, LEAST_KNOWN)
                and _not_good(profile, own) >= fewest):
            worst = own[np.argmax(check.excess[own])]
            yield _defect(profile, check.kind, own, (float(arc[run[0]]), float(arc[run[-1]])),
                          float(check.value[worst]), float(check.limit[worst]))


def _not_good(profile: ThicknessProfile, own: Index) -> int:
    """Return the length of a row of samples: from the first to the last of ``own`` (K,).

    With the samples of LOW_CONFIDENCE beside them: there the bead changes too fast for a width.
    """
    doubtful = profile.status == Status.LOW_CONFIDENCE
    first, last = int(own[0]), int(own[-1])
    while first > 0 and doubtful[first - 1]:
        first -= 1
    while last + 1 < len(doubtful) and doubtful[last + 1]:
        last += 1
    return last - first + 1


def _missing_strokes(profile: ThicknessProfile, allowed: float) -> list[Defect]:
    """Return the strokes that are bed for the most part, and longer than a gap that is allowed.

    As long as they are shorter, ink may only be late.
    """
    return [_defect(profile, DefectKind.MISSING_STROKE, own, (start, end), end - start, 0.0)
            for own, (start, end) in zip(samples_of_strokes(profile),
                                         profile.strokes.commanded.tolist(), strict=True)
            if end - start > allowed and profile.missing[own].mean() > MISSING_SHARE]


def _runs(profile: ThicknessProfile, kind: DefectKind, runs: Array,
          limit: float) -> list[Defect]:
    """Return the runs (R, 2) [m] that are longer than a limit."""
    return [_defect(profile, kind, np.flatnonzero(
                (profile.arc_length >= start) & (profile.arc_length <= end)), (start, end),
                end - start, limit)
            for start, end in runs.tolist() if end - start > limit]


def _defect(profile: ThicknessProfile, kind: DefectKind, own: Index, extent: tuple[float, float],
            worst: float, limit: float) -> Defect:
    """Return a defect of the samples ``own``."""
    layers = profile.layer[:own[-1] + 1]
    laid = np.flatnonzero(layers >= 0)
    x, y, z = (float(np.interp(sum(extent) / 2, profile.arc_length, axis))
               for axis in profile.points.T)
    return Defect(kind, int(profile.stroke[own[len(own) // 2]]),
                  int(layers[laid[-1]]) if len(laid) else 0, *extent, worst, limit, len(own),
                  (x, y, z))


def skipped(design: DesignFindings, over: bool = False) -> list[Defect]:
    """Return the parts of a design on which no ink was commanded, though the print went on.

    Where the print is over, nothing is yet to come.
    """
    reasons = (Presence.SKIPPED, *([Presence.YET_TO_COME] if over else []))
    return [Defect(DefectKind.SKIPPED, each.stroke + 1, each.layer, each.start, each.end,
                   each.end - each.start, 0.0, each.count, each.middle)
            for each in _parts(design, reasons)]


def is_all_known(design: DesignFindings) -> bool:
    """Return whether it is known where a design lies, and what was commanded along all of it."""
    return not (design.registration.refusal or _parts(design, [Presence.NOT_RECORDED]))


def _parts(design: DesignFindings, reasons: Sequence[Presence]) -> list[Missing]:
    return [each for each in design.missing
            if each.presence in reasons and each.end - each.start > LEAST_SKIPPED_M]
