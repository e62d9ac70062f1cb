"""A growing print, measured where something is new.

What was measured in a capture is kept as long as the path and its picture stay as they were
there, so that a capture costs what it adds, however much has been printed. Measured are

- path points that are new, and those within a window before them, whose surroundings were not all
  known;
- path points near to which the picture changed by more than its noise, or path was added: the
  nozzle moved, ink was laid beside or has run.

What lies around these is measured as well, since they are seen in its context, but not kept. All
is measured anew if the camera has moved, if that is most of it anyway, and whenever the print
has grown to twice its length, so that what ink and bed look like is told from all of it.

The result depends on the captures measured before, and on nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import invert, Plane, transform
from bpc_perception.core.measurement.cross_section.edges import GLARE
from bpc_perception.core.measurement.cross_section.method import (
    CrossSections,
    measure_cross_sections,
)
from bpc_perception.core.measurement.scale import pixel_size, WINDOW
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.tangents import typical_spacing
from bpc_perception.core.profile import StatusArray

Kind = TypeVar('Kind', np.float64, np.uint8)

TILE = 8  # side of the squares in which two pictures are compared [pixels]
NOISE = 6.0  # a tile has changed if it differs by more than so many sigma of all tiles,
LEAST = 2.0  # and by so much [grey levels]
JURY = 1000  # tiles that tell it
MOVED = 0.1  # a camera that shifts the picture by more has moved [pixels]
SHARE = 0.5  # if more of the path is to be measured, all is


@dataclass(frozen=True)
class Tiles:
    """A picture in squares of TILE pixels; NaN where not looked at or nothing is known.

    Attributes:
        colour: (H, W, 3) their mean RGB.
        depth: (H, W) least of some depths in each [m].
    """

    colour: Floats
    depth: Floats


@dataclass(frozen=True)
class _Remembered:
    """A print as measured: its path, results for each of N points, and the picture they are from.

    ``tiles`` hold what was seen of each place when it was last measured, so that slow changes
    add up until they are noticed. ``whole`` are the points that the print had when all of
    it was last measured, by a camera with the pose ``T_base_camera``.
    """

    print_id: str
    config: ThicknessConfig
    intrinsics: bytes
    T_base_camera: Array
    time: Array
    points: Array
    results: CrossSections
    tiles: Tiles
    whole: int


class PrintMemory:
    """What is remembered of the print's captures before: one reduced picture, and results."""

    def __init__(self) -> None:
        self.last: _Remembered | None = None


def measure_incrementally(
    capture: Capture, path: DepositionPath, T_base_camera: Array, bed: Plane,
    config: ThicknessConfig, memory: PrintMemory,
) -> tuple[SidePoints, StatusArray, Array]:
    """Side points, status (N,) and sigma (N,) of a path of N points; see ``measure``.

    The memory is used, and replaced by what is known now.
    """
    last = memory.last
    pixel = pixel_size(capture, path.points, T_base_camera)
    feet = bed.project(path.points)
    uv = capture.camera.pixels(transform(invert(T_base_camera), feet))
    tile, seen = _tile_of(uv, capture)
    tiles = picture(capture, uv[seen], config.cross_section.reach / pixel)
    intrinsics = capture.camera.K.tobytes() + capture.camera.distortion.tobytes()
    memory.last = None  # should measuring fail
    if last is not None and not (
            last.print_id == path.print_id and last.config == config
            and last.intrinsics == intrinsics and last.tiles.depth.shape == tiles.depth.shape
            and last.results.contrast is not None and len(path) <= 2 * last.whole
            and _camera_stood(capture, feet, last.T_base_camera, uv)):
        last = None
    if last is not None:
        old, same = _same_points(last, path)
        window = 2 * round(WINDOW / 2 / typical_spacing(path.points)) + 1
        half = _half_width(last.results.sides, config.cross_section.reach) / pixel
        changed = changes(last.tiles, tiles, config.obstacle_height / 2)

        def around(flags: Flags, distance: float, places: Flags | None = None) -> Flags:
            """Path points so near [pixels] in the picture to those flagged, or to places."""
            mask = np.zeros(changed.shape, np.uint8) if places is None else places.astype(np.uint8)
            mask[tuple(tile[flags & seen].T)] = 1
            side = 2 * int(np.ceil(distance / TILE)) + 1
            grown = cv2.dilate(mask, np.ones((side, side), np.uint8))
            return np.asarray((grown[tuple(tile.T)] > 0) & seen)

        late = maximum_filter1d(~same, window)
        anew = late | around(late, half + GLARE, changed)
        asked = maximum_filter1d(anew, 2 * window - 1) | around(anew, 2 * half)
        if asked.mean() > SHARE:
            last = None
    if last is None:
        results = measure_cross_sections(capture, path.points, path.extruding, T_base_camera,
                                         bed, config)
        whole, T_reference = len(path), T_base_camera
    else:
        results = _reused(last.results, old)
        if asked.any():
            part = measure_cross_sections(
                capture, path.points, path.extruding, T_base_camera, bed, config,
                np.flatnonzero(asked), last.results.contrast)
            results = _merged(results, np.flatnonzero(anew), part, anew[asked])
        tiles = _updated(last.tiles, tiles, changed)
        whole, T_reference = last.whole, last.T_base_camera
    memory.last = _Remembered(path.print_id, config, intrinsics, T_reference, path.time,
                              path.points, results, tiles, whole)
    sides = SidePoints(*(getattr(results.sides, field.name).copy()
                         for field in fields(SidePoints)))
    return sides, results.status.copy(), results.sigma.copy()


