"""Ink on a plane bed seen from straight above, 512 x 512 pixels of 0.1 mm, for stress scenes.

Unless a scene says otherwise, ink about 2 mm wide lies on a plain bed. The image is blurred by
1 pixel and has noise of 6 grey levels; the lamp falls from +12 % to -12 %. This is the image model
under which other tools have been compared. Colours, widths and gaps change with the seed.
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
from bpc_sim.scene.planar_capture import planar_capture
from bpc_sim.scene.raster import coverage, pixel_centres
from bpc_sim.stress.stress_scene import STAMP_NS, StressScene
from bpc_sim.stress.truth import classify_samples

PIXEL_M = 1e-4  # length of a pixel's side
IMAGE_SIZE_PX = 512  # width and height
SAMPLE_SPACING_M = 2e-4  # of the path
BEAD_WIDTH_M = 2e-3
DENSE_STEP_M = 2e-5  # at which a curve is walked to find evenly spaced samples
WIDTH_KNOT_SPACING_M = 0.015
NO_DISCS = np.empty((0, 3))

USUAL_IMAGING = Imaging(lamp_gradient=0.12, blur=1.0, noise=6.0)
COLOURS: tuple[tuple[Colour, Colour], ...] = (  # ink, bed
    ((40.0, 80.0, 170.0), (205.0, 205.0, 200.0)),
    ((60.0, 60.0, 60.0), (200.0, 200.0, 200.0)),
    ((150.0, 60.0, 70.0), (190.0, 185.0, 175.0)),
    ((60.0, 110.0, 60.0), (180.0, 185.0, 195.0)),
    ((110.0, 80.0, 140.0), (215.0, 210.0, 200.0)),
)


@dataclass(frozen=True, eq=False)
class PlanarPrint:
    """Ink on a plane bed, before its picture is taken.

    Attributes:
        deposit: the ink along the path; the surface frame is the base frame.
        imaging: colours and imperfections.
        rng: source of everything random in the picture.
        fills: (F, 3) centre and radius of discs of ink that round the outside of corners [m].
        drops: (D, 3) centre and radius of drops of spilled ink [m].
    """

    deposit: Deposit
    imaging: Imaging
    rng: np.random.Generator
    fills: Array = field(default_factory=lambda: NO_DISCS)
    drops: Array = field(default_factory=lambda: NO_DISCS)

    @cached_property
    def location(self) -> Location:
        """Where the centres of all pixels lie relative to the ink along the path, row by row."""
        return self.deposit.locate(pixel_centres(IMAGE_SIZE_PX, PIXEL_M))

    @cached_property
    def coverage(self) -> Array:
        """Fraction (H, W) of each pixel that ink of any kind covers."""
        return coverage(self.margin, IMAGE_SIZE_PX, PIXEL_M)

    def margin(self, points: Array) -> Array:
        """Return about the distance of points (N, 2) or (N, M, 2) from ink of any kind [m]."""
        margin = self.deposit.locate(points).margin
        for x, y, radius in np.concatenate((self.fills, self.drops)):
            margin = np.minimum(margin, np.hypot(points[..., 0] - x, points[..., 1] - y) - radius)
        return margin

    def scene(self, name: str, ink: Array | Colour | None = None,
              bed: Array | Colour | None = None, shade: Array | float = 1.0,
              path_shift: float = 0.0) -> StressScene:
        """Take the picture and return it with its truth.

        Args:
            name: name of the scene.
            ink: light of the ink, (H, W, 3) or one colour; by default that of ``imaging``.
            bed: light of the bed, likewise.
            shade: factor (H, W, 1) on the light.
            path_shift: how far the path lies to the left of the ink [m]. It is parallel to the
                true path, so that both have the same cross-sections.
        """
        light = shade * mix(self.imaging.ink if ink is None else ink,
                            self.imaging.bed if bed is None else bed, self.coverage)
        image = expose(light, self.coverage, self.imaging, self.rng)
        capture, T_base_camera = planar_capture(image, PIXEL_M, STAMP_NS)
        curve = self.deposit.curve

        def locus(s: Array) -> Array:
            points = curve.points(s) + path_shift * curve.normals(s)
            return np.column_stack((points, np.zeros(len(s))))

        s, arc_length = even_samples(locus, curve.length)
        expected = classify_samples(self.deposit, s, PIXEL_M, self.drops)
        return StressScene(name, capture, T_base_camera, locus(s), arc_length,
                           self.deposit.width(s), expected, PIXEL_M)


def even_samples(locus: Callable[[Array], Array], length: float) -> tuple[Array, Array]:
    """Sample a curve at points that are about SAMPLE_SPACING_M apart.

    Args:
        locus: from parameters (N,) to points (N, 3) [m].
        length: largest parameter.

    Returns:
        Parameters (N,) in [0, length], and the arc lengths (N,) along their points [m].
    """
    dense = np.linspace(0.0, length, int(length / DENSE_STEP_M) + 2)
    steps = np.linalg.norm(np.diff(locus(dense), axis=0), axis=1)
    travelled = np.concatenate(([0.0], np.cumsum(steps)))
    arc_length = np.linspace(0.0, travelled[-1], round(travelled[-1] / SAMPLE_SPACING_M) + 1)
    return np.interp(arc_length, travelled, dense), arc_length


def seeded(name: str, seed: int) -> np.random.Generator:
    """Return the random generator of a scene and a seed; each has its own."""
    return np.random.default_rng((seed, *name.encode()))


def random_width(length: float, mean: float, amplitude: float,
                 rng: np.random.Generator) -> WidthProfile:
    """Return a width [m] that varies between mean - amplitude and mean + amplitude."""
    knots = np.linspace(0.0, length, max(round(length / WIDTH_KNOT_SPACING_M), 2) + 1)
    return knot_width(knots, mean + amplitude * rng.uniform(-1, 1, len(knots)))


def random_imaging(rng: np.random.Generator) -> Imaging:
    """Return the usual imperfections with random colours."""
    ink, bed = np.array(COLOURS[rng.integers(len(COLOURS))])
    ink, bed = (tuple((colour + rng.uniform(-10, 10, 3)).tolist()) for colour in (ink, bed))
    return replace(USUAL_IMAGING, ink=ink, bed=bed)


def spiral(rng: np.random.Generator, imaging: Imaging | None = None,
           amplitude: float = 0.35e-3) -> PlanarPrint:
    """Return the paper's Archimedean spiral, 7.5 mm from turn to turn, with two gaps."""
    curve = archimedean(12 * PIXEL_M, np.pi, 6 * np.pi)
    starts = curve.length * rng.uniform((0.15, 0.6), (0.45, 0.9))
    gaps = np.stack((starts, starts + np.array((3e-3, 5e-3))), axis=1)
    width = random_width(curve.length, BEAD_WIDTH_M, amplitude, rng)
    return PlanarPrint(Deposit(curve, width, gaps), imaging or random_imaging(rng), rng)


def along(curve: Curve, rng: np.random.Generator) -> PlanarPrint:
    """Return ink of constant width along a curve."""
    return PlanarPrint(Deposit(curve, constant_width(BEAD_WIDTH_M)), random_imaging(rng), rng)
