"""Whether calibration and nozzle offset fit the picture: where the ink lies relative to the path.

Where a camera's pose or the nozzle offset is wrong, all ink of a print lies beside its path by the
same shift. Where the path, moved by that shift, runs, the picture differs most from what is beside
it. Nothing need be known of ink and bed for that.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.view import View
from bpc_perception.core.profile import Cause, Status

USUAL_WIDTH_M = 1.5e-3  # of a bead, where none is measured
REACH_M = 8e-3  # farthest shift that is looked for
CELLS_PER_WIDTH, BLUR_CELLS = 6.0, 3
MOST_CELLS = 400  # along the longer side of the map
INNER, RING = 0.8, (1.5, 2.5)  # of a bead that counts as ink, and what beside it is bed; in widths
LEAST_SEEN = 0.5  # share of the moved path that has to be in the picture
FLOOR_VARIANCE = 4.0  # of colours [grey levels^2]
LEAST_DIFFERENCE = 1.0  # squared, in units of how colours vary; 4 and more where ink is
CLEARLY = 1.2  # times as different from what is beside it, the path lies elsewhere
# Share of the path that lies on ink when it is moved there. Farther than half a bead, also how
# much of what is bare now may still be: half a path, after a clog, fits to ink elsewhere.
LEAST_INKED, STILL_BARE, NEARLY_NONE = 0.7, 0.4, 0.05
FULL = 0.9  # quantile of the colours along a path that are surely ink's
TOP, TOP_CELLS = 0.8, 4  # of a greatest value, and how far around it lies
# A print is looked at if so much of it has no width, or its ink lies so far off in widths.
MOST_UNKNOWN, MOST_ASIDE = 0.2, 0.12
LEAST_LENGTH = 8.0  # of path, in widths; a shorter one is like too much


def looks_off(samples: Samples, strokes: Flags) -> bool:
    """Return whether ink may lie beside the path: much has no edges, or lies to one side.

    Args:
        samples: N samples.
        strokes: (N,) which of them are on strokes, and in view.
    """
    if not strokes.any():
        return False
    told = strokes & (samples.status == Status.MEASURED)
    unknown = np.isin(samples.status, (Status.GAP, Status.LOW_CONFIDENCE))[strokes].mean()
    if not told.any():
        return bool(unknown > MOST_UNKNOWN)
    aside = (samples.sides.left_distance - samples.sides.right_distance)[told] / 2
    return bool(unknown > MOST_UNKNOWN or np.sqrt(np.mean(aside**2)) > MOST_ASIDE * usual_width(
        samples, strokes))


def usual_width(samples: Samples, strokes: Flags) -> float:
    """Return the median width of the beads that are told among strokes (N,) [m]."""
    told = strokes & (samples.status == Status.MEASURED)
    return float(np.median(samples.sides.width[told])) if told.any() else USUAL_WIDTH_M


@dataclass(frozen=True)
class Registration:
    """How path and picture lie to each other.

    Attributes:
        shift: (3,) how far the ink lies from the path along the bed, in the base frame [m]; NaN =
            nothing looked as if it did, or not told.
        tip_height: median height above the bed at which the nozzle passed where it laid the first
            layer [m]; NaN = not known.
    """

    shift: Array
    tip_height: float


def register(view: View, points: Array, layer: Index, samples: Samples,
             bed: Plane) -> Registration:
    """Find how path and picture lie to each other.

    Args:
        view: the capture.
        points: (N, 3) of the path [m].
        layer: (N,) of each, from 0; less = on travel.
        samples: of the points.
        bed: plane of the bed.
    """
    first = layer == 0
    height = float(np.median(bed.height(points[first]))) if first.any() else np.nan
    return Registration(_shift(view, points, layer >= 0, samples, bed), height)


def _shift(view: View, points: Array, strokes: Flags, samples: Samples, bed: Plane) -> Array:
    seen = strokes & view.inside(points) & (samples.status != Status.OCCLUDED)
    width = usual_width(samples, seen)
    length = np.linalg.norm(np.diff(points[seen], axis=0), axis=1).sum()
    if length < LEAST_LENGTH * width or not looks_off(samples, seen):
        return np.full(3, np.nan)
    return find_shift(view, points[seen], bed, width)


def without_misplaced(samples: Samples, strokes: Flags, shift: Array) -> Samples:
    """Return samples of which strokes (N,) are not told if ink lies beside them by a shift (3,).

    From half a width on the nearest edges may be those of other ink.
    """
    told = strokes & np.isin(samples.status, (Status.MEASURED, Status.GAP, Status.LOW_CONFIDENCE))
    if not np.linalg.norm(shift) > usual_width(samples, strokes) / 2:
        return samples
    return replace(samples, verdicts=samples.verdicts.where(
        told, Status.LOW_CONFIDENCE, Cause.OFF_PATH))


def find_shift(view: View, points: Array, bed: Plane, width: float) -> Array:
    """Return how far the ink lies from the path along the bed (3,), in the base frame [m].

    NaN where too little of the path is in the picture.

    Args:
        view: the capture.
        points: (N, 3) of the strokes in view [m].
        bed: plane of the bed.
        width: usual width of a bead [m].
    """
    chart = _Chart.around(bed.project(points), bed, width)
    colours, known = chart.colours(view)
    if not known.any():
        return np.full(3, np.nan)
    spread = np.cov(colours[known > 0].T) + FLOOR_VARIANCE * np.eye(3)
    step = _steps(chart, colours, known, width)
    difference = np.einsum('hwi,ij,hwj->hw', step, np.linalg.inv(spread), step)
    if not np.isfinite(difference).any():
        return np.full(3, np.nan)
    best, here = np.nanmax(difference), np.nan_to_num(difference[chart.reach, chart.reach])
    if best < LEAST_DIFFERENCE or best < CLEARLY * here:
        return np.zeros(3)
    cells = _peak(difference) - chart.reach
    row, column = np.rint(cells[::-1] + chart.reach).astype(int).tolist()
    towards = np.linalg.solve(spread, step[row, column])
    brightness = np.asarray(cv2.blur(colours @ towards.astype(np.float32),
                                     (BLUR_CELLS, BLUR_CELLS)), np.float32)
    there, now = (_inked(chart, brightness, known, moved) for moved in (cells, np.zeros(2)))
    apart = np.linalg.norm(cells) * chart.cell > width / 2
    if there < LEAST_INKED or (apart and 1 - there > max(STILL_BARE * (1 - now), NEARLY_NONE)):
        return np.zeros(3)
    return np.asarray(cells * chart.cell @ chart.axes)


def _inked(chart: _Chart, brightness: Floats, known: Floats, moved: Array) -> float:
    """Return what share of a path lies on ink when it is moved by columns and rows (2,).

    Args:
        chart: with the path.
        brightness: (H, W) of the chart, along the colours in which ink differs from bed.
        known: (H, W) where it shows.
        moved: [cells].
    """
    column, row = np.rint(chart.path + moved).astype(int).T
    values = brightness[row, column][known[row, column] > 0]
    bare, inked = np.median(brightness[known > 0]), np.quantile(values, FULL)
    return float(np.mean(values > (bare + inked) / 2))


def _peak(values: Array) -> Array:
    """Return column and row of the greatest value, between cells: the middle of its top."""
    row, column = np.unravel_index(np.nanargmax(values), values.shape)
    rows, columns = np.ogrid[:values.shape[0], :values.shape[1]]
    near = np.maximum(np.abs(rows - row), np.abs(columns - column)) <= TOP_CELLS
    weight = np.maximum(np.nan_to_num(values) / values[row, column] - TOP, 0.0) * near
    return np.array(((weight * columns).sum(), (weight * rows).sum())) / weight.sum()


@dataclass(frozen=True)
class _Chart:
    """A map of the bed around a path.

    Attributes:
        corner: (3,) the place of its first cell [m].
        axes: (2, 3) unit vectors along its columns and rows.
        cell: size of a cell [m].
        size: its columns and rows.
        reach: farthest shift [cells], by which it is wider than the path on all sides.
        path: (N, 2) column and row of the path points.
    """

    corner: Array
    axes: Array
    cell: float
    size: tuple[int, int]
    reach: int
    path: Array

    @classmethod
    def around(cls, feet: Array, bed: Plane, width: float) -> _Chart:
        """Return the chart around the feet (N, 3) of a path with beads of a width [m]."""
        origin = feet[0]
        axes = np.linalg.svd(np.eye(3) - np.outer(bed.normal, bed.normal))[0][:, :2].T
        places = (feet - origin) @ axes.T
        margin = REACH_M + RING[1] * width
        low, high = places.min(axis=0) - margin, places.max(axis=0) + margin
        cell = max(width / CELLS_PER_WIDTH, float((high - low).max()) / MOST_CELLS)
        columns, rows = np.ceil((high - low) / cell).astype(int).tolist()
        return cls(origin + low @ axes, axes, cell, (columns, rows), int(REACH_M / cell),
                   (places - low) / cell)

    def colours(self, view: View) -> tuple[Floats, Floats]:
        """Return the picture (H, W, 3) on the chart, and where (H, W) it shows: 1, else 0."""
        columns, rows = self.size
        place = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1) * self.cell
        u, v = np.moveaxis(view.pixels((self.corner + place @ self.axes).reshape(-1, 3)).reshape(
            rows, columns, 2), -1, 0).astype(np.float32)
        # Means over a cell: a noisy picture tells more so.
        side = max(1, round(self.cell / view.pixel_size(self.corner[None])))
        image = cv2.blur(view.capture.image, (side, side))
        known = np.asarray(cv2.remap(np.ones(image.shape[:2], np.float32), u, v,
                                     cv2.INTER_NEAREST), np.float32)
        return np.asarray(cv2.remap(image, u, v, cv2.INTER_LINEAR)).astype(np.float32), known

    def away(self) -> Floats:
        """Return how far (H, W) each cell is from the path [m]."""
        free = np.ones(self.size[::-1], np.uint8)
        column, row = np.rint(self.path).astype(int).T
        free[row, column] = 0
        return np.asarray(cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_5)) * np.float32(
            self.cell)


def _steps(chart: _Chart, colours: Floats, known: Floats, width: float) -> Array:
    """Return by how much the moved path differs from what is beside it (2R + 1, 2R + 1, 3).

    Rows and columns are shifts from -R to R cells. NaN where too little is in the picture.

    Args:
        chart: with the path.
        colours: (H, W, 3) on it.
        known: (H, W) where it shows.
        width: of a bead [m].
    """
    away = chart.away()
    inner = (away <= INNER * width / 2).astype(np.float32)
    ring = ((away > RING[0] * width / 2) & (away <= RING[1] * width / 2)).astype(np.float32)
    (ink, seen), (bed, _) = (_means(colours, known, mask, chart.reach) for mask in (inner, ring))
    return np.where((seen > LEAST_SEEN)[..., None], ink - bed, np.nan)


def _means(colours: Floats, known: Floats, mask: Floats, reach: int) -> tuple[Array, Array]:
    """Return the mean colours (2R + 1, 2R + 1, 3) under a mask (H, W) that is moved.

    And what share of it is seen there.
    """
    template = mask[reach:-reach, reach:-reach]
    seen = cv2.matchTemplate(known, template, cv2.TM_CCORR)
    sums = [cv2.matchTemplate(colours[..., channel] * known, template, cv2.TM_CCORR)
            for channel in range(3)]
    with np.errstate(invalid='ignore', divide='ignore'):
        return (np.stack(sums, axis=-1) / seen[..., None]).astype(np.float64), np.asarray(
            seen / template.sum(), np.float64)
