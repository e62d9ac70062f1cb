"""Stress scenes in three dimensions: spirals from near and far, and a nozzle in view.

A Zivid 2 M70 sees them from 0.30 m (0.17 mm per pixel) or 0.70 m (0.39 mm per pixel).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bpc_perception.core.geometry import invert, transform
from bpc_sim.ink.curves import archimedean
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import bed_pose
from bpc_sim.scene.scene import Scene, Sensor
from bpc_sim.scene.surfaces import Cylinder, Plane, Surface
from bpc_sim.stress.camera_placement import CameraPlacement
from bpc_sim.stress.planar_print import BEAD_WIDTH_M, seeded
from bpc_sim.stress.solid_scene import (
    good_imaging,
    punch_holes,
    solid_scene,
    TIP_HEIGHT_M,
    width_with_statistics,
)
from bpc_sim.stress.stress_scene import STAMP_NS, StressScene

NEAR_CAMERA_M, FAR_CAMERA_M = 0.30, 0.70  # from the camera to the bed's middle
CYLINDER_BED = Cylinder(0.06)
WIDTH_STD_M = 0.15e-3


@dataclass(frozen=True)
class Spiral:
    """The common print: about 2 mm wide, 6.3 mm from turn to turn, with two gaps.

    Attributes:
        placement: where the camera stands.
        surface: the bed.
    """

    placement: CameraPlacement
    surface: Surface = field(default_factory=Plane)

    def scene(self, name: str, seed: int) -> StressScene:
        """Return the scene of a name and a seed."""
        rng = seeded(name, seed)
        curve = archimedean(1e-3, np.pi, 6 * np.pi)
        starts = curve.length * rng.uniform((0.15, 0.6), (0.45, 0.9))
        gaps = np.stack((starts, starts + np.array((3e-3, 5e-3))), axis=1)
        width = width_with_statistics(curve.length, BEAD_WIDTH_M, WIDTH_STD_M, rng)
        scene = Scene(Deposit(curve, width, gaps), bed_pose(), surface=self.surface)
        return solid_scene(name, scene, self.placement.view(rng), rng)


SPIRALS: dict[str, Spiral] = {
    'flat_017': Spiral(CameraPlacement(NEAR_CAMERA_M)),
    'tilted_25_017': Spiral(CameraPlacement(NEAR_CAMERA_M, np.radians(25))),
    'tilted_40_017': Spiral(CameraPlacement(NEAR_CAMERA_M, np.radians(40))),
    'cylinder_017': Spiral(CameraPlacement(NEAR_CAMERA_M, np.radians(10)), CYLINDER_BED),
    'corner_of_view': Spiral(
        CameraPlacement(NEAR_CAMERA_M, np.radians(30), (320, 320), off_axis=True)),
    'flat_039': Spiral(CameraPlacement(FAR_CAMERA_M, size=(128, 128))),
    'tilted_25_039': Spiral(CameraPlacement(FAR_CAMERA_M, np.radians(25), (128, 128))),
    'tilted_40_039': Spiral(CameraPlacement(FAR_CAMERA_M, np.radians(40), (128, 128))),
    'cylinder_039': Spiral(
        CameraPlacement(FAR_CAMERA_M, np.radians(10), (128, 128)), CYLINDER_BED),
}


def nozzle_in_view(seed: int) -> StressScene:
    """Return a print half done, from 35 degrees off the normal: the nozzle hides ink behind it."""
    rng = seeded('nozzle_in_view', seed)
    curve = archimedean(1e-3, np.pi, 6 * np.pi)
    T_base_surface = bed_pose()
    view = CameraPlacement(NEAR_CAMERA_M, np.radians(35)).view(rng)
    # The nozzle stands between the camera and the inner turns.
    eye = transform(invert(T_base_surface), view.T_base_camera[:3, 3])[:2]
    s = curve.uniform(1000)[420:]  # a little more than one turn
    places = curve.points(s)
    ahead = places @ eye / np.linalg.norm(eye) / np.linalg.norm(places, axis=1)
    laid = float(rng.choice(s[ahead > 0.8]))
    commanded = Deposit(curve, constant_width(BEAD_WIDTH_M), np.array(((0.03, 0.034),)))
    width = width_with_statistics(curve.length, BEAD_WIDTH_M, WIDTH_STD_M, rng)
    job = PrintJob(commanded, T_base_surface, view, width, sensor=Sensor(good_imaging(rng)),
                   seed=seed, tip_height=TIP_HEIGHT_M)
    t = job.dwell_before + laid / job.speed
    capture = punch_holes(job.capture(t, 0, STAMP_NS), rng)
    return solid_scene('nozzle_in_view', job.scene(t), view, rng, capture)
