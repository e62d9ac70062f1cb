"""What the commands that work on a recording take, checked before anything is started."""

from __future__ import annotations

from dataclasses import dataclass
import hashlib
from importlib.util import find_spec
import json
from pathlib import Path

from bpc_perception.bag import Bag
from bpc_perception.core.config import flatten, RecorderConfig, ThicknessConfig
from bpc_perception.core.session import HandEye
from bpc_perception.core.targets import WidthTargets
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
        found = versions()
        return Provenance(str(self.bag.path), str(self.hand_eye_file), settings, found,
                          self.targets, fingerprint(self, settings, found))

    @property
    def targets(self) -> WidthTargets | None:
        """The thickness wanted along the path; None = none."""
        advice = self.thickness.advice
        if advice.target_file:
            return WidthTargets.read(advice.target_file)
        return WidthTargets.constant(advice.target_thickness) if advice.target_thickness else None


def fingerprint(given: Inputs, settings: dict[str, object], found: dict[str, str]) -> str:
    """Tells whether a result is made of the same: recording, calibration, settings, versions.

    Of a recording names, sizes and times of change are looked at, as make and rsync do; of the
    small files their content.
    """
    told = hashlib.sha256(json.dumps([settings, found], sort_keys=True, default=str).encode())
    for file in given.bag.files:
        state = file.stat()
        told.update(f'{file.name} {state.st_size} {state.st_mtime_ns}'.encode(errors='replace'))
    targets = given.thickness.advice.target_file
    for small in (given.hand_eye_file, *([Path(targets)] if targets else [])):
        told.update(small.read_bytes())
    return told.hexdigest()


def check_figures(wanted: bool) -> None:
    """Raise ValueError if figures are wanted and there is nothing to draw them."""
    if wanted and find_spec('matplotlib') is None:
        raise ValueError('--figures: expected the package matplotlib, found none')


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
