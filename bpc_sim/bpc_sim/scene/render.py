"""A structured-light capture of a deposit on its bed, with the nozzle in front.

Rays are met with the bed and with the bead's parabolic cross-section in closed form: in the frame
of the path's tangent and normal a ray is a straight line, and the bead below it a parabola. On a
curved bed a ray is straight enough over the height of a bead.
Pixels take the mean colour of a grid of rays wherever there is more to see than bed: edges are
where geometry puts them, to about a hundredth of a pixel, and so is what shines on the bead.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.geometry import invert, transform
from bpc_sim.ink.deposit import Deposit
from bpc_sim.scene.camera import rays, View
from bpc_sim.scene.imaging import Colour, expose, Imaging, mix
from bpc_sim.scene.surfaces import Plane, Surface

INSIDE = 3  # rays per pixel side where a pixel sees but the bead


@dataclass(frozen=True)
class Nozzle:
    """A cone that opens upwards from the tip; what it is mounted to is out of the picture.

    Attributes:
        tip_radius: outer radius at the tip [m]; 18 gauge by default.
        half_angle: between axis and side [rad].
        length: along the axis [m].
        colour: RGB, 0..255.
    """

    tip_radius: float = 0.635e-3
    half_angle: float = 0.08
    length: float = 0.06
    colour: Colour = (150.0, 152.0, 158.0)


@dataclass(frozen=True)
class Sensor:
    """How the camera sees: the image's and the cloud's imperfections.

    Attributes:
        imaging: colours, lamp, lens, noise of the image.
        shading: how much light a surface loses that turns away from the camera's lamp, 0..1.
        gloss: brightness of the lamp's reflection along wet ink, 0..1.
        depth_noise: sigma of the points along their rays, at 0.4 m; grows with the square of
            the distance [m].
        dropout: fraction of points missing at random.
        rim_dropout: fraction of points missing at the rim of the bead.
        supersample: rays per pixel side where an edge runs through a pixel.
    """

    imaging: Imaging = field(default_factory=lambda: Imaging(
        lamp_gradient=0.08, blur=0.7, noise=2.0))
    shading: float = 0.5
    gloss: float = 0.3
    depth_noise: float = 5e-5
    dropout: float = 0.005
    rim_dropout: float = 0.2
    supersample: int = 6


@dataclass(frozen=True, eq=False)
class Scene:
    """Ink on a bed, and perhaps the nozzle.

    Attributes:
        deposit: the ink, in coordinates along the bed.
        T_base_surface: (4, 4) pose of the bed; its z axis is the outward normal.
        T_base_tip: (4, 4) pose of the nozzle's tip, z out of the tip along the tool; None
            without one.
        nozzle: its shape.
        surface: the bed's shape.
    """

    deposit: Deposit
    T_base_surface: Array
    T_base_tip: Array | None = None
    nozzle: Nozzle = field(default_factory=Nozzle)
    surface: Surface = field(default_factory=Plane)


@dataclass(frozen=True)
class Hits:
    """Where rays meet the ink; arrays (N, M), M rays to a pixel.

    Attributes:
        hit: whether the ray meets ink at all.
        height: above the bed there [m]; 0 without ink.
        slope: of the bead across the path, 0 on its ridge.
        heading: angle of the path's tangent [rad].
        margin: about the distance from the rim [m], negative inside.
    """

    hit: NDArray[np.bool_]
    height: Array
    slope: Array
    heading: Array
    margin: Array


def render(scene: Scene, view: View, sensor: Sensor, rng: np.random.Generator,
           stamp_ns: int = 0, frame_id: str = 'camera_optical_frame') -> Capture:
    """What the camera delivers of the scene."""
    camera = view.camera
    shape = camera.height, camera.width
    v, u = np.mgrid[0:camera.height, 0:camera.width].reshape(2, -1)
    centres = np.stack((u, v), axis=1).astype(np.float64)[:, None]
    T_surface_camera = invert(scene.T_base_surface) @ view.T_base_camera
    eye = T_surface_camera[:3, 3]

    directions = rays(camera, centres)
    seen = directions @ T_surface_camera[:3, :3].T
    ground, lean, depth = scene.surface.meet(eye, seen, np.zeros(seen.shape[:2]))
    footprint = _meet(scene, eye, seen, np.zeros(seen.shape[:2]))
    hits = _refine(scene, eye, seen, footprint)
    metal_depth = nozzle_depth(directions, scene, view)

    ink = hits.hit.astype(np.float64)[:, 0]
    metal = np.isfinite(metal_depth).astype(np.float64)[:, 0]
    pixel = depth[:, 0] / camera.focal_length
    # A bead that leans away hides a little of the bed behind it.
    hidden = scene.deposit.height_ratio * scene.deposit.max_width * np.linalg.norm(
        lean[:, 0], axis=1)
    edge = np.abs(footprint.margin[:, 0]) < 1.5 * pixel + hidden
    edge |= _outline(metal.reshape(shape)).ravel()
    lamp = transform(T_surface_camera, np.array((0.11, 0.0, 0.0)))
    imaging = sensor.imaging
    bed = np.asarray(imaging.bed) * (1 - sensor.shading * (1 - _lit_bed(
        scene.surface, ground[:, 0], lamp)))[:, None]
    light = mix(scene.nozzle.colour, bed, metal)
    # Everywhere else a pixel sees one thing alone.
    for chosen, count in ((edge, sensor.supersample), (hits.hit[:, 0] & ~edge, INSIDE)):
        steps = (np.arange(count) + 0.5) / count - 0.5
        grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        fine = rays(camera, centres[chosen] + grid)
        fine_metal = np.isfinite(nozzle_depth(fine, scene, view))
        fine_seen = fine @ T_surface_camera[:3, :3].T
        fine_hits = _refine(scene, eye, fine_seen,
                            _meet(scene, eye, fine_seen, np.zeros(fine.shape[:2])))
        fine_ground = scene.surface.meet(eye, fine_seen, np.zeros(fine.shape[:2]))[0]
        diffuse, reflected = _lit_ink(scene.surface, fine_hits, fine_ground, eye, lamp)
        colour = (np.asarray(imaging.ink) * (1 - sensor.shading * (1 - diffuse))[..., None]
                  + 255 * sensor.gloss * reflected[..., None])
        fine_light = np.where(fine_hits.hit[..., None], colour, bed[chosen][:, None])
        light[chosen] = np.where(fine_metal[..., None], scene.nozzle.colour,
                                 fine_light).mean(axis=1)
        metal[chosen] = fine_metal.mean(axis=1)
        # Of what the nozzle leaves free.
        ink[chosen] = ((fine_hits.hit & ~fine_metal).sum(axis=1)
                       / np.maximum((~fine_metal).sum(axis=1), 1))
    image = expose(light.reshape(*shape, 3), (ink * (1 - metal)).reshape(shape),
                   sensor.imaging, rng)

    surface_depth = scene.surface.meet(eye, seen, hits.height)[2]
    z = np.fmin(surface_depth, metal_depth)[:, 0]
    z = z + rng.normal(0.0, 1.0, len(z)) * sensor.depth_noise * (z / 0.4)**2
    rim = np.abs(hits.margin[:, 0]) < pixel
    missing = rng.uniform(size=len(z)) < np.where(rim, sensor.rim_dropout, sensor.dropout)
    missing |= image.min(axis=2).ravel() >= 250
    cloud = directions[:, 0] * np.where(missing, np.nan, z)[:, None]
    return Capture(stamp_ns, frame_id, image,
                   cloud.reshape(*shape, 3).astype(np.float32), camera)


def _meet(scene: Scene, eye: Array, directions: Array, at_height: Array) -> Hits:
    """Meet rays (N, M, 3) with the bead, in the path's frame below their points ``at_height``.

    The nearer that height (N, M) is to the hit, the less the curvature of path and bed matters.
    """
    deposit = scene.deposit
    places, lean, _ = scene.surface.meet(eye, directions, at_height)
    location = deposit.locate(places)
    cos, sin = np.cos(location.heading), np.sin(location.heading)
    along = cos * lean[..., 0] + sin * lean[..., 1]
    across = cos * lean[..., 1] - sin * lean[..., 0]
    s = location.s - along * at_height
    d = location.offset - across * at_height

    # Height h of the ray and of the parabola: h = top - steep (d + across h)^2.
    width = deposit.profile(location.s)
    top = deposit.height_ratio * width
    steep = 4 * deposit.height_ratio / width
    a, b, c = steep * across**2, 1 + 2 * steep * d * across, top - steep * d**2
    root = np.sqrt(np.maximum(b**2 + 4 * a * c, 0))
    with np.errstate(divide='ignore', invalid='ignore'):
        # From above the first of the two; for b < 0 the ray comes over the ridge.
        height = np.where(b > 0, 2 * c / (b + root), (root - b) / (2 * a))
    on_bead = (b**2 + 4 * a * c >= 0) & (height > 0)
    on_top = on_bead & deposit.inked(s + along * height)
    # Past the flat end above, but ending on ink: the ray meets the end's wall.
    wall = on_bead & ~on_top & deposit.inked(s)
    height = np.where(wall, _wall_height(deposit, s, along, height), height)
    hit = on_top | wall
    height = np.where(hit, height, 0.0)
    slope = np.where(hit, -2 * steep * (d + across * height), 0.0)
    margin = np.where(np.isfinite(location.margin), location.margin, np.inf)
    return Hits(hit, height, slope, location.heading, margin)


def _wall_height(deposit: Deposit, s: Array, along: Array, highest: Array) -> Array:
    """Height (N, M) [m] at which rays leave a run of ink over its end."""
    if not len(deposit.runs):
        return np.zeros(s.shape)
    starts, ends = deposit.runs.T
    run = np.clip(np.searchsorted(starts, s, side='right') - 1, 0, len(starts) - 1)
    border = np.where(along > 0, ends[run], starts[run])
    with np.errstate(divide='ignore', invalid='ignore'):
        height: Array = np.clip((border - s) / along, 0.0, highest)
    return height


def _refine(scene: Scene, eye: Array, directions: Array, hits: Hits) -> Hits:
    """The hits of rays (N, M, 3) again, each in the path's frame at the hit itself."""
    chosen = np.flatnonzero(hits.hit.any(axis=1))
    if not len(chosen):
        return hits
    better = _meet(scene, eye, directions[chosen], hits.height[chosen])
    refined = {}
    for name in ('height', 'slope', 'heading', 'margin'):
        refined[name] = getattr(hits, name).copy()
        refined[name][chosen] = getattr(better, name)
    return Hits(hits.hit, **refined)


