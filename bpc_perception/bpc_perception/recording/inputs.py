"""Load a recording with its calibration and settings, before a command starts anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from bpc_perception.core.config import AdviceConfig, RecorderConfig, ThicknessConfig
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.targets import WidthTargets
from bpc_perception.files.design.read import G_CODE, TABLE
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure, name_other_sections
from bpc_perception.recording.bag import Bag

# Files of these names in the folder of a recording belong to it.
HAND_EYE, PARAMETERS, TARGETS = 'hand_eye.calib', 'params.yaml', 'targets.csv'
PRINT_ID = 'print_id.txt'  # of the print whose recording it is, if it is one of a single print
DESIGN = 'design'  # and the suffix of the file
DESIGNS = tuple(DESIGN + suffix for suffix in (TABLE, *G_CODE))
KEPT_BESIDE = (HAND_EYE, PARAMETERS, TARGETS, PRINT_ID, *DESIGNS)


@dataclass(frozen=True)
class Inputs:
    """A recording with its calibration and settings.

    Attributes:
        print_id: of the only print to measure; empty = all.
    """

    bag: Bag
    hand_eye_file: Path
    hand_eye: HandEye
    parameter_file: Path | None
    thickness: ThicknessConfig
    recorder: RecorderConfig
    print_id: str = ''

    @property
    def targets(self) -> WidthTargets | None:
        """The target thickness along the path; None = no target."""
        return targets_of(self.thickness.advice)


def kept_beside(hand_eye: str, parameters: str, design: str = '') -> dict[str, bytes]:
    """Return the files that are kept with a recording, by name there.

    Of files of the user, empty = none. With the parameters go the table that they name as
    ``advice.target_file`` and the design. Raises OSError, and what ``configure`` raises.
    """
    thickness = configure(ThicknessConfig(), 'thickness', parameters or None)
    design = design or thickness.design.file
    files = {HAND_EYE: hand_eye, PARAMETERS: parameters, TARGETS: thickness.advice.target_file,
             DESIGN + Path(design).suffix.lower(): design}
    return {name: Path(file).read_bytes() for name, file in files.items() if file}


def targets_of(advice: AdviceConfig) -> WidthTargets | None:
    """Return the target thickness along the path; None = no target. Raises OSError, ValueError."""
    table = WidthTargets.read(advice.target_file) if advice.target_file else None
    return WidthTargets.wanted(table, advice.target_thickness)


def load(bag: Path, hand_eye: Path | None, parameters: Path | None,
         others: Mapping[str, str] | None = None) -> Inputs:
    """Open a recording; without files given, take those in the folder of the recording.

    Other topics may be read in the place of some.

    The folder of a print stands for its recordings, of which each has the same files.

    Raises ValueError when something is missing or unfit.
    """
    opened = Bag(bag, others)
    folder = opened.files[0].parent
    hand_eye = hand_eye or folder / HAND_EYE
    if not hand_eye.exists() and hand_eye.parent == folder:
        raise ValueError(f'hand-eye calibration: expected --handeye FILE or {folder / HAND_EYE}, '
                         'found neither; "bpc calibrate handeye" makes one')
    if not hand_eye.exists():
        raise ValueError(f'hand-eye calibration: expected {hand_eye}, found nothing there'
                         '; name the right file with --handeye')
    own = parameters is None and (folder / PARAMETERS).exists()
    if own:
        parameters = folder / PARAMETERS
    thickness = configure(ThicknessConfig(), 'thickness', parameters)
    name_other_sections(parameters)
    targets = folder / TARGETS
    if own and targets.is_file():  # the table may have been moved or changed since
        thickness = replace(thickness, advice=replace(thickness.advice, target_file=str(targets)))
    design = next((folder / name for name in DESIGNS if (folder / name).is_file()), None)
    if design is not None and (own or parameters is None):
        thickness = replace(thickness, design=replace(thickness.design, file=str(design)))
    name = folder / PRINT_ID
    return Inputs(opened, hand_eye, load_hand_eye(hand_eye), parameters,
                  thickness, configure(RecorderConfig(), 'path_recorder', parameters),
                  name.read_text('utf-8').strip() if name.is_file() else '')
