"""A growing print, measured where something is new.

What was measured in a capture is kept as long as the path and its picture stay as they were there.
So a capture costs what it adds, however much has been printed. Measured are

- path points that are new, and those within a window before them, whose surroundings were not all
  known;
- path points near to which the picture changed by more than its noise, or path was added: the
  nozzle moved, ink was laid beside or has run.

What lies around these is measured as well, since they are seen in its context, but not kept. All
is measured anew if the camera has moved, if that is most of it anyway, and whenever the print
has grown to twice its length, so that all of it tells what ink and bed look like.

The result depends on the captures measured before, and on nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.ndimage import maximum_filter1d

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.filters import thinned
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.edges.edges import GLARE_PX
from bpc_perception.core.measurement.cross_section.method import (
    CrossSections,
    look_for_ink,
    measure_cross_sections,
)
from bpc_perception.core.measurement.cross_section.reach import (
    farther_ones,
    follows_path,
    LEAST_GAIN,
    LEAST_LOST,
    lost,
    Reach,
    told,
)
from bpc_perception.core.measurement.cross_section.tiles import (
    changes,
    picture,
    TILE_PX,
    Tiles,
    tiles_of,
)
from bpc_perception.core.measurement.kept import Kept
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.scale import steady_window
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.layers import LayerFinder
from bpc_perception.core.path.tangents import typical_spacing
from bpc_perception.core.profile import Cause, Status

MOVED_PX = 0.1  # a camera that shifts the picture by more has moved
MOST_ANEW = 0.5  # share of the path; if more of it is to be measured, all is
LONGEST_GROWTH = 2  # times the length at which all was measured last


@dataclass(frozen=True)
class _Sight:
    """How a capture shows a path of N points.

    Attributes:
        view: the capture.
        feet: (N, 3) points of the bed below the path, in the base frame [m].
        uv: (N, 2) their pixels.
        seen: (N,) whether they are in the image.
        tile: (N, 2) row and column of the tile in which each is.
        tiles: the picture around the path.
        pixel: length of a pixel's side on the surface [m].
    """

    view: View
    feet: Array
    uv: Array
    seen: Flags
    tile: Index
    tiles: Tiles
    pixel: float

    @property
    def intrinsics(self) -> bytes:
        """The camera's intrinsics, to be compared."""
        camera = self.view.capture.camera
        return camera.K.tobytes() + camera.distortion.tobytes()

    def near(self, flags: Flags, distance: float, changed: Flags | None = None) -> Flags:
        """Return which points (N,) are near, in the picture, to flagged ones or to changed tiles.

        Args:
            flags: (N,) points that count.
            distance: how near [pixels].
            changed: (H, W) tiles that count as well.
        """
        mask = (np.zeros(self.tiles.depth.shape, np.uint8) if changed is None
                else changed.astype(np.uint8))
        mask[tuple(self.tile[flags & self.seen].T)] = 1
        side = 2 * int(np.ceil(distance / TILE_PX)) + 1
        grown = cv2.dilate(mask, np.ones((side, side), np.uint8))
        return np.asarray((grown[tuple(self.tile.T)] > 0) & self.seen)


@dataclass(frozen=True)
class _Remembered:
    """A print as it was measured.

    Attributes:
        track: the N points.
        config: with which it was measured.
        intrinsics: of the camera.
        T_base_camera: (4, 4) pose of the camera when all was measured last.
        results: of the N path points.
        tiles: what was seen of each place when it was last measured, so that slow changes add up
            until they are noticed.
        length: how many points the print had when all of it was measured last.
    """

    track: Track
    config: ThicknessConfig
    intrinsics: bytes
    T_base_camera: Array
    results: CrossSections
    tiles: Tiles
    length: int

    def fits(self, track: Track, config: ThicknessConfig, sight: _Sight) -> bool:
        """Return whether results can be kept: same print, settings and camera, not much longer."""
        return (self.track.print_id == track.print_id and self.config == config
                and self.intrinsics == sight.intrinsics
                and self.tiles.depth.shape == sight.tiles.depth.shape
                and self.results.known is not None
                and len(track) <= LONGEST_GROWTH * self.length
                and _camera_stood(sight, self.T_base_camera))

    def same_points(self, track: Track) -> tuple[Index, Flags]:
        """Return which remembered point each point (N,) of a path is, and whether it is one."""
        before = self.track
        old = np.minimum(np.searchsorted(before.time, track.time), len(before) - 1)
        same: Flags = (before.time[old] == track.time) & (before.along[old] == track.along)
        for axis in range(3):
            same &= before.points[old, axis] == track.points[:, axis]
        return old, same


@dataclass(frozen=True)
class _Plan:
    """What of a path of N points is measured, where the rest keeps its results.

    Attributes:
        old: (N,) which remembered point each is.
        anew: (N,) whether it gets a new result.
        asked: (N,) whether it is measured, if only as the surroundings of another.
        changed: (H, W) tiles that changed.
    """

    old: Index
    anew: Flags
    asked: Flags
    changed: Flags


class PrintMemory:
    """What is remembered of the print's captures before.

    Attributes:
        last: one reduced picture, and results; None = nothing.
        layers: which ink of the print lies on which.
        kept: what was found of each sample; None = nothing.
        reach: how far from the path edges are looked for.
    """

    def __init__(self) -> None:
        self.last: _Remembered | None = None
        self.layers = LayerFinder()
        self.kept: Kept | None = None
        self.reach = Reach()


def measure_across_path(view: View, track: Track, bed: Plane, config: ThicknessConfig,
                        memory: PrintMemory) -> Samples:
    """Measure a track by cross-sections, as far from the path as its beads are wide.

    The memory is used, and replaced by what is known now.
    """
    samples = measure_once_a_pixel(view, track, bed, memory.reach.applied(config), memory)
    if memory.reach.may_be_too_near(samples):
        samples = measure_farther(view, track, bed, config, memory, samples)
    return samples