def meets_ink(directions: Array, scene: Scene, view: View) -> NDArray[np.bool_]:
    """Whether rays (N, M, 3) of the optical frame meet the bead (N, M)."""
    T_surface_camera = invert(scene.T_base_surface) @ view.T_base_camera
    return _meet(scene, T_surface_camera[:3, 3], directions @ T_surface_camera[:3, :3].T,
                 np.zeros(directions.shape[:2])).hit


def nozzle_depth(directions: Array, scene: Scene, view: View) -> Array:
    """Depth (N, M) at which rays (N, M, 3) of the optical frame meet the nozzle; NaN if not."""
    if scene.T_base_tip is None:
        return np.full(directions.shape[:2], np.nan)
    T_tip_camera = invert(scene.T_base_tip) @ view.T_base_camera
    eye = T_tip_camera[:3, 3] * (1, 1, -1)  # up the nozzle is against the tool's axis
    ray = directions @ T_tip_camera[:3, :3].T * (1, 1, -1)
    opening = np.tan(scene.nozzle.half_angle)
    radius = scene.nozzle.tip_radius + opening * eye[2]
    # x^2 + y^2 = (tip_radius + opening z)^2 along eye + depth ray.
    a = ray[..., 0]**2 + ray[..., 1]**2 - (opening * ray[..., 2])**2
    half_b = ray[..., :2] @ eye[:2] - radius * opening * ray[..., 2]
    c = eye[0]**2 + eye[1]**2 - radius**2
    discriminant = half_b**2 - a * c
    root = np.sqrt(np.maximum(discriminant, 0))
    depths = np.stack(((-half_b - root) / a, (-half_b + root) / a))
    up = eye[2] + depths * ray[..., 2]
    seen = (discriminant >= 0) & (depths > 0) & (up >= 0) & (up <= scene.nozzle.length)
    nearest = np.where(seen, depths, np.inf).min(axis=0)
    return np.where(np.isfinite(nearest), nearest, np.nan)


