"""Where the camera of a stress scene stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import PinholeCamera
from bpc_perception.core.geometry import invert, transform
from bpc_sim.printer.scenarios import bed_pose
from bpc_sim.scene.camera import look_at, View, zivid_m70


@dataclass(frozen=True)
class CameraPlacement:
    """Where the camera stands and how much it sees.

    Attributes:
        distance: distance from the bed's middle [m].
        tilt: angle between the view and the bed's normal there [rad].
        size: width and height of the image [pixels].
        turn: range of directions about the bed's normal from which the camera may look [rad].
        off_axis: the camera does not turn towards the print, but sees it that far from its axis.
            28 degrees is what a Zivid 2 M70 sees at its border.
    """

    distance: float
    tilt: float = 0.0
    size: tuple[int, int] = (272, 272)
    turn: float = 2 * np.pi
    off_axis: bool = False

    def view(self, rng: np.random.Generator) -> View:
        """Return a camera that sees the bed from a random side."""
        azimuth = self.turn * rng.uniform(-0.5, 0.5)
        cos, sin = np.cos(azimuth), np.sin(azimuth)
        eye = self.distance * np.array((np.sin(self.tilt) * sin, -np.sin(self.tilt) * cos,
                                        np.cos(self.tilt)))
        T_base_surface = bed_pose()
        if self.off_axis:
            return _straight_down(eye, self.size)
        return View(zivid_m70(*self.size), look_at(
            transform(T_base_surface, eye), T_base_surface[:3, 3],
            T_base_surface[:3, :3] @ np.array((cos, sin, 0.0))))


def _straight_down(eye: Array, size: tuple[int, int]) -> View:
    """Return a view along the bed's normal from ``eye`` (3,), cut out around the bed's middle."""
    T_base_surface = bed_pose()
    below = eye * (1, 1, 0)
    T_base_camera = look_at(transform(T_base_surface, eye), transform(T_base_surface, below),
                            T_base_surface[:3, 0])
    camera = zivid_m70(*size)
    middle = camera.pixels(transform(invert(T_base_camera), T_base_surface[:3, 3]))
    K = camera.K.copy()
    K[:2, 2] += np.rint(np.array(size) / 2 - middle)
    return View(PinholeCamera(K, np.zeros(5), *size), T_base_camera)