def picture(capture: Capture, uv: Array, reach: float) -> Tiles:
    """A capture as tiles, as far as they are within reach of pixels uv (N, 2)."""
    rows, columns = capture.camera.height // TILE, capture.camera.width // TILE
    tiles = Tiles(np.full((rows, columns, 3), np.nan, np.float32),
                  np.full((rows, columns), np.nan, np.float32))
    if not len(uv) or not rows or not columns:
        return tiles
    low = np.maximum((uv.min(axis=0) - reach) // TILE, 0).astype(int)
    high = np.minimum((uv.max(axis=0) + reach) // TILE + 1, (columns, rows)).astype(int)
    part = slice(low[1], high[1]), slice(low[0], high[0])
    pixels = slice(low[1] * TILE, high[1] * TILE), slice(low[0] * TILE, high[0] * TILE)
    width, height = high - low
    # In two steps, since OpenCV is much quicker in halving.
    half = cv2.resize(capture.image[pixels], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    tiles.colour[part] = cv2.resize(half, (int(width), int(height)),
                                    interpolation=cv2.INTER_AREA)
    some = capture.cloud[pixels][TILE // 4::TILE // 2, TILE // 4::TILE // 2, 2]
    upper, lower = (np.fmin(some[row::2, ::2], some[row::2, 1::2]) for row in (0, 1))
    tiles.depth[part] = np.fmin(upper, lower)
    return tiles


def changes(before: Tiles, now: Tiles, least_depth: float) -> Flags:
    """Which tiles (H, W) differ by more than noise, or in depth by more than this [m].

    Those seen for the first time count as well, those not looked at do not.
    """
    looked = np.isfinite(now.colour[..., 0])
    step = now.colour[looked] - before.colour[looked]
    known = np.isfinite(step[:, 0])
    if known.any():
        some = step[known][::1 + np.count_nonzero(known) // JURY]
        flicker = np.median(some, axis=0)  # of a lamp is no change
        noise = 1.4826 * float(np.median(np.abs(some - flicker)))
        for channel in range(3):
            known &= np.abs(step[:, channel] - flicker[channel]) <= max(LEAST, NOISE * noise)
    depth, old = now.depth[looked], before.depth[looked]
    known &= (np.abs(depth - old) <= least_depth) | (np.isnan(depth) & np.isnan(old))
    changed = np.zeros(looked.shape, bool)
    changed[looked] = ~known
    return changed


def _updated(before: Tiles, now: Tiles, changed: Flags) -> Tiles:
    return Tiles(np.where(changed[..., None], now.colour, before.colour),
                 np.where(changed, now.depth, before.depth))


def _tile_of(uv: Array, capture: Capture) -> tuple[Index, Flags]:
    """Tile (N, 2) as (row, column) of pixels (N, 2), and whether they are in the image (N,)."""
    seen = capture.camera.contains(uv)
    last = np.array((capture.camera.width, capture.camera.height)) // TILE - 1
    tile = np.minimum((np.where(seen[:, None], uv, 0.0) / TILE).astype(np.intp), last)
    return tile[:, ::-1], seen


def _camera_stood(capture: Capture, points: Array, T_base_camera: Array, uv: Array) -> bool:
    """Whether from an earlier pose points (N, 3) are seen at about the same pixels (N, 2)."""
    before = capture.camera.pixels(transform(invert(T_base_camera), points))
    shift = np.abs(before - uv)
    return bool(np.nanmax(shift, initial=0.0) <= MOVED)


def _same_points(last: _Remembered, path: DepositionPath) -> tuple[Index, Flags]:
    """Which of the points remembered each point (N,) of the path is, and whether it is one."""
    old = np.minimum(np.searchsorted(last.time, path.time), len(last.time) - 1)
    same: Flags = last.time[old] == path.time
    for axis in range(3):
        same &= last.points[old, axis] == path.points[:, axis]
    return old, same


def _half_width(sides: SidePoints, reach: float) -> float:
    """How far from the path edges are [m]."""
    distances = np.concatenate((sides.left_distance, sides.right_distance))
    return min(float(np.nanmax(distances)), reach) if np.isfinite(distances).any() else reach


def _reused(results: CrossSections, index: Index) -> CrossSections:
    """The results of points of an index (N,)."""
    sides = SidePoints(*(getattr(results.sides, field.name)[index]
                         for field in fields(SidePoints)))
    return replace(results, sides=sides, status=results.status[index],
                   sigma=results.sigma[index])


def _merged(results: CrossSections, index: Index, part: CrossSections,
            chosen: Flags) -> CrossSections:
    """Results with those of an index (K,) replaced by the chosen ones of a part."""

    def put(values: NDArray[Kind], new: NDArray[Kind]) -> NDArray[Kind]:
        values = values.copy()
        values[index] = new[chosen]
        return values

    sides = SidePoints(*(put(getattr(results.sides, field.name), getattr(part.sides, field.name))
                         for field in fields(SidePoints)))
    return replace(results, sides=sides, status=put(results.status, part.status),
                   sigma=put(results.sigma, part.sigma))
