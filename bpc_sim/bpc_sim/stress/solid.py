"""Hard scenes in three dimensions: beads with height, on beds that are tilted or curved.

A Zivid 2 M70 sees them from 0.30 m (0.17 mm per pixel) or 0.70 m (0.39 mm per pixel), with noise
and holes in its depth. Beads are 0.3 times as high as wide. The true width is the chord between
the points at half the width to either side of the path along the bed, where the bead ends; on the
cylinder it is less than the width along the bed by 0.1 micrometres. A parabolic bead hides part
of itself from 40 degrees off the normal on, which moves an edge by 0.02 mm at most at 45.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.geometry import invert, transform
from bpc_sim.ink.curves import archimedean, Curve, fermat, line
from bpc_sim.ink.deposit import constant_width, Deposit, knot_width, WidthProfile
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import bed_pose
from bpc_sim.scene.camera import look_at, rays, View, zivid_m70
from bpc_sim.scene.imaging import Imaging
from bpc_sim.scene.render import meets_ink, nozzle_depth, render, Scene, Sensor
from bpc_sim.scene.surfaces import Cylinder, Plane, Surface
from bpc_sim.stress.sheet import coloured, even, seeded, WIDTH
from bpc_sim.stress.truth import BORDER, judge, STAMP_NS, StressScene, Truth

TIP_HEIGHT = 1e-3  # of the nozzle tip above the bed [m]
NEAR, FAR = 0.30, 0.70  # from the camera to the bed's middle [m]
CYLINDER = Cylinder(0.06)
HOLES = 2.5e-4  # in the cloud, per pixel

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Standpoint:
    """Where the camera stands and how much it sees.

    Attributes:
        distance: from the bed's middle [m].
        tilt: of the view off the bed's normal there [rad].
        size: width and height of the image [pixels].
        turn: it looks from anywhere within this angle about the bed's normal [rad].
        off_axis: it does not turn towards the print, but sees it that far from its axis. 28
            degrees is what a Zivid 2 M70 sees at its border.
    """

    distance: float
    tilt: float = 0.0
    size: tuple[int, int] = (272, 272)
    turn: float = 2 * np.pi
    off_axis: bool = False

    def view(self, rng: np.random.Generator) -> View:
        """The camera, towards the bed from a side that chance decides."""
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
    """A view along the bed's normal from ``eye`` (3,), cut out around the bed's middle."""
    T_base_surface = bed_pose()
    below = eye * (1, 1, 0)
    T_base_camera = look_at(transform(T_base_surface, eye), transform(T_base_surface, below),
                            T_base_surface[:3, 0])
    camera = zivid_m70(*size)
    middle = camera.pixels(transform(invert(T_base_camera), T_base_surface[:3, 3]))
    K = camera.K.copy()
    K[:2, 2] += np.rint(np.array(size) / 2 - middle)
    return View(PinholeCamera(K, np.zeros(5), *size), T_base_camera)


@dataclass(frozen=True)
class Spiral:
    """The common print: 2 mm wide or about, 6.3 mm from turn to turn, with two gaps.

    Attributes:
        standpoint: of the camera.
        surface: the bed.
    """

    standpoint: Standpoint
    surface: Surface = field(default_factory=Plane)

    def scene(self, name: str, seed: int) -> StressScene:
        """The scene of that name."""
        rng = seeded(name, seed)
        curve = archimedean(1e-3, np.pi, 6 * np.pi)
        starts = curve.length * rng.uniform((0.15, 0.6), (0.45, 0.9))
        gaps = np.stack((starts, starts + np.array((3e-3, 5e-3))), axis=1)
        deposit = Deposit(curve, varying_width(curve.length, WIDTH, 0.15e-3, rng), gaps)
        return photograph(name, Scene(deposit, bed_pose(), surface=self.surface),
                          self.standpoint.view(rng), rng)


SPIRALS: dict[str, Spiral] = {
    'flat_017': Spiral(Standpoint(NEAR)),
    'tilted_25_017': Spiral(Standpoint(NEAR, np.radians(25))),
    'tilted_40_017': Spiral(Standpoint(NEAR, np.radians(40))),
    'cylinder_017': Spiral(Standpoint(NEAR, np.radians(10)), CYLINDER),
    'corner_of_view': Spiral(Standpoint(NEAR, np.radians(30), (320, 320), off_axis=True)),
    'flat_039': Spiral(Standpoint(FAR, size=(128, 128))),
    'tilted_25_039': Spiral(Standpoint(FAR, np.radians(25), (128, 128))),
    'tilted_40_039': Spiral(Standpoint(FAR, np.radians(40), (128, 128))),
    'cylinder_039': Spiral(Standpoint(FAR, np.radians(10), (128, 128)), CYLINDER),
}

# Of the paper's prints [inference: it does not say].
OVERVIEW = Standpoint(0.34, np.radians(20), (248, 248))


def photograph(name: str, scene: Scene, view: View, rng: np.random.Generator,
               capture: Capture | None = None) -> StressScene:
    """A capture of a scene, with its truth.

    Args:
        name: of the scene.
        scene: ink, bed and nozzle.
        view: the camera.
        rng: of colours, noise and holes.
        capture: what it delivers; rendered if None.
    """
    if capture is None:
        capture = punch(render(scene, view, Sensor(_imaging(rng)), rng, STAMP_NS), rng)
    deposit, surface = scene.deposit, scene.surface

    def locus(s: Array) -> Array:
        places = deposit.curve.points(s)
        return transform(scene.T_base_surface,
                         surface.points(places, np.full(len(s), TIP_HEIGHT)))

    s, arc_length = even(locus, min(deposit.laid, deposit.curve.length))
    distance = np.linalg.norm(view.T_base_camera[:3, 3] - scene.T_base_surface[:3, 3])
    pixel = float(distance) / view.camera.focal_length
    level = np.zeros(len(s))
    left, right = (surface.points(side, level) for side in deposit.sides(s))
    expected = judge(deposit, s, pixel)
    hidden, unsure = concealed(scene, view, s)
    expected[hidden] = Truth.HIDDEN
    expected[unsure] = Truth.EDGE
    return StressScene(name, capture, view.T_base_camera, locus(s), arc_length,
                       np.linalg.norm(left - right, axis=1), expected, pixel)


def concealed(scene: Scene, view: View, s: Array) -> tuple[Mask, Mask]:
    """Which samples at s (N,) the camera does not see, and of which it is not sure.

    A sample is seen if the bed below the path and both edges of the bead are, past the nozzle;
    unsure, if that differs with the picture shifted by a pixel, or in gaps if the end of the
    bead stands before it.
    """
    places = np.concatenate((scene.deposit.curve.points(s), *scene.deposit.sides(s)))
    points = transform(scene.T_base_surface, scene.surface.points(places, np.zeros(len(places))))
    uv = view.camera.pixels(transform(invert(view.T_base_camera), points))
    steps = np.array((0.0, -BORDER, BORDER))
    shifts = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    around = uv[:, None] + shifts
    blocked = np.isfinite(nozzle_depth(rays(view.camera, around), scene, view))
    blocked |= ~view.camera.contains(around.reshape(-1, 2)).reshape(blocked.shape)
    behind: Mask = np.asarray(blocked.reshape(3, len(s), -1).any(axis=0))
    unsure = behind.any(axis=1) != behind.all(axis=1)
    gap = np.flatnonzero(~scene.deposit.inked(s))
    unsure[gap] |= meets_ink(rays(view.camera, around[gap]), scene, view).any(axis=1)
    return behind[:, 0], np.asarray(unsure)


def punch(capture: Capture, rng: np.random.Generator) -> Capture:
    """The capture with round holes of 2 to 5 pixels radius in its cloud."""
    height, width = capture.cloud.shape[:2]
    v, u = np.mgrid[0:height, 0:width]
    cloud = capture.cloud.copy()
    for _ in range(round(HOLES * height * width)):
        x, y, radius = rng.uniform((0, 0, 2), (width, height, 5))
        cloud[np.hypot(u - x, v - y) <= radius] = np.nan
    return replace(capture, cloud=cloud)


def nozzle_in_view(seed: int) -> StressScene:
    """In the middle of a print, from 35 degrees off the normal: the nozzle hides ink behind it."""
    rng = seeded('nozzle_in_view', seed)
    curve = archimedean(1e-3, np.pi, 6 * np.pi)
    T_base_surface = bed_pose()
    view = Standpoint(NEAR, np.radians(35)).view(rng)
    # Where the nozzle stands between the camera and the inner turns.
    eye = transform(invert(T_base_surface), view.T_base_camera[:3, 3])[:2]
    s = curve.uniform(1000)[420:]  # a turn and a little
    places = curve.points(s)
    ahead = places @ eye / np.linalg.norm(eye) / np.linalg.norm(places, axis=1)
    laid = float(rng.choice(s[ahead > 0.8]))
    job = PrintJob(Deposit(curve, constant_width(WIDTH), np.array(((0.03, 0.034),))),
                   T_base_surface, view, varying_width(curve.length, WIDTH, 0.15e-3, rng),
                   sensor=Sensor(_imaging(rng)), seed=seed, tip_height=TIP_HEIGHT)
    t = job.dwell_before + laid / job.speed
    return photograph('nozzle_in_view', job.scene(t), view, rng,
                      punch(job.capture(t, 0, STAMP_NS), rng))


def varying_width(length: float, mean: float, std: float,
                   rng: np.random.Generator) -> WidthProfile:
    """A width [m] that wanders over some 8 mm, with exactly this mean and standard deviation."""
    knots = np.linspace(0.0, length, round(length / 8e-3) + 1)
    values = np.clip(rng.normal(size=len(knots)), -2, 2)
    found = knot_width(knots, values)(np.linspace(0.0, length, 5001))
    return knot_width(knots, mean + std * (values - found.mean()) / found.std())


def hardware(name: str, curve: Curve, profile: WidthProfile, rng: np.random.Generator,
             gaps: Array | None = None, standpoint: Standpoint = OVERVIEW) -> StressScene:
    """A print of the paper's."""
    deposit = Deposit(curve, profile, np.empty((0, 2)) if gaps is None else gaps)
    return photograph(name, Scene(deposit, bed_pose()), standpoint.view(rng), rng)


