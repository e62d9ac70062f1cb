"""Trace scenes into files."""

from __future__ import annotations

from pathlib import Path

from bpc_sim.raytraced.camera_noise import depth_seen, exposed
from bpc_sim.raytraced.crops import save
from bpc_sim.raytraced.spec import RaytracedScene
from bpc_sim.raytraced.tracer import trace


def make(folder: Path, scene: RaytracedScene) -> Path:
    """Trace a scene, and keep what a camera makes of it."""
    traced = trace(scene)
    image = exposed(scene, traced.light)
    depth = depth_seen(scene, traced.depth, traced.cosine, traced.on_ink, image)
    return save(folder, scene, image, depth)
