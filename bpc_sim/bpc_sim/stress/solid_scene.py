"""Stress scenes in three dimensions: beads with height, on beds that are tilted or curved.

Depth has noise and holes. Beads are 0.3 times as high as wide. The true width is the chord between
the points at half the width to either side of the path along the bed, where the bead ends; on the
cylinder it is smaller than the width along the bed by 0.1 micrometres. From 40 degrees off the
normal on, a parabolic bead hides part of itself, which moves an edge by at most 0.02 mm at 45
degrees.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.geometry import invert, transform
from bpc_sim.ink.deposit import knot_width, WidthProfile
from bpc_sim.scene.camera import rays, View
from bpc_sim.scene.imaging import Imaging
from bpc_sim.scene.ray_tracing import RayTracer
from bpc_sim.scene.render import render
from bpc_sim.scene.scene import Scene, Sensor
from bpc_sim.stress.planar_print import even_samples, random_imaging
from bpc_sim.stress.stress_scene import STAMP_NS, StressScene
from bpc_sim.stress.truth import classify_samples, INK_BORDER_PX, Truth

TIP_HEIGHT_M = 1e-3  # of the nozzle tip above the bed
HOLES_PER_PIXEL = 2.5e-4  # in the cloud
HOLE_RADIUS_PX = (2, 5)  # smallest and largest
WIDTH_KNOT_SPACING_M = 8e-3

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Visibility:
    """What the camera sees of N samples.

    Attributes:
        hidden: (N,) whether the camera does not see the sample.
        unsure: (N,) whether that is not certain.
    """

    hidden: Mask
    unsure: Mask


def solid_scene(name: str, scene: Scene, view: View, rng: np.random.Generator,
                capture: Capture | None = None) -> StressScene:
    """Return the capture of a scene with its truth.

    Args:
        name: name of the scene.
        scene: ink, bed and nozzle.
        view: camera and pose.
        rng: source of colours, noise and holes.
        capture: what the camera delivers; rendered if None.
    """
    if capture is None:
        capture = punch_holes(render(scene, view, Sensor(good_imaging(rng)), rng, STAMP_NS), rng)
    deposit, surface = scene.deposit, scene.surface

    def locus(s: Array) -> Array:
        places = deposit.curve.points(s)
        return transform(scene.T_base_surface,
                         surface.points(places, np.full(len(s), TIP_HEIGHT_M)))

    s, arc_length = even_samples(locus, min(deposit.laid, deposit.curve.length))
    distance = np.linalg.norm(view.T_base_camera[:3, 3] - scene.T_base_surface[:3, 3])
    pixel = float(distance) / view.camera.focal_length
    level = np.zeros(len(s))
    left, right = (surface.points(side, level) for side in deposit.sides(s))
    expected = classify_samples(deposit, s, pixel)
    visibility = find_visibility(scene, view, s)
    expected[visibility.hidden] = Truth.HIDDEN
    expected[visibility.unsure] = Truth.EDGE
    return StressScene(name, capture, view.T_base_camera, locus(s), arc_length,
                       np.linalg.norm(left - right, axis=1), expected, pixel)


def find_visibility(scene: Scene, view: View, s: Array) -> Visibility:
    """Find which samples at s (N,) [m] the camera sees.

    A sample is seen if the bed below the path and both edges of the bead are seen past the
    nozzle. It is unsure if that differs with the picture shifted by a pixel; or, in gaps, if the
    end of the bead stands in front.
    """
    tracer = RayTracer(scene, view)
    places = np.concatenate((scene.deposit.curve.points(s), *scene.deposit.sides(s)))
    points = transform(scene.T_base_surface, scene.surface.points(places, np.zeros(len(places))))
    uv = view.camera.pixels(transform(invert(view.T_base_camera), points))
    steps = np.array((0.0, -INK_BORDER_PX, INK_BORDER_PX))
    shifts = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    around = uv[:, None] + shifts
    blocked = np.isfinite(tracer.nozzle_depth(rays(view.camera, around)))
    blocked |= ~view.camera.contains(around.reshape(-1, 2)).reshape(blocked.shape)
    behind: Mask = np.asarray(blocked.reshape(3, len(s), -1).any(axis=0))
    unsure = behind.any(axis=1) != behind.all(axis=1)
    gap = np.flatnonzero(~scene.deposit.inked(s))
    unsure[gap] |= tracer.meets_ink(rays(view.camera, around[gap])).any(axis=1)
    return Visibility(behind[:, 0], np.asarray(unsure))


def punch_holes(capture: Capture, rng: np.random.Generator) -> Capture:
    """Return the capture with round holes of 2 to 5 pixels radius in its cloud."""
    height, width = capture.cloud.shape[:2]
    v, u = np.mgrid[0:height, 0:width]
    cloud = capture.cloud.copy()
    smallest, largest = HOLE_RADIUS_PX
    for _ in range(round(HOLES_PER_PIXEL * height * width)):
        x, y, radius = rng.uniform((0, 0, smallest), (width, height, largest))
        cloud[np.hypot(u - x, v - y) <= radius] = np.nan
    return replace(capture, cloud=cloud)


def good_imaging(rng: np.random.Generator) -> Imaging:
    """Return random colours, with the lamp, lens and noise of a good camera."""
    return replace(random_imaging(rng), lamp_gradient=0.08, blur=0.7, noise=3.0)


def width_with_statistics(length: float, mean: float, std: float,
                          rng: np.random.Generator) -> WidthProfile:
    """Return a width that varies over some 8 mm, with exactly this mean and standard deviation.

    Length, mean and standard deviation are in [m].
    """
    knots = np.linspace(0.0, length, round(length / WIDTH_KNOT_SPACING_M) + 1)
    values = np.clip(rng.normal(size=len(knots)), -2, 2)
    found = knot_width(knots, values)(np.linspace(0.0, length, 5001))
    return knot_width(knots, mean + std * (values - found.mean()) / found.std())
