"""Ray-traced pictures kept in files: image and depth; everything else follows from the scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_sim.raytraced.spec import RaytracedScene
from bpc_sim.scene.camera import pixel_rays
from bpc_sim.stress.stress_scene import STAMP_NS

FOLDER = Path(__file__).with_name('crops')
DEPTH_STEP_M = 5e-6  # a ninth of the noise of a point
FRAME = 'camera_optical_frame'
NEAREST_M = 0.15  # depth of level 1; 0 = no point


def save(folder: Path, scene: RaytracedScene, image: NDArray[np.uint8], depth: Array) -> Path:
    """Write image (H, W, 3) and depth (H, W) [m], without loss of an image level.

    Raises:
        FileExistsError: there is such a file already.
    """
    level = np.rint((depth - NEAREST_M) / DEPTH_STEP_M) + 1
    level = np.where(np.isfinite(level), level, 0).astype(np.uint16)
    file = folder / f'{scene.name}.npz'
    with file.open('xb') as stream:
        np.savez(stream, image=_png(image[..., ::-1]), depth=_png(level))
    return file


def load(scene: RaytracedScene, folder: Path = FOLDER) -> Capture:
    """Return the capture of a scene.

    Raises:
        FileNotFoundError: it was not traced.
    """
    with np.load(folder / f'{scene.name}.npz') as kept:
        image = _picture(kept['image'])[..., ::-1].copy()
        level = _picture(kept['depth']).astype(float)
    depth = np.where(level > 0, NEAREST_M + (level - 1) * DEPTH_STEP_M, np.nan)
    camera = scene.view.camera
    cloud = (pixel_rays(camera) * depth[..., None]).astype(np.float32)
    return Capture(STAMP_NS, FRAME, image, cloud, camera)


def _png(picture: NDArray[Any]) -> NDArray[np.uint8]:
    _, encoded = cv2.imencode('.png', picture, (cv2.IMWRITE_PNG_COMPRESSION, 9))
    return np.asarray(encoded, np.uint8)


def _picture(encoded: NDArray[np.uint8]) -> NDArray[Any]:
    return np.asarray(cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED))
