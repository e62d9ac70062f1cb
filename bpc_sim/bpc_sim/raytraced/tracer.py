"""The picture and the depth of a scene, by the ray tracer Mitsuba 3, an extra.

Several passes are rendered, and the brightest left out pixel by pixel: single paths of light that
no camera sees make single pixels glow.
"""

from __future__ import annotations

from dataclasses import dataclass
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_sim.printer.scenarios import bed_pose
from bpc_sim.raytraced import beds
from bpc_sim.raytraced.bead_mesh import bead_meshes, Mesh
from bpc_sim.raytraced.looks import Bed, Lamp
from bpc_sim.raytraced.spec import DISTANCE_M, RaytracedScene
from bpc_sim.scene.camera import pixel_rays

PASSES, KEPT = 6, 4
SAMPLES = 48  # of a pixel in each pass
TRANSLUCENT_SAMPLES = 320
TRANSLUCENT_LAMPS = 6.0  # times larger
LEAST_INK_M = 1e-5  # above the bed
FOCUS_SHARE = 0.8  # of the distance at which a camera out of focus is sharp
LLVM_LIBRARIES = ('/usr/lib/x86_64-linux-gnu/libLLVM-19.so',
                  '/usr/lib/llvm-19/lib/libLLVM.so', '/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1')


def load_tracer() -> Any:
    """Return the module mitsuba, ready to render.

    Raises:
        ValueError: it is not installed.
    """
    if 'DRJIT_LIBLLVM_PATH' not in os.environ:
        found = next((path for path in LLVM_LIBRARIES if Path(path).exists()), None)
        if found is not None:
            os.environ['DRJIT_LIBLLVM_PATH'] = found
    try:
        import mitsuba
    except ImportError as error:
        raise ValueError(
            'ray tracer: expected the package mitsuba, found none; install it with '
            'pip install mitsuba==3.9.0, and the library LLVM 19 (Debian: libllvm19)') from error
    mitsuba.set_variant('llvm_ad_rgb')
    return mitsuba


@dataclass(frozen=True)
class Traced:
    """What the light of a scene shows, pixel by pixel.

    Attributes:
        light: (H, W, 3) linear.
        depth: (H, W) along the optical axis [m]; NaN where nothing is.
        cosine: (H, W) between view and surface.
        on_ink: (H, W) whether the surface is that of ink.
    """

    light: Array
    depth: Array
    cosine: Array
    on_ink: NDArray[np.bool_]


def trace(scene: RaytracedScene) -> Traced:
    """Trace a scene.

    Raises:
        ValueError: there is no ray tracer.
    """
    mi = load_tracer()
    made = mi.load_dict(_described(mi, scene))
    samples = TRANSLUCENT_SAMPLES if scene.ink.translucent else SAMPLES
    passes = np.stack([np.array(mi.render(made, spp=samples, seed=number))[..., :3]
                       for number in range(PASSES)])
    order = np.argsort(passes.sum(axis=-1), axis=0)[:KEPT]
    light = np.take_along_axis(passes, order[..., None], axis=0).mean(axis=0)
    return Traced(light.astype(float), *_surface(mi, made, scene))


