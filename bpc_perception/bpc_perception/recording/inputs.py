"""What the commands that work on a recording take, checked before anything is started."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure
from bpc_perception.recording.bag import Bag

# Files of these names beside a recording belong to it.
HAND_EYE, PARAMETERS = 'hand_eye.calib', 'params.yaml'


@dataclass(frozen=True)
class Inputs:
    """A recording with its calibration and settings."""

    bag: Bag
    hand_eye_file: Path
    hand_eye: HandEye
    parameter_file: Path | None
    thickness: ThicknessConfig
    recorder: RecorderConfig

    @property
    def targets(self) -> WidthTargets | None:
        """The thickness wanted along the path; None = none."""
        advice = self.thickness.advice
        if advice.target_file:
            return WidthTargets.read(advice.target_file)
        return WidthTargets.constant(advice.target_thickness) if advice.target_thickness else None


def load(bag: Path, hand_eye: Path | None, parameters: Path | None) -> Inputs:
    """Open a recording; its calibration and parameters lie beside it unless named.

    Raises ValueError for whatever is missing or unfit.
    """
    opened = Bag(bag)
    folder = bag if bag.is_dir() else bag.parent
    hand_eye = hand_eye or folder / HAND_EYE
    if not hand_eye.exists():
        raise ValueError(f'hand-eye calibration: expected --handeye FILE or {folder / HAND_EYE}, '
                         'found neither' if hand_eye.parent == folder else
                         f'hand-eye calibration: expected {hand_eye}, found nothing there')
    beside = folder / PARAMETERS
    parameters = parameters or (beside if beside.exists() else None)
    return Inputs(opened, hand_eye, load_hand_eye(hand_eye), parameters,
                  configure(ThicknessConfig(), 'thickness', parameters),
                  configure(RecorderConfig(), 'path_recorder', parameters))
