"""What the commands that work on a recording take, checked before anything is started."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bpc_perception.bag import Bag
from bpc_perception.core.config import flatten, RecorderConfig, ThicknessConfig
from bpc_perception.core.session import HandEye
from bpc_perception.handeye import load_hand_eye
from bpc_perception.outputs import Provenance, versions
from bpc_perception.parameter_files import configure

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
    def provenance(self) -> Provenance:
        """What the outputs say of where they come from."""
        settings = {name: value for name, _, value in flatten(self.thickness)}
        settings |= {f'path_recorder.{name}': value for name, _, value in flatten(self.recorder)}
        return Provenance(str(self.bag.path), str(self.hand_eye_file), settings, versions())


def check_out(folder: Path) -> None:
    """Raise ValueError unless outputs can go to this folder, made if missing."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise ValueError(f'{folder}: expected a folder for the outputs, '
                         f'found that {existing} is a file')


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