def measure_farther(view: View, track: Track, bed: Plane, config: ThicknessConfig,
                    memory: PrintMemory, samples: Samples) -> Samples:
    """Measure a track with farther reaches; return the samples of the one that tells most.

    Its results and its reach are remembered.

    Args:
        view: the capture.
        track: P points of a path.
        bed: plane of the bed.
        config: how to measure.
        memory: of the captures before.
        samples: as they are with the reach so far.
    """
    memory.reach = replace(memory.reach, tried_at=len(track))
    for length in farther_ones(view, track.points, memory.reach.applied(config)):
        reach, trial = Reach(length, len(track)), PrintMemory()
        found = measure_once_a_pixel(view, track, bed, reach.applied(config), trial)
        gain = told(found).mean() - told(samples).mean()
        if gain > LEAST_GAIN and follows_path(found, samples, track):
            samples, memory.reach, memory.last = found, reach, trial.last
            if lost(found).mean() <= LEAST_LOST:
                break
    return samples


def measure_once_a_pixel(view: View, track: Track, bed: Plane, config: ThicknessConfig,
                         memory: PrintMemory) -> Samples:
    """Measure a track by cross-sections, which are no closer together than pixels."""
    pixels_apart = view.pixel_size(track.points) / typical_spacing(track.points)
    step = min(int(pixels_apart), len(track) // 3)
    if step <= 1:
        return measure_incrementally(view, track, bed, config, memory)
    chosen = thinned(track.piece, step)
    samples = measure_incrementally(view, track.of(chosen), bed, config, memory)
    return samples.at(np.interp(np.arange(len(track)), chosen, np.arange(len(chosen))))


def look_across_travel(view: View, track: Track, index: Index, bed: Plane,
                       config: ThicknessConfig, memory: PrintMemory) -> Verdicts:
    """Return what is seen at travel points of a track (K,), once ink is known by its strokes."""
    if memory.last is None or memory.last.results.known is None:
        return Verdicts.all_of(len(index), Status.NO_DATA, Cause.INK_UNKNOWN)
    return look_for_ink(view, track, bed, memory.reach.applied(config), index,
                        memory.last.results.known.contrast)


def measure_incrementally(view: View, track: Track, bed: Plane, config: ThicknessConfig,
                          memory: PrintMemory) -> Samples:
    """Measure a path where something is new, and keep the results elsewhere."""
    sight = _look_at(view, track, bed, config)
    last, memory.last = memory.last, None  # should measuring fail
    plan = (_plan(last, track, sight, config)
            if last is not None and last.fits(track, config, sight) else None)
    if last is None or plan is None:
        memory.last = _measure_all(sight, track, bed, config)
    else:
        memory.last = _measure_new(last, plan, sight, track, bed, config)
    return memory.last.results.samples


def _look_at(view: View, track: Track, bed: Plane, config: ThicknessConfig) -> _Sight:
    pixel = view.pixel_size(track.points)
    feet = bed.project(track.points)
    uv = view.pixels(feet)
    seen = view.capture.camera.contains(uv)
    return _Sight(view, feet, uv, seen, tiles_of(uv, seen, view.capture.camera),
                  picture(view.capture, uv[seen], config.cross_section.reach / pixel), pixel)


def _plan(last: _Remembered, track: Track, sight: _Sight,
          config: ThicknessConfig) -> _Plan | None:
    """Plan what is to be measured; None = so much that all is measured."""
    old, same = last.same_points(track)
    window = steady_window(typical_spacing(track.points))
    half = _half_width(last.results.samples.sides, config.cross_section.reach) / sight.pixel
    changed = changes(last.tiles, sight.tiles, config.obstacle_height / 2)
    late = maximum_filter1d(~same, window)
    anew = late | sight.near(late, half + GLARE_PX, changed)
    asked = maximum_filter1d(anew, 2 * window - 1) | sight.near(anew, 2 * half)
    return _Plan(old, anew, asked, changed) if asked.mean() <= MOST_ANEW else None


def _measure_all(sight: _Sight, track: Track, bed: Plane,
                 config: ThicknessConfig) -> _Remembered:
    results = measure_cross_sections(sight.view, track, bed, config)
    return _Remembered(track, config, sight.intrinsics, sight.view.T_base_camera, results,
                       sight.tiles, len(track))


def _measure_new(last: _Remembered, plan: _Plan, sight: _Sight, track: Track, bed: Plane,
                 config: ThicknessConfig) -> _Remembered:
    samples = last.results.samples.of(plan.old)
    if plan.asked.any():
        part = measure_cross_sections(sight.view, track, bed, config,
                                      np.flatnonzero(plan.asked), last.results.known)
        chosen = np.flatnonzero(plan.anew[plan.asked])
        samples = samples.with_part(np.flatnonzero(plan.anew), part.samples.of(chosen))
    return replace(last, track=track,
                   results=replace(last.results, samples=samples),
                   tiles=last.tiles.where_else(plan.changed, sight.tiles))


def _camera_stood(sight: _Sight, T_base_camera: Array) -> bool:
    """Return whether the path is seen at about the same pixels from an earlier pose (4, 4)."""
    before = View(sight.view.capture, T_base_camera).pixels(sight.feet)
    shift = np.abs(before - sight.uv)
    return bool(np.nanmax(shift, initial=0.0) <= MOVED_PX)


def _half_width(sides: SidePoints, reach: float) -> float:
    """Return how far from the path edges are, at most the reach [m]."""
    distances = np.concatenate((sides.left_distance, sides.right_distance))
    return min(float(np.nanmax(distances)), reach) if np.isfinite(distances).any() else reach
