"""Run as a program, draws docs/overlay.png, the picture in the README."""

from __future__ import annotations

from pathlib import Path

from bpc_perception.bag import Bag
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.session import Result
from bpc_perception.handeye import load_hand_eye
from bpc_perception.offline import measure_bag
from bpc_perception.overlay import draw_overlay
from bpc_perception.parameter_files import configure
import cv2

ROOT = Path(__file__).resolve().parents[2]
BAG = ROOT / 'bags' / 'spiral_gaps'
PICTURE = ROOT / 'docs' / 'overlay.png'


def measured() -> Result:
    """The last capture of the sample print."""
    parameters = BAG / 'params.yaml'
    *_, last = measure_bag(
        Bag(BAG), load_hand_eye(BAG / 'hand_eye.calib'),
        configure(ThicknessConfig(), 'thickness', parameters),
        configure(RecorderConfig(), 'path_recorder', parameters))
    return last


if __name__ == '__main__':
    PICTURE.parent.mkdir(exist_ok=True)
    picture = draw_overlay(measured()) & 0xF0  # fewer colours, a smaller file
    cv2.imwrite(str(PICTURE), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR),
                [cv2.IMWRITE_PNG_COMPRESSION, 9])