def _outline(mask: Array) -> NDArray[np.bool_]:
    """Pixels (H, W) of which a neighbour differs in a binary mask (H, W)."""
    kernel = np.ones((3, 3), np.uint8)
    mask8 = mask.astype(np.uint8)
    return cv2.dilate(mask8, kernel) != cv2.erode(mask8, kernel)


def _lit_bed(surface: Surface, ground: Array, lamp: Array) -> Array:
    """Light that the bed scatters at places (N, 2); 1 = where it is level as the surface frame is.

    ``lamp`` (3,) is in that frame.
    """
    bed = np.ones(len(ground))
    hit = np.flatnonzero(np.isfinite(ground[:, 0]))
    to_lamp = _unit(lamp - surface.points(ground[hit], np.zeros(len(hit))))
    upward = surface.axes(ground[hit])[:, 2]
    bed[hit] = np.clip((upward * to_lamp).sum(axis=1) / to_lamp[:, 2], 0, None)
    return bed


def _lit_ink(surface: Surface, hits: Hits, ground: Array, eye: Array,
             lamp: Array) -> tuple[Array, Array]:
    """Light that the bead scatters and reflects (N, M) over places (N, M, 2); as for the bed."""
    diffuse, reflected = np.ones(hits.hit.shape), np.zeros(hits.hit.shape)
    ink = hits.hit
    slope, heading = hits.slope[ink], hits.heading[ink]
    normal = _unit(np.stack((slope * np.sin(heading), -slope * np.cos(heading),
                             np.ones(len(slope))), axis=1))
    normal = np.einsum('ij,ijk->ik', normal, surface.axes(ground[ink]))
    point = surface.points(ground[ink], hits.height[ink])
    to_lamp, to_eye = _unit(lamp - point), _unit(eye - point)
    diffuse[ink] = np.clip((normal * to_lamp).sum(axis=1) / to_lamp[:, 2], 0, None)
    reflected[ink] = np.clip((normal * _unit(to_lamp + to_eye)).sum(axis=1), 0, None)**80
    return diffuse, reflected


def _unit(vectors: Array) -> Array:
    """Vectors (N, 3) of unit length along vectors (N, 3)."""
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
