"""Where the rays of a camera meet bed, ink and nozzle.

Rays meet the bed and the bead's parabolic cross-section in closed form: in the frame of the
path's tangent and normal a ray is a straight line, and the bead below it a parabola. On a curved
bed a ray is straight enough over the height of a bead. Of several beads the first on a ray counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert
from bpc_sim.ink.deposit import Deposit
from bpc_sim.scene.camera import View
from bpc_sim.scene.scene import Scene
from bpc_sim.scene.surfaces import Surface, SurfaceHits


@dataclass(frozen=True, eq=False)
class InkHits:
    """Where rays meet the ink; arrays (N, M), with M rays to a pixel.

    Attributes:
        hit: whether the ray meets ink at all.
        height: height above the bed there [m]; 0 without ink.
        slope: slope of the bead across the path; 0 on its ridge.
        heading: angle of the path's tangent [rad].
        margin: about the distance from the rim [m], negative inside; of several beads it is the
            rim that is met, or else the nearest.
    """

    hit: NDArray[np.bool_]
    height: Array
    slope: Array
    heading: Array
    margin: Array


@dataclass(frozen=True, eq=False)
class RayHits:
    """What N groups of M rays meet.

    Attributes:
        directions: (N, M, 3) rays in the optical frame, of depth z = 1.
        in_surface: (N, M, 3) the same rays in the surface frame.
        bed: where they would meet the bare bed.
        rim: (N, M) about the distance at which they pass the nearest rim of a bead [m].
        ink: where they meet the ink, in the path's frame at the hit itself.
        nozzle_depth: (N, M) depth at which they meet the nozzle [m]; NaN where they miss it.
    """

    directions: Array
    in_surface: Array
    bed: SurfaceHits
    rim: Array
    ink: InkHits
    nozzle_depth: Array


class RayTracer:
    """The rays of one camera into one scene.

    Attributes:
        scene: ink, bed and nozzle.
        view: camera and pose.
        T_surface_camera: (4, 4) pose of the optical frame in the surface frame.
        eye: (3,) the camera's centre in the surface frame [m].
    """

    def __init__(self, scene: Scene, view: View) -> None:
        self.scene = scene
        self.view = view
        self.T_surface_camera = invert(scene.T_base_surface) @ view.T_base_camera
        self.eye: Array = self.T_surface_camera[:3, 3]

    def trace(self, directions: Array) -> RayHits:
        """Find what rays meet: directions (N, M, 3) in the optical frame, of depth z = 1."""
        in_surface = self._to_surface(directions)
        bed = self.scene.surface.intersect(self.eye, in_surface, np.zeros(directions.shape[:2]))
        footprints = [self._intersect_ink(deposit, in_surface, deposit.level)
                      for deposit in self.scene.deposits]
        refined = [self._refine(deposit, in_surface, footprint)
                   for deposit, footprint in zip(self.scene.deposits, footprints, strict=True)]
        rim = np.abs([footprint.margin for footprint in footprints]).min(axis=0)
        return RayHits(directions, in_surface, bed, rim, first_on_ray(refined),
                       self.nozzle_depth(directions))

    def meets_ink(self, directions: Array) -> NDArray[np.bool_]:
        """Tell whether rays (N, M, 3) of the optical frame meet the bead (N, M)."""
        in_surface = self._to_surface(directions)
        return first_on_ray([self._intersect_ink(deposit, in_surface, deposit.level)
                             for deposit in self.scene.deposits]).hit

    def nozzle_depth(self, directions: Array) -> Array:
        """Return the depth (N, M) [m] at which rays (N, M, 3) meet the nozzle; NaN if not.

        The rays are in the optical frame, of depth z = 1.
        """
        if self.scene.T_base_tip is None:
            return np.full(directions.shape[:2], np.nan)
        return self.scene.nozzle.depth(
            directions, invert(self.scene.T_base_tip) @ self.view.T_base_camera)

    def _to_surface(self, directions: Array) -> Array:
        in_surface: Array = directions @ self.T_surface_camera[:3, :3].T
        return in_surface

    def _intersect_ink(self, deposit: Deposit, in_surface: Array,
                       at_height: Array | float) -> InkHits:
        return intersect_ink(deposit, self.scene.surface, self.eye, in_surface,
                             np.broadcast_to(at_height, in_surface.shape[:2]))

    def _refine(self, deposit: Deposit, in_surface: Array, hits: InkHits) -> InkHits:
        """Find the hits of rays (N, M, 3) again, each in the path's frame at the hit itself."""
        chosen = np.flatnonzero(hits.hit.any(axis=1))
        if not len(chosen):
            return hits
        better = self._intersect_ink(deposit, in_surface[chosen], hits.height[chosen])
        # Outside a sharp corner no part of the path has a foot.
        found = np.isfinite(better.heading)
        refined = {}
        for name in ('height', 'slope', 'heading', 'margin'):
            refined[name] = getattr(hits, name).copy()
            refined[name][chosen] = np.where(found, getattr(better, name), refined[name][chosen])
        return InkHits(hits.hit, **refined)


