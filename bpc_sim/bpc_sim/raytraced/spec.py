"""What a ray-traced scene is made of, and its truth, which is geometry."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.geometry import transform
from bpc_sim.ink.curves import archimedean, Curve, meander, polyline
from bpc_sim.ink.deposit import Deposit
from bpc_sim.printer.scenarios import bed_pose
from bpc_sim.raytraced.looks import Bed, Ink, Lamp
from bpc_sim.raytraced.section import Section
from bpc_sim.scene.camera import look_at, View
from bpc_sim.stress.planar_print import even_samples, random_width, seeded
from bpc_sim.stress.stress_scene import StressScene
from bpc_sim.stress.truth import Categories, classify_samples, Truth

SIZE_PX = (240, 180)  # of a picture
DISTANCE_M = 0.3  # of the camera from the bed
TIP_HEIGHT_M = 1e-3  # of the nozzle above the bed
WIDTH_VARIES = 0.08  # as a share of the width


class Way(Enum):
    """Where the nozzle went."""

    MEANDER = 'meander'
    TURNS = 'tight turns'
    CORNERS = 'sharp corners'
    SPIRAL = 'spiral'
    GAPS = 'meander with gaps'


class Half(Enum):
    """What a scene is for."""

    TUNING = 'tuning'
    JUDGING = 'judging'


@dataclass(frozen=True)
class RaytracedScene:
    """A picture to be traced, and its truth.

    Attributes:
        name: of the scene; everything random follows from it.
        half: what it is for.
        ink, bed, lamp: how it looks.
        section: of the bead.
        width_px: mean width of the bead [pixels].
        way: of the nozzle.
        pixel_mm: length of a pixel's side on the bed.
        tilt_deg: between view and bed.
        defocus_px: radius of the disc that a point out of focus becomes.
        srgb: whether the colours are coded as for a screen, instead of linear.
    """

    name: str
    half: Half
    ink: Ink
    bed: Bed
    lamp: Lamp
    section: Section
    width_px: float = 9.0
    way: Way = Way.MEANDER
    pixel_mm: float = 0.17
    tilt_deg: float = 0.0
    defocus_px: float = 0.0
    srgb: bool = False

    def rng(self, purpose: str) -> np.random.Generator:
        """Return a source of everything random for a purpose."""
        return seeded(f'{self.name} {purpose}', 0)

    @property
    def pixel(self) -> float:
        """Length of a pixel's side on the bed [m]."""
        return self.pixel_mm * 1e-3

    @cached_property
    def view(self) -> View:
        """The camera and where it stands."""
        width, height = SIZE_PX
        focal = DISTANCE_M / self.pixel
        K = np.array(((focal, 0, (width - 1) / 2), (0, focal, (height - 1) / 2), (0, 0, 1.0)))
        tilt, azimuth = np.radians(self.tilt_deg), self.rng('view').uniform(-np.pi, np.pi)
        away = np.array((np.sin(tilt) * np.sin(azimuth), -np.sin(tilt) * np.cos(azimuth),
                         np.cos(tilt)))
        T_base_surface = bed_pose()
        # A picture is wider than high; so is a print.
        right = T_base_surface[:3, :3] @ np.array((1.0, 0.0, 0.0))
        eye = transform(T_base_surface, DISTANCE_M * away)
        return View(PinholeCamera(K, np.zeros(5), width, height),
                    look_at(eye, T_base_surface[:3, 3], right))

    @cached_property
    def deposit(self) -> Deposit:
        """The ink; its frame is that of the bed's surface."""
        curve = self._curve()
        mean = self.width_px * self.pixel
        width = random_width(curve.length, mean, WIDTH_VARIES * mean, self.rng('width'))
        gaps = np.empty((0, 2))
        if self.way is Way.GAPS:
            starts = curve.length * np.array((0.2, 0.5, 0.8))
            gaps = np.stack((starts, starts + mean * np.array((2.6, 4.0, 6.0))), axis=1)
        return Deposit(curve, width, gaps, height_ratio=self.section.height)

    def _curve(self) -> Curve:
        px = self.pixel
        # Seen from the side, a picture shows less of the bed.
        fits = np.cos(np.radians(self.tilt_deg))
        if self.way is Way.TURNS:
            return meander(2.6 * self.width_px * px, 90 * fits * px, 4)
        if self.way is Way.CORNERS:
            x = np.array((-85, -85, -25, -25, 30, 85)) * fits
            y = np.array((-50, 50, 50, -45, 40, -50)) * fits
            return polyline(np.stack((x, y), axis=1) * px)
        if self.way is Way.SPIRAL:
            return archimedean(5.0 * px, np.pi, 5 * np.pi * fits)
        return meander(38 * fits * px, 110 * fits * px, 4)

    def scene(self, capture: Capture) -> StressScene:
        """Return a capture of the scene beside its truth."""
        T_base_surface = bed_pose()

        def locus(s: Array) -> Array:
            level = np.full((len(s), 1), TIP_HEIGHT_M)
            return transform(T_base_surface, np.hstack((self.deposit.curve.points(s), level)))

        s, arc_length = even_samples(locus, self.deposit.curve.length)
        return StressScene(self.name, capture, self.view.T_base_camera, locus(s), arc_length,
                           self.deposit.width(s), self.expected(s), self.pixel)

    def expected(self, s: Array) -> Categories:
        """Return what can be known (N,) at arc lengths s (N,) [m], as values of Truth.

        Ends are round: ink goes on beyond a run by half a width.
        """
        expected = classify_samples(self.deposit, s, self.pixel)
        beyond = self.deposit.beyond_run(s)
        width = self.deposit.profile(s)
        expected[(beyond > 0) & (beyond <= width / 2 + self.pixel)] = Truth.EDGE
        return expected