def hardware_line(seed: int) -> StressScene:
    """Extrusion stops half-way: 3.3 mm wide, then a decay from 2.8 mm to 0.3 mm at the end.

    The paper reports a mean of 2.135 mm, std 1.280, quartiles 0.917, 2.790, 3.322.
    """
    rng = seeded('hardware_line', seed)
    length = 0.05
    fed = varying_width(length, 3.3e-3, 0.08e-3, rng)

    def profile(s: Array) -> Array:
        share = np.clip(s / length, 0.0, 1.0)
        decayed = 2.79e-3 * np.exp(-4.45 * (share - 0.5))
        # The last 4 % of the fed half go over into it.
        blend = np.clip((0.5 - share) / 0.04, 0.0, 1.0)
        return np.asarray(blend * fed(s) + (1 - blend) * np.minimum(decayed, 3.3e-3))

    return hardware('hardware_line', line(length), profile, rng,
                    standpoint=replace(OVERVIEW, size=(304, 96), turn=0.3))


def hardware_fermat(seed: int) -> StressScene:
    """Mean and standard deviation as reported: 1.569 mm, 0.289 mm."""
    rng = seeded('hardware_fermat', seed)
    curve = fermat(7.5e-3, 2 * np.pi)
    return hardware('hardware_fermat', curve,
                    varying_width(curve.length, 1.569e-3, 0.289e-3, rng), rng)


