"""A structured-light capture of a deposit on its bed, with the nozzle in front.

A pixel takes the mean colour of a grid of rays wherever there is more to see than bed. Edges are
thus where geometry puts them, to about a hundredth of a pixel, and so is the lamp's reflection on
the bead.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, PinholeCamera
from bpc_perception.core.geometry import transform
from bpc_sim.scene.camera import rays, View
from bpc_sim.scene.imaging import expose, mix
from bpc_sim.scene.raster import subpixel_offsets
from bpc_sim.scene.ray_tracing import RayHits, RayTracer
from bpc_sim.scene.scene import Scene, Sensor
from bpc_sim.scene.shading import light_on_bed, light_on_ink

LAMP_POSITION_M = (0.11, 0.0, 0.0)  # in the optical frame: beside the lens
RAYS_ON_BEAD = 3  # per pixel side, in a pixel that sees the bead alone
EDGE_REACH_PX = 1.5  # a pixel this near to the bead's rim may see the edge
DEPTH_NOISE_DISTANCE_M = 0.4  # at which the sensor's depth noise is stated
SATURATED_LEVEL = 250  # grey level from which on a point is lost


@dataclass(frozen=True, eq=False)
class PixelLight:
    """What N pixels see, each on the mean over its area.

    Attributes:
        colour: (N, 3) light, RGB, 0..255.
        ink: (N,) fraction of ink in what the nozzle leaves free.
        nozzle: (N,) fraction that the nozzle covers.
    """

    colour: Array
    ink: Array
    nozzle: Array


def render(scene: Scene, view: View, sensor: Sensor, rng: np.random.Generator,
           stamp_ns: int = 0, frame_id: str = 'camera_optical_frame') -> Capture:
    """Render what the camera delivers of a scene.

    Args:
        scene: ink, bed and nozzle.
        view: camera and pose.
        sensor: imperfections of image and cloud.
        rng: source of noise, glare and missing points.
        stamp_ns: stamp of the capture [ns].
        frame_id: name of the optical frame.

    Raises:
        ValueError: the camera has distortion.
    """
    camera = view.camera
    tracer = RayTracer(scene, view)
    centres = _pixel_centres(camera)
    hits = tracer.trace(rays(camera, centres))
    edges = _find_edges(tracer, hits)
    light = _collect_light(tracer, sensor, centres, hits, edges)
    image = expose(light.colour.reshape(camera.height, camera.width, 3),
                   (light.ink * (1 - light.nozzle)).reshape(camera.height, camera.width),
                   sensor.imaging, rng)
    cloud = _measure_cloud(tracer, sensor, hits, image, rng)
    return Capture(stamp_ns, frame_id, image, cloud, camera)


def _pixel_centres(camera: PinholeCamera) -> Array:
    """Return the centres (H * W, 1, 2) of all pixels as (u, v), row by row."""
    v, u = np.mgrid[0:camera.height, 0:camera.width].reshape(2, -1)
    return np.stack((u, v), axis=1).astype(np.float64)[:, None]


def _pixel_size(hits: RayHits, camera: PinholeCamera) -> Array:
    """Return the length (N,) of each pixel's side at the depth of the bed [m]."""
    size: Array = hits.bed.depth[:, 0] / camera.focal_length
    return size


def _find_edges(tracer: RayTracer, hits: RayHits) -> NDArray[np.bool_]:
    """Return which pixels (N,) an edge of the bead or of the nozzle may cross."""
    camera = tracer.view.camera
    # A bead that leans away hides a little of what is behind it.
    highest = max(deposit.height_ratio * deposit.max_width for deposit in tracer.scene.deposits)
    reach = (EDGE_REACH_PX * _pixel_size(hits, camera)
             + highest * np.linalg.norm(hits.bed.lean[:, 0], axis=1))
    edges: NDArray[np.bool_] = hits.rim[:, 0] < reach
    nozzle = np.isfinite(hits.nozzle_depth).reshape(camera.height, camera.width)
    return edges | _outline(nozzle).ravel()


