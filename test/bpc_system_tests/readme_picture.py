"""Run as a program, draws docs/overlay.png, the picture in the README."""

from __future__ import annotations

from pathlib import Path

from bpc_perception.bag import Bag
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.profile import Status
from bpc_perception.core.session import Result
from bpc_perception.handeye import load_hand_eye
from bpc_perception.offline import measure_bag
from bpc_perception.parameter_files import configure
import cv2
import numpy as np

from bpc_perception import report

ROOT = Path(__file__).resolve().parents[2]
BAG = ROOT / 'bags' / 'spiral_gaps'
PICTURE = ROOT / 'docs' / 'overlay.png'
SCALE = 3
MARGIN = 10  # of the camera's image around the print [pixels]
SHIFT = 4  # OpenCV draws to 1/16 of a pixel


def measured() -> Result:
    """The last capture of the sample print."""
    parameters = BAG / 'params.yaml'
    *_, last = measure_bag(
        Bag(BAG), load_hand_eye(BAG / 'hand_eye.calib'),
        configure(ThicknessConfig(), 'thickness', parameters),
        configure(RecorderConfig(), 'path_recorder', parameters))
    return last


def draw(result: Result) -> np.ndarray:
    """The image in BGR, with side points where the thickness was measured, and the gaps."""
    profile = result.profile
    assert profile is not None
    picture = cv2.cvtColor(cv2.resize(result.capture.image, None, fx=SCALE, fy=SCALE,
                                      interpolation=cv2.INTER_NEAREST), cv2.COLOR_RGB2BGR)
    status = profile.status
    for points, chosen, colour in (
            (profile.left_points, status == Status.MEASURED, report.LEFT),
            (profile.right_points, status == Status.MEASURED, report.RIGHT),
            (profile.points, status == Status.GAP, report.COLOURS[Status.GAP])):
        blue_green_red = tuple(int(colour[i:i + 2], 16) for i in (5, 3, 1))
        uv = report.path_pixels(result, points[chosen])
        for u, v in (uv + 0.5) * SCALE - 0.5:
            centre = (round(u * 2**SHIFT), round(v * 2**SHIFT))
            cv2.circle(picture, centre, 3 << SHIFT, blue_green_red, -1, cv2.LINE_AA, SHIFT)
    path = report.path_pixels(result, profile.points)
    left, top = np.maximum(np.nanmin(path, axis=0).astype(int) - MARGIN, 0) * SCALE
    right, bottom = (np.nanmax(path, axis=0).astype(int) + MARGIN) * SCALE
    return picture[top:bottom, left:right]


if __name__ == '__main__':
    PICTURE.parent.mkdir(exist_ok=True)
    cv2.imwrite(str(PICTURE), draw(measured()), [cv2.IMWRITE_PNG_COMPRESSION, 9])
