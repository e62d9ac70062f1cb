"""The paper's four hardware prints as stress scenes, with the statistics that it reports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import archimedean, Curve, fermat, line
from bpc_sim.ink.deposit import Deposit, WidthProfile
from bpc_sim.printer.scenarios import bed_pose
from bpc_sim.scene.scene import Scene
from bpc_sim.stress.camera_placement import CameraPlacement
from bpc_sim.stress.planar_print import seeded
from bpc_sim.stress.solid_scene import solid_scene, width_with_statistics
from bpc_sim.stress.stress_scene import StressScene

# The camera of the paper's prints [inference: the paper does not say].
OVERVIEW = CameraPlacement(0.34, np.radians(20), (248, 248))


def line_print(seed: int) -> StressScene:
    """Return a line whose extrusion stops half-way.

    It is 3.3 mm wide, then decays from 2.8 mm to 0.3 mm at the end. The paper reports a mean of
    2.135 mm, a standard deviation of 1.280 and quartiles 0.917, 2.790, 3.322.
    """
    rng = seeded('hardware_line', seed)
    length = 0.05
    fed = width_with_statistics(length, 3.3e-3, 0.08e-3, rng)

    def profile(s: Array) -> Array:
        share = np.clip(s / length, 0.0, 1.0)
        decayed = 2.79e-3 * np.exp(-4.45 * (share - 0.5))
        # The last 4 % of the fed half blend into the decay.
        blend = np.clip((0.5 - share) / 0.04, 0.0, 1.0)
        return np.asarray(blend * fed(s) + (1 - blend) * np.minimum(decayed, 3.3e-3))

    placement = replace(OVERVIEW, size=(304, 96), turn=0.3)
    return _hardware_print('hardware_line', line(length), profile, rng, placement=placement)


def fermat_print(seed: int) -> StressScene:
    """Return a spiral with the reported mean and standard deviation: 1.569 mm, 0.289 mm."""
    rng = seeded('hardware_fermat', seed)
    curve = fermat(7.5e-3, 2 * np.pi)
    width = width_with_statistics(curve.length, 1.569e-3, 0.289e-3, rng)
    return _hardware_print('hardware_fermat', curve, width, rng)


def archimedean_print(seed: int) -> StressScene:
    """Return a spiral with the reported mean and standard deviation: 1.604 mm, 0.330 mm."""
    rng = seeded('hardware_archimedean', seed)
    curve = archimedean(1e-3, np.pi, 6 * np.pi)
    width = width_with_statistics(curve.length, 1.604e-3, 0.330e-3, rng)
    return _hardware_print('hardware_archimedean', curve, width, rng)


def archimedean_print_with_gaps(seed: int) -> StressScene:
    """Return a spiral with four gaps; without them it is as reported, 1.575 mm and 0.411 mm."""
    rng = seeded('hardware_archimedean_gaps', seed)
    curve = archimedean(1e-3, np.pi, 6 * np.pi)
    starts = (np.arange(4) + rng.uniform(0.2, 0.8, 4)) * curve.length / 4
    gaps = np.stack((starts, starts + rng.uniform(2e-3, 6e-3, 4)), axis=1)
    width = width_with_statistics(curve.length, 1.575e-3, 0.411e-3, rng)
    return _hardware_print('hardware_archimedean_gaps', curve, width, rng, gaps)


def _hardware_print(name: str, curve: Curve, profile: WidthProfile, rng: np.random.Generator,
                    gaps: Array | None = None,
                    placement: CameraPlacement = OVERVIEW) -> StressScene:
    """Return a print of the paper's as a scene."""
    deposit = Deposit(curve, profile, np.empty((0, 2)) if gaps is None else gaps)
    return solid_scene(name, Scene(deposit, bed_pose()), placement.view(rng), rng)