def _surface(mi: Any, made: Any,
             scene: RaytracedScene) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return depth, cosine and whether it is ink, where rays first meet something."""
    view, camera = scene.view, scene.view.camera
    directions = pixel_rays(camera)
    length = np.linalg.norm(directions, axis=-1)
    ways = directions / length[..., None] @ view.T_base_camera[:3, :3].T
    eye = view.T_base_camera[:3, 3]
    hit = made.ray_intersect(mi.Ray3f(
        mi.Point3f(*(np.full(ways[..., 0].size, part, np.float32) for part in eye)),
        mi.Vector3f(*ways.reshape(-1, 3).T.astype(np.float32))))
    shape = ways.shape[:2]
    depth = np.where(np.array(hit.is_valid()), np.array(hit.t, float), np.nan).reshape(shape)
    normal = np.array(hit.n, float).reshape(3, -1).T.reshape(*shape, 3)
    place = eye + depth[..., None] * ways
    height = (place - bed_pose()[:3, 3]) @ bed_pose()[:3, 2]
    return depth / length, np.abs((normal * ways).sum(axis=-1)), height > LEAST_INK_M


def _described(mi: Any, scene: RaytracedScene) -> dict[str, Any]:
    """Return the scene as the tracer wants it, in the base frame [m]."""
    T = bed_pose()
    described: dict[str, Any] = {
        'type': 'scene',
        'integrator': {'type': 'volpath' if scene.ink.translucent else 'path',
                       'max_depth': 64 if scene.ink.translucent else 8},
        'sensor': _sensor(mi, scene),
        'bed': {'type': 'rectangle',
                'to_world': mi.ScalarTransform4f(T) @ mi.ScalarTransform4f().scale(
                    [beds.WIDTH_M / 2, beds.WIDTH_M / 2, 1.0]),
                'bsdf': _bed_material(mi, scene)},
        **_lights(mi, scene, T)}
    ink = _ink_material(scene)
    for number, mesh in enumerate(bead_meshes(scene.deposit, scene.section)):
        described[f'bead{number}'] = _mesh(mi, Mesh(transform(T, mesh.vertices), mesh.faces), ink)
    return described


def _sensor(mi: Any, scene: RaytracedScene) -> dict[str, Any]:
    camera, pose = scene.view.camera, scene.view.T_base_camera.copy()
    pose[:3, :2] *= -1  # the tracer's camera has x to the left and y up
    sensor: dict[str, Any] = {
        'type': 'perspective', 'to_world': mi.ScalarTransform4f(pose), 'fov_axis': 'x',
        'fov': float(np.degrees(2 * np.arctan(camera.width / (2 * camera.focal_length)))),
        'near_clip': 0.01, 'far_clip': 10.0,
        'film': {'type': 'hdrfilm', 'width': camera.width, 'height': camera.height,
                 'rfilter': {'type': 'box'}, 'pixel_format': 'rgb',
                 'component_format': 'float32'},
        'sampler': {'type': 'independent'}}
    if scene.defocus_px:
        near = FOCUS_SHARE * DISTANCE_M
        blur = camera.focal_length * (1 / near - 1 / DISTANCE_M)  # pixels per aperture radius
        sensor |= {'type': 'thinlens', 'focus_distance': near,
                   'aperture_radius': float(scene.defocus_px / blur)}
    return sensor


def _mesh(mi: Any, mesh: Mesh, bsdf: dict[str, Any]) -> Any:
    """Return a mesh with its material, shaded smoothly."""
    properties = mi.Properties()
    if bsdf['type'] == 'roughdielectric':
        bsdf = dict(bsdf)
        properties['interior'] = mi.load_dict(bsdf.pop('interior'))
    properties['bsdf'] = mi.load_dict(bsdf)
    made = mi.Mesh('bead', len(mesh.vertices), len(mesh.faces), props=properties,
                   has_vertex_normals=False)
    parameters = mi.traverse(made)
    parameters['vertex_positions'] = mesh.vertices.astype(np.float32).ravel()
    parameters['faces'] = mesh.faces.ravel()
    parameters.update()
    return made


def _ink_material(scene: RaytracedScene) -> dict[str, Any]:
    ink = scene.ink
    if ink.translucent:
        return {'type': 'roughdielectric', 'int_ior': 1.34, 'ext_ior': 1.0,
                'alpha': ink.roughness, 'distribution': 'ggx',
                'interior': {'type': 'homogeneous', 'sigma_t': ink.extinction,
                             'albedo': {'type': 'rgb', 'value': list(ink.colour)}}}
    return {'type': 'twosided', 'material': {
        'type': 'principled', 'base_color': {'type': 'rgb', 'value': list(ink.colour)},
        'roughness': ink.roughness, 'specular': 0.5, 'clearcoat': 0.6,
        'clearcoat_gloss': 0.9}}


def _bed_material(mi: Any, scene: RaytracedScene) -> dict[str, Any]:
    picture = beds.PICTURES[scene.bed](scene.rng('bed')).astype(np.float32)
    return {'type': 'twosided', 'material': {
        'type': 'principled', 'roughness': beds.ROUGHNESS[scene.bed],
        'specular': beds.SPECULAR[scene.bed],
        'metallic': 0.8 if scene.bed is Bed.METAL else 0.0,
        'base_color': {'type': 'bitmap', 'bitmap': mi.Bitmap(picture), 'raw': True}}}


def _lights(mi: Any, scene: RaytracedScene, T: NDArray[np.float64]) -> dict[str, Any]:
    """Return the room, the camera's projector beside its lens, and the lamp."""
    # Light through a surface finds a small lamp too seldom.
    larger = TRANSLUCENT_LAMPS if scene.ink.translucent else 1.0

    def patch(place: tuple[float, float, float], size: tuple[float, float],
              power: float) -> dict[str, Any]:
        size = larger * size[0], larger * size[1]
        origin = transform(T, np.array(place))
        towards = mi.ScalarTransform4f().look_at(
            origin=origin.tolist(), target=T[:3, 3].tolist(), up=T[:3, 1].tolist())
        return {'type': 'rectangle',
                'to_world': towards @ mi.ScalarTransform4f().scale([*size, 1.0]),
                'emitter': {'type': 'area', 'radiance': {
                    'type': 'rgb', 'value': power / (size[0] * size[1])}}}

    eye = transform(invert(T), scene.view.T_base_camera[:3, 3])
    angle = scene.rng('lamp').uniform(-np.pi, np.pi)
    lights = {
        'room': {'type': 'constant', 'radiance': {'type': 'rgb', 'value': 0.35}},
        'projector': patch((float(eye[0]) + 0.05, float(eye[1]) + 0.02, float(eye[2])),
                           (0.008, 0.008), 0.014)}
    if scene.lamp is Lamp.TUBE:
        lights['tube'] = patch((0.15 * np.cos(angle), 0.15 * np.sin(angle), 0.45),
                               (0.012, 0.3), 0.03)
    if scene.lamp is Lamp.SPOT:
        lights['spot'] = patch((0.35 * np.cos(angle), 0.35 * np.sin(angle), 0.25),
                               (0.015, 0.015), 0.04)
    return lights
