"""The result of a measurement: thickness along the path, sample by sample, and its summary."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import runs
from bpc_perception.core.stroke_ends import Strokes, StrokeSamples

LEAST_CLEARANCE_M = 1e-3  # that the nozzle may have above the bed, however narrow the bead
StatusArray = NDArray[np.uint8]
CauseArray = NDArray[np.uint8]


class Status(IntEnum):
    """What is known of a sample; the numbers are those of ThicknessProfile.msg."""

    MEASURED = 0
    GAP = 1
    NO_DATA = 2
    OCCLUDED = 3
    JUNCTION = 4
    LOW_CONFIDENCE = 5
    BARE = 6
    OOZE = 7


class Cause(IntEnum):
    """Why a sample is NO_DATA or LOW_CONFIDENCE; the numbers are those of ThicknessProfile.msg."""

    NONE = 0
    OUTSIDE_IMAGE = 1
    NO_DEPTH = 2
    GLARE = 3
    LOW_CONTRAST = 4
    OVEREXPOSED = 5
    OLD_INK = 6
    NO_EDGE = 7
    FEW_PIXELS = 8
    FAINT_EDGES = 9
    UNSURE_FEET = 10
    INK_ENDS = 11
    PARTLY_INK = 12
    RAISED = 13
    ON_INK = 14
    OVER_STROKE = 15
    INK_UNKNOWN = 16
    OBSTACLE = 17
    OFF_PATH = 18


@dataclass(frozen=True)
class Summary:
    """Statistics of a profile.

    Attributes:
        thickness_mean, thickness_std: mean and standard deviation over the MEASURED samples [m];
            NaN without any.
        thickness_q1, thickness_median, thickness_q3: their quartiles [m]; NaN without any.
        coverage: share of the strokes' samples that are MEASURED or GAP; NaN without any.
        gap_count: number of gaps.
        gap_length: their length together [m].
        ooze_count: number of stretches of travel on which ink is seen.
        ooze_length: their length together [m].
        bare_length: length of travel along the bed on which none is seen [m].
        offset_mean: mean offset of the deposit's middle from the path, over the MEASURED samples,
            positive to the left of the direction of travel [m]; NaN without any.
        offset_rms: root mean square of the offset [m]. It shows a shift of the whole print, which
            cancels in the mean where the path turns.
    """

    thickness_mean: float
    thickness_std: float
    thickness_q1: float
    thickness_median: float
    thickness_q3: float
    coverage: float
    gap_count: int
    gap_length: float
    ooze_count: int
    ooze_length: float
    bare_length: float
    offset_mean: float
    offset_rms: float


@dataclass(frozen=True)
class ThicknessProfile:
    """Thickness of N samples along the path of a print, measured in one capture.

    Attributes:
        stamp_ns: stamp of the capture [ns].
        print_id: identifier of the print.
        print_start_ns: zero of ``time`` [ns].
        capture: number of the capture within the print, from 0.
        method: name of the method that measured.
        time: (N,) when the nozzle passed [s after print_start_ns].
        arc_length: (N,) along the path [m].
        points: (N, 3) nozzle tip in the robot base frame [m].
        extruding: (N,) whether ink was being pushed out; False where unknown.
        extruder_known: (N,) whether the extruder's state is known.
        stroke: (N,) number of the stroke, from 1; 0 = travel.
        status: (N,) values of Status, uint8.
        thickness: (N,) [m]; NaN unless MEASURED, or GAP (0).
        sigma: (N,) 1-sigma uncertainty of thickness [m]; NaN unless MEASURED.
        left, right: (N,) distance from the path to each side point [m]; NaN unless MEASURED.
        left_points, right_points: (N, 3) side points in the base frame [m].
        layer: (N,) 0 = on the bed, 1 = on one stroke, ...; -1 on travel.
        height, height_sigma: (N,) of the ink above the surface before, with its 1-sigma
            uncertainty [m]; NaN unless MEASURED where the cloud tells, or GAP (0).
        area, area_sigma: (N,) the same of its cross-section [m^2].
        seen_in: (N,) number of the capture that each was found in; -1 = none.
        commanded_area: (N,) volume of ink that was commanded per length of path [m^2]; NaN = not
            known, 0 on travel.
        cause: (N,) values of Cause, uint8: why a sample is NO_DATA or LOW_CONFIDENCE.
        shift: (3,) how far the ink lies from the path along the bed, in the base frame [m]; NaN =
            nothing looked as if it did, or not told.
        tip_height: median height above the bed at which the nozzle passed where it laid the first
            layer [m]; NaN = not known.
        processing_time: from everything at hand to this result [s].
    """

    stamp_ns: int
    print_id: str
    print_start_ns: int
    capture: int
    method: str
    time: Array
    arc_length: Array
    points: Array
    extruding: Flags
    extruder_known: Flags
    stroke: Index
    status: StatusArray
    thickness: Array
    sigma: Array
    left: Array
    right: Array
    left_points: Array
    right_points: Array
    layer: Index
    height: Array
    height_sigma: Array
    area: Array
    area_sigma: Array
    seen_in: Index
    commanded_area: Array
    cause: CauseArray
    shift: Array
    tip_height: float
    processing_time: float

    @classmethod
    def none(cls, stamp_ns: int) -> ThicknessProfile:
        """Return that from this time on [ns] there is no print: a profile without samples."""
        nothing, points = np.empty(0), np.empty((0, 3))
        return cls(stamp_ns, '', stamp_ns, 0, '', nothing, nothing, points, nothing.astype(bool),
                   nothing.astype(bool), nothing.astype(np.intp), nothing.astype(np.uint8),
                   nothing, nothing, nothing, nothing, points, points, nothing.astype(np.intp),
                   nothing, nothing, nothing, nothing, nothing.astype(np.intp), nothing,
                   nothing.astype(np.uint8), np.full(3, np.nan), np.nan, 0.0)

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def feet(self) -> Array:
        """The path (N, 3) on the surface that ink is laid on [m]; the tip passes above it.

        Between the side points, which lie on the surface; elsewhere as far from the tip as there.
        Where none is known, the path of the tip.
        """
        known = np.flatnonzero(self.status == Status.MEASURED)
        if not len(known):
            return self.points
        left, right = self.left[known, None], self.right[known, None]
        feet = (right * self.left_points[known] + left * self.right_points[known]) / (left + right)
        below = feet - self.points[known]
        return self.points + np.column_stack([
            np.interp(self.arc_length, self.arc_length[known], axis) for axis in below.T])

    @cached_property
    def missing(self) -> Flags:
        """Where (N,) ink is missing: GAP, but for what the lag of start and stop explains."""
        samples = self._stroke_samples
        missing: Flags = (self.status == Status.GAP) & ~(samples.late() | samples.early())
        return missing

    @cached_property
    def gaps(self) -> Array:
        """Arc lengths (G, 2) at which each gap starts and ends [m].

        What is one gap is decided here: an uninterrupted run of missing ink in one stroke. Whoever
        counts or draws gaps asks this; advice looks at those of its window alone.
        """
        return self.runs_of(self.missing)

    @cached_property
    def ooze(self) -> Array:
        """Arc lengths (O, 2) at which ink on travel starts and ends [m].

        What the lag of a stroke's end explains is none.
        """
        return self.runs_of((self.status == Status.OOZE) & ~self._stroke_samples.running_on())

    @cached_property
    def strokes(self) -> Strokes:
        """The strokes in order: where ink was commanded, and where it began and ended."""
        return self._stroke_samples.find()

    def extents(self, status: Status) -> Array:
        """Return the arc lengths (R, 2) at which each run of a status starts and ends [m].

        A sample stands for the path up to half-way to its neighbours in its stroke, or travel.
        """
        return self.runs_of(self.status == status)

    def runs_of(self, mask: Flags) -> Array:
        """Return the arc lengths (R, 2) of runs of samples (N,) in one stroke or travel each."""
        first, end = runs(self.stroke)
        parts = [slice(start, int(end[start])) for start in np.unique(first[mask]).tolist()]
        return np.concatenate([np.empty((0, 2)), *(
            run_extents(mask[part], self.arc_length[part]) for part in parts)])

    @cached_property
    def _stroke_samples(self) -> StrokeSamples:
        status = self.status
        return StrokeSamples(
            self.stroke, self.arc_length, self.time, inked=status == Status.MEASURED,
            bare=status == Status.GAP, ooze=status == Status.OOZE,
            doubtful=((status == Status.LOW_CONFIDENCE)
                      | ((status == Status.NO_DATA) & (self.stroke == 0))),
            captured=(self.stamp_ns - self.print_start_ns) * 1e-9)

    @cached_property
    def summary(self) -> Summary:
        """Statistics over all samples."""
        measured = self.thickness[self.status == Status.MEASURED]
        q1, median, q3 = (np.percentile(measured, (25, 50, 75)) if len(measured)
                          else (np.nan, np.nan, np.nan))
        offset = (self.left - self.right)[self.status == Status.MEASURED] / 2
        known = np.isin(self.status[self.stroke > 0], (Status.MEASURED, Status.GAP))
        return Summary(
            thickness_mean=_mean(measured),
            thickness_std=float(measured.std()) if len(measured) else np.nan,
            thickness_q1=float(q1), thickness_median=float(median), thickness_q3=float(q3),
            coverage=_mean(known),
            gap_count=len(self.gaps), gap_length=_length(self.gaps),
            ooze_count=len(self.ooze), ooze_length=_length(self.ooze),
            bare_length=_length(self.extents(Status.BARE)),
            offset_mean=_mean(offset),
            offset_rms=float(np.sqrt(_mean(offset**2))))

    def off_path(self, maximum_offset: float) -> str:
        """Return why path and picture do not fit; empty = they do.

        Args:
            maximum_offset: how far beside the path the deposit may lie, per its width.
        """
        found = self.summary
        width = found.thickness_mean
        size = float(np.linalg.norm(self.shift))
        # Where no width is told, as that far beside the path, the shift alone counts.
        if size > maximum_offset * np.nan_to_num(width):
            x, y, z = (1e3 * self.shift).tolist()
            return (f'registration: expected the ink within {maximum_offset:.0%} of its width of '
                    f'the path, found it about {1e3 * size:.1f} mm beside: {x:+.1f}, {y:+.1f}, '
                    f'{z:+.1f} mm in the base frame; correct the nozzle offset if the nozzle was '
                    'changed, else the hand-eye calibration by that; "bpc calibrate check" tells '
                    'more')
        if found.offset_rms > maximum_offset * width:
            return (f'offset: expected the deposit within {maximum_offset:.0%} of its width of '
                    f'the path, found it {1e3 * found.offset_rms:.2f} mm off (root mean square; '
                    f'{1e3 * found.offset_mean:+.2f} mm to the left on average); check the '
                    'hand-eye calibration and the nozzle offset')
        # The clearance of a nozzle is less than a bead is wide, and never below the bed.
        width = LEAST_CLEARANCE_M if np.isnan(width) else max(width, LEAST_CLEARANCE_M)
        if self.tip_height > width or self.tip_height < -width / 2:
            where = 'above' if self.tip_height > 0 else 'below'
            return (f'path: expected the nozzle up to {1e3 * width:.1f} mm above the bed where it '
                    f'lays ink, found it {1e3 * abs(self.tip_height):.1f} mm {where}; correct z '
                    'of the nozzle offset if the nozzle was changed, else look at the base frame '
                    'and the hand-eye calibration')
        return ''


def _length(extents: Array) -> float:
    """Return the length of extents (R, 2) together [m]."""
    return float((extents[:, 1] - extents[:, 0]).sum())


def _mean(values: Array | Flags) -> float:
    """Return the mean of values (N,); NaN without any."""
    return float(values.mean()) if len(values) else np.nan


def run_extents(mask: Flags, arc_length: Array) -> Array:
    """Return the arc lengths (R, 2) at which each run of True starts and ends [m].

    A sample stands for the path up to half-way to its neighbours.

    Args:
        mask: (N,) samples.
        arc_length: (N,) of the samples [m], increasing.
    """
    if not mask.any():
        return np.empty((0, 2))
    borders = np.concatenate((arc_length[:1], (arc_length[1:] + arc_length[:-1]) / 2,
                              arc_length[-1:]))
    steps = np.diff(np.concatenate(([False], mask, [False])).astype(np.int8))
    return np.stack((borders[np.flatnonzero(steps == 1)],
                     borders[np.flatnonzero(steps == -1)]), axis=1)