def intersect_ink(deposit: Deposit, surface: Surface, eye: Array, directions: Array,
                  at_height: Array) -> InkHits:
    """Intersect rays with the bead, in the path's frame below their points ``at_height``.

    The nearer that height is to the hit, the less the curvature of path and bed matters.

    Args:
        deposit: the ink.
        surface: the bed.
        eye: (3,) where the rays start, in the surface frame [m].
        directions: (N, M, 3) rays in the surface frame.
        at_height: (N, M) height above the bed [m].
    """
    there = surface.intersect(eye, directions, at_height)
    location = deposit.locate(there.places)
    cos, sin = np.cos(location.heading), np.sin(location.heading)
    along = cos * there.lean[..., 0] + sin * there.lean[..., 1]
    across = cos * there.lean[..., 1] - sin * there.lean[..., 0]
    base = deposit.base(location.s)
    s = location.s - along * (at_height - base)  # at the height of the foot
    offset = location.offset - across * (at_height - base)

    width = deposit.profile(location.s)
    steep = 4 * deposit.height_ratio / width
    above = _parabola_height(deposit.height_ratio * width, steep, offset, across)
    on_bead = above > 0
    on_top = on_bead & deposit.inked(s + along * above)
    # A ray that passes the flat end above, but ends on ink, meets the wall at that end.
    on_wall = on_bead & ~on_top & deposit.inked(s)
    above = np.where(on_wall, _wall_height(deposit, s, along, above), above)
    hit = on_top | on_wall
    height = np.where(hit, base + above, 0.0)
    slope = np.where(hit, -2 * steep * (offset + across * above), 0.0)
    margin = np.where(np.isfinite(location.margin), location.margin, np.inf)
    return InkHits(hit, height, slope, location.heading, margin)


def first_on_ray(beads: Sequence[InkHits]) -> InkHits:
    """Return what rays meet first of several beads; all of them go down."""
    if len(beads) == 1:
        return beads[0]
    hit, height, margin = (np.stack([getattr(bead, name) for bead in beads])
                           for name in ('hit', 'height', 'margin'))
    first = np.where(hit.any(axis=0), np.argmax(np.where(hit, height, -np.inf), axis=0),
                     np.argmin(np.abs(margin), axis=0))
    return InkHits(*(np.take_along_axis(np.stack([getattr(bead, name) for bead in beads]),
                                        first[None], axis=0)[0]
                     for name in ('hit', 'height', 'slope', 'heading', 'margin')))


def _parabola_height(top: Array, steep: Array, offset: Array, across: Array) -> Array:
    """Return the height (N, M) [m] above the foot at which rays meet the bead.

    It is that of h = top - steep (offset + across h)^2.

    Of two solutions it is the first from above. Not positive, or NaN, where a ray misses.
    """
    a, b, c = steep * across**2, 1 + 2 * steep * offset * across, top - steep * offset**2
    root = np.sqrt(np.maximum(b**2 + 4 * a * c, 0))
    with np.errstate(divide='ignore', invalid='ignore'):
        # For b < 0 the ray comes over the ridge.
        height = np.where(b > 0, 2 * c / (b + root), (root - b) / (2 * a))
    return np.where(b**2 + 4 * a * c >= 0, height, 0.0)


def _wall_height(deposit: Deposit, s: Array, along: Array, highest: Array) -> Array:
    """Return the height (N, M) [m] above the foot at which rays leave a run over its end."""
    if not len(deposit.runs):
        return np.zeros(s.shape)
    starts, ends = deposit.runs.T
    run = np.clip(np.searchsorted(starts, s, side='right') - 1, 0, len(starts) - 1)
    border = np.where(along > 0, ends[run], starts[run])
    with np.errstate(divide='ignore', invalid='ignore'):
        height: Array = np.clip((border - s) / along, 0.0, highest)
    return height
