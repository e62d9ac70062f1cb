"""What stands before the camera, and how the camera sees it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.deposit import Deposit
from bpc_sim.scene.imaging import Colour, Imaging
from bpc_sim.scene.surfaces import Plane, Surface


@dataclass(frozen=True)
class Nozzle:
    """A cone that opens upwards from the tip; the tool above it is outside the picture.

    Attributes:
        tip_radius: outer radius at the tip [m]; by default that of 18 gauge.
        half_angle: angle between axis and side [rad].
        length: length along the axis [m].
        colour: RGB, 0..255.
    """

    tip_radius: float = 0.635e-3
    half_angle: float = 0.08
    length: float = 0.06
    colour: Colour = (150.0, 152.0, 158.0)

    def depth(self, directions: Array, T_tip_camera: Array) -> Array:
        """Return the depth (N, M) [m] at which rays meet the nozzle; NaN where they miss.

        Args:
            directions: (N, M, 3) rays in the optical frame, of depth z = 1.
            T_tip_camera: (4, 4) pose of the optical frame in the frame of the tip, whose z axis
                points out of the tip along the tool.
        """
        eye = T_tip_camera[:3, 3] * (1, 1, -1)  # up the nozzle is against the tool's axis
        ray = directions @ T_tip_camera[:3, :3].T * (1, 1, -1)
        opening = np.tan(self.half_angle)
        radius = self.tip_radius + opening * eye[2]
        # x^2 + y^2 = (tip_radius + opening z)^2 along eye + depth ray.
        a = ray[..., 0]**2 + ray[..., 1]**2 - (opening * ray[..., 2])**2
        half_b = ray[..., :2] @ eye[:2] - radius * opening * ray[..., 2]
        c = eye[0]**2 + eye[1]**2 - radius**2
        discriminant = half_b**2 - a * c
        root = np.sqrt(np.maximum(discriminant, 0))
        depths = np.stack(((-half_b - root) / a, (-half_b + root) / a))
        up = eye[2] + depths * ray[..., 2]
        on_cone = (discriminant >= 0) & (depths > 0) & (up >= 0) & (up <= self.length)
        nearest = np.where(on_cone, depths, np.inf).min(axis=0)
        return np.where(np.isfinite(nearest), nearest, np.nan)


@dataclass(frozen=True, eq=False)
class Scene:
    """Ink on a bed, with or without the nozzle.

    Attributes:
        deposit: the ink, in coordinates along the bed.
        T_base_surface: (4, 4) pose of the bed; its z axis is the outward normal.
        T_base_tip: (4, 4) pose of the nozzle's tip, z out of the tip along the tool; None
            without a nozzle.
        nozzle: shape of the nozzle.
        surface: shape of the bed.
        above: further ink that lies on it, or crosses it.
    """

    deposit: Deposit
    T_base_surface: Array
    T_base_tip: Array | None = None
    nozzle: Nozzle = field(default_factory=Nozzle)
    surface: Surface = field(default_factory=Plane)
    above: tuple[Deposit, ...] = ()

    @property
    def deposits(self) -> tuple[Deposit, ...]:
        """All ink."""
        return self.deposit, *self.above


@dataclass(frozen=True)
class Sensor:
    """Imperfections of the camera's image and of its cloud.

    Attributes:
        imaging: colours, lamp, lens and noise of the image.
        shading: how much light a surface loses that turns away from the camera's lamp, 0..1.
        gloss: brightness of the lamp's reflection along wet ink, 0..1.
        depth_noise: standard deviation of the points along their rays at 0.4 m [m]; it grows
            with the square of the distance.
        ink_depth: how far below the surface of ink its points lie, as of ink that light goes into
            [m].
        dropout: fraction of points that are missing at random.
        rim_dropout: fraction of points that are missing at the rim of the bead.
        supersample: rays per pixel side in a pixel that an edge crosses.
    """

    imaging: Imaging = field(default_factory=lambda: Imaging(
        lamp_gradient=0.08, blur=0.7, noise=2.0))
    shading: float = 0.5
    gloss: float = 0.3
    depth_noise: float = 5e-5
    ink_depth: float = 0.0
    dropout: float = 0.005
    rim_dropout: float = 0.2
    supersample: int = 6
