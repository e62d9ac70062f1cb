"""Ink on a plane bed seen from straight above, 512 x 512 pixels of 0.1 mm, as stress scenes.

Unless a scene says otherwise, ink 2 mm wide or about lies on a plain bed, blurred by 1 pixel,
with noise of 6 grey levels and a lamp that falls from +12 % to -12 %: the image model under which
other tools have been compared. Colours, widths and gaps change with the seed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import archimedean, Curve
from bpc_sim.ink.deposit import constant_width, Deposit, knot_width, Location, WidthProfile
from bpc_sim.scene.imaging import Colour, expose, Imaging, mix
from bpc_sim.scene.planar import planar_capture
from bpc_sim.scene.raster import coverage, pixel_centres
from bpc_sim.stress.truth import judge, STAMP_NS, StressScene

PIXEL = 1e-4  # [m]
SIZE = 512  # [pixels]
SPACING = 2e-4  # of path samples [m]
WIDTH = 2e-3  # [m]
NO_DISCS = np.empty((0, 3))

IMAGING = Imaging(lamp_gradient=0.12, blur=1.0, noise=6.0)
COLOURS: tuple[tuple[Colour, Colour], ...] = (  # ink, bed
    ((40.0, 80.0, 170.0), (205.0, 205.0, 200.0)),
    ((60.0, 60.0, 60.0), (200.0, 200.0, 200.0)),
    ((150.0, 60.0, 70.0), (190.0, 185.0, 175.0)),
    ((60.0, 110.0, 60.0), (180.0, 185.0, 195.0)),
    ((110.0, 80.0, 140.0), (215.0, 210.0, 200.0)),
)


@dataclass(frozen=True, eq=False)
class Sheet:
    """Ink on a plane bed, before its picture is taken.

    Attributes:
        deposit: the ink along the path, in the surface frame = base frame.
        imaging: colours and imperfections.
        rng: of everything random in the picture.
        fills: (F, 3) centre and radius of discs that round the outside of corners [m].
        drops: (D, 3) centre and radius of drops of spilled ink [m].
    """

    deposit: Deposit
    imaging: Imaging
    rng: np.random.Generator
    fills: Array = field(default_factory=lambda: NO_DISCS)
    drops: Array = field(default_factory=lambda: NO_DISCS)

    @cached_property
    def location(self) -> Location:
        """Where the pixels' centres (SIZE * SIZE,) lie relative to the ink along the path."""
        return self.deposit.locate(pixel_centres(SIZE, PIXEL))

    @cached_property
    def coverage(self) -> Array:
        """Fraction (SIZE, SIZE) of each pixel that ink of any kind covers."""
        return coverage(self.margin, SIZE, PIXEL)

    def margin(self, points: Array) -> Array:
        """About the distance of points (N, 2) or (N, M, 2) from ink of any kind [m]."""
        margin = self.deposit.locate(points).margin
        for x, y, radius in np.concatenate((self.fills, self.drops)):
            margin = np.minimum(margin, np.hypot(points[..., 0] - x, points[..., 1] - y) - radius)
        return margin

    def scene(self, name: str, ink: Array | Colour | None = None,
              bed: Array | Colour | None = None, shade: Array | float = 1.0,
              path_shift: float = 0.0) -> StressScene:
        """Take the picture.

        Args:
            name: of the scene.
            ink: its light, (SIZE, SIZE, 3) or one colour; by default that of ``imaging``.
            bed: likewise.
            shade: factor (SIZE, SIZE, 1) on the light.
            path_shift: how far the path is shifted to the left of the ink [m]. The shifted path
                is parallel to the true one, so that both have the same cross-sections.
        """
        light = shade * mix(self.imaging.ink if ink is None else ink,
                            self.imaging.bed if bed is None else bed, self.coverage)
        image = expose(light, self.coverage, self.imaging, self.rng)
        capture, T_base_camera = planar_capture(image, PIXEL, STAMP_NS)
        curve = self.deposit.curve

        def locus(s: Array) -> Array:
            points = curve.points(s) + path_shift * curve.normals(s)
            return np.column_stack((points, np.zeros(len(s))))

        s, arc_length = even(locus, curve.length)
        return StressScene(name, capture, T_base_camera, locus(s), arc_length,
                           self.deposit.width(s), judge(self.deposit, s, PIXEL, self.drops),
                           PIXEL)


def even(locus: Callable[[Array], Array], length: float) -> tuple[Array, Array]:
    """Parameters (N,) in [0, length] at which a curve's points are SPACING or so apart.

    ``locus`` takes parameters (N,) to points (N, 3); the second result are the arc lengths (N,)
    along these points [m].
    """
    dense = np.linspace(0.0, length, int(length / 2e-5) + 2)
    steps = np.linalg.norm(np.diff(locus(dense), axis=0), axis=1)
    travelled = np.concatenate(([0.0], np.cumsum(steps)))
    arc_length = np.linspace(0.0, travelled[-1], round(travelled[-1] / SPACING) + 1)
    return np.interp(arc_length, travelled, dense), arc_length


def seeded(name: str, seed: int) -> np.random.Generator:
    """A generator of its own for every scene and seed."""
    return np.random.default_rng((seed, *name.encode()))


def wandering(length: float, mean: float, amplitude: float,
              rng: np.random.Generator) -> WidthProfile:
    """A width [m] that wanders between mean - amplitude and mean + amplitude."""
    knots = np.linspace(0.0, length, max(round(length / 0.015), 2) + 1)
    return knot_width(knots, mean + amplitude * rng.uniform(-1, 1, len(knots)))


def coloured(rng: np.random.Generator) -> Imaging:
    """The usual imperfections, and colours by chance."""
    ink, bed = np.array(COLOURS[rng.integers(len(COLOURS))])
    ink, bed = (tuple((colour + rng.uniform(-10, 10, 3)).tolist()) for colour in (ink, bed))
    return replace(IMAGING, ink=ink, bed=bed)


def spiral(rng: np.random.Generator, imaging: Imaging | None = None,
           amplitude: float = 0.35e-3) -> Sheet:
    """The paper's Archimedean spiral, 7.5 mm from turn to turn, with two gaps."""
    curve = archimedean(12 * PIXEL, np.pi, 6 * np.pi)
    starts = curve.length * rng.uniform((0.15, 0.6), (0.45, 0.9))
    gaps = np.stack((starts, starts + np.array((3e-3, 5e-3))), axis=1)
    return Sheet(Deposit(curve, wandering(curve.length, WIDTH, amplitude, rng), gaps),
                 imaging or coloured(rng), rng)


def along(curve: Curve, rng: np.random.Generator, width: float = WIDTH) -> Sheet:
    """Ink of constant width along a curve."""
    return Sheet(Deposit(curve, constant_width(width)), coloured(rng), rng)