def hardware_archimedean(seed: int) -> StressScene:
    """Mean and standard deviation as reported: 1.604 mm, 0.330 mm."""
    rng = seeded('hardware_archimedean', seed)
    curve = archimedean(1e-3, np.pi, 6 * np.pi)
    return hardware('hardware_archimedean', curve,
                    varying_width(curve.length, 1.604e-3, 0.330e-3, rng), rng)


def hardware_archimedean_gaps(seed: int) -> StressScene:
    """As reported, 1.575 mm and 0.411 mm, before four gaps are cut out."""
    rng = seeded('hardware_archimedean_gaps', seed)
    curve = archimedean(1e-3, np.pi, 6 * np.pi)
    starts = (np.arange(4) + rng.uniform(0.2, 0.8, 4)) * curve.length / 4
    gaps = np.stack((starts, starts + rng.uniform(2e-3, 6e-3, 4)), axis=1)
    return hardware('hardware_archimedean_gaps', curve,
                    varying_width(curve.length, 1.575e-3, 0.411e-3, rng), rng, gaps)


def _imaging(rng: np.random.Generator) -> Imaging:
    """Colours by chance, and a lamp, a lens and a sensor as of a good camera."""
    return replace(coloured(rng), lamp_gradient=0.08, blur=0.7, noise=3.0)