def _outline(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the pixels (H, W) that have a neighbour with another value in a mask (H, W)."""
    kernel = np.ones((3, 3), np.uint8)
    mask8 = mask.astype(np.uint8)
    return cv2.dilate(mask8, kernel) != cv2.erode(mask8, kernel)


def _collect_light(tracer: RayTracer, sensor: Sensor, centres: Array, hits: RayHits,
                   edges: NDArray[np.bool_]) -> PixelLight:
    """Return the light of all pixels: several rays where a pixel may see ink or an edge.

    Everywhere else a pixel sees one thing alone, bed or nozzle.
    """
    bed = _bed_colour(tracer, sensor, hits)
    ink = hits.ink.hit.astype(np.float64)[:, 0]
    nozzle = np.isfinite(hits.nozzle_depth).astype(np.float64)[:, 0]
    colour = mix(tracer.scene.nozzle.colour, bed, nozzle)
    inside = hits.ink.hit[:, 0] & ~edges
    for chosen, count in ((edges, sensor.supersample), (inside, RAYS_ON_BEAD)):
        fine = _supersample(tracer, sensor, centres[chosen], bed[chosen], count)
        colour[chosen], ink[chosen], nozzle[chosen] = fine.colour, fine.ink, fine.nozzle
    return PixelLight(colour, ink, nozzle)


def _lamp(tracer: RayTracer) -> Array:
    """Return the position (3,) of the lamp in the surface frame [m]."""
    return transform(tracer.T_surface_camera, np.array(LAMP_POSITION_M))


def _bed_colour(tracer: RayTracer, sensor: Sensor, hits: RayHits) -> Array:
    """Return the light (N, 3) of the bare bed, RGB, 0..255."""
    light = light_on_bed(tracer.scene.surface, hits.bed.places[:, 0], _lamp(tracer))
    colour: Array = np.asarray(sensor.imaging.bed) * (1 - sensor.shading * (1 - light))[:, None]
    return colour


def _ink_colour(tracer: RayTracer, sensor: Sensor, hits: RayHits) -> Array:
    """Return the light (N, M, 3) of the ink along each ray, RGB, 0..255."""
    light = light_on_ink(tracer.scene.surface, hits.ink, hits.bed.places, tracer.eye,
                         _lamp(tracer))
    scattered = np.asarray(sensor.imaging.ink) * (
        1 - sensor.shading * (1 - light.diffuse))[..., None]
    colour: Array = scattered + 255 * sensor.gloss * light.reflected[..., None]
    return colour


def _supersample(tracer: RayTracer, sensor: Sensor, centres: Array, bed: Array,
                 count: int) -> PixelLight:
    """Return the light of pixels from ``count`` x ``count`` rays in each.

    Args:
        tracer: the rays.
        sensor: imperfections of the image.
        centres: (N, 1, 2) centres of the pixels.
        bed: (N, 3) light of the bed in each pixel.
        count: rays per pixel side.
    """
    hits = tracer.trace(rays(tracer.view.camera, centres + subpixel_offsets(count)))
    nozzle = np.isfinite(hits.nozzle_depth)
    behind = np.where(hits.ink.hit[..., None], _ink_colour(tracer, sensor, hits), bed[:, None])
    colour = np.where(nozzle[..., None], tracer.scene.nozzle.colour, behind)
    free_ink = (hits.ink.hit & ~nozzle).sum(axis=1) / np.maximum((~nozzle).sum(axis=1), 1)
    return PixelLight(colour.mean(axis=1), free_ink, nozzle.mean(axis=1))


def _measure_cloud(tracer: RayTracer, sensor: Sensor, hits: RayHits, image: NDArray[np.uint8],
                   rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the organized cloud (H, W, 3) [m] with its noise; NaN where a point is missing."""
    on_surface = tracer.scene.surface.intersect(tracer.eye, hits.in_surface, hits.ink.height)
    surface = on_surface.depth + sensor.ink_depth * hits.ink.hit
    z = np.fmin(surface, hits.nozzle_depth)[:, 0]
    z = z + rng.normal(0.0, 1.0, len(z)) * sensor.depth_noise * (z / DEPTH_NOISE_DISTANCE_M)**2
    rim = np.abs(hits.ink.margin[:, 0]) < _pixel_size(hits, tracer.view.camera)
    missing = rng.uniform(size=len(z)) < np.where(rim, sensor.rim_dropout, sensor.dropout)
    missing |= image.min(axis=2).ravel() >= SATURATED_LEVEL
    cloud = hits.directions[:, 0] * np.where(missing, np.nan, z)[:, None]
    return cloud.reshape(image.shape).astype(np.float32)
