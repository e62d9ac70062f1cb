"""One print that was measured: read from its result, or measured from its recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.geometry import transform
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.core.targets import WidthTargets
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import capture_count
from bpc_perception.recording.offline import measure_bag
from bpc_perception.report.profile_table import read_profile, read_wanted
from bpc_perception.report.result_folder import expect_summary, SUMMARY


@dataclass(frozen=True)
class MeasuredPrint:
    """A print that was measured.

    Attributes:
        profile: of it.
        targets: the width that was wanted along the path; None = none.
        cloud: (M, 3) points of its last capture in the base frame [m]; None = not at hand.
    """

    profile: ThicknessProfile
    targets: WidthTargets | None
    cloud: Array | None = None

    @property
    def target(self) -> Array | None:
        """The width (N,) that was wanted at each sample [m]; None = none."""
        return None if self.targets is None else self.targets.at(self.profile.arc_length)


def read_result(folder: Path, number: int | None) -> MeasuredPrint:
    """Return a print whose result lies in a folder.

    Args:
        folder: as ``measure`` or ``live`` writes it.
        number: of the print where there are several, from 1; None = there is but one.

    Raises:
        OSError: a file cannot be read.
        ValueError: it is not such a folder; the message names what was expected and found.
    """
    summary = expect_summary(folder)
    prints = summary.get('prints') or []
    place = _chosen(folder, len(prints) or 1, number)
    if prints:
        folder = folder / f'print_{place + 1}'
    others = _targets(folder, summary.get('settings') or {})
    print_id = (prints[place] if prints else summary).get('print_id')
    file = folder / 'profile.csv'
    profile = read_profile(file, str(print_id or ''))
    wanted = read_wanted(file)
    if wanted is None or np.isnan(wanted).all():
        return MeasuredPrint(profile, others)
    return MeasuredPrint(profile, WidthTargets.told(profile.arc_length, wanted, others))


def _targets(folder: Path, settings: Mapping[str, Any]) -> WidthTargets | None:
    """Return the target with which a result was made. Raises OSError, ValueError."""
    known = {name: settings[f'advice.{name}'] for name in ('target_file', 'target_thickness')
             if f'advice.{name}' in settings}
    try:
        return inputs.targets_of(replace(AdviceConfig(), **known))
    except TypeError as error:
        raise ValueError(f'{folder / SUMMARY}: expected the settings of a result, found: {error}'
                         '; measure it again') from error


def _chosen(where: Path, count: int, number: int | None) -> int:
    """Return the index of the print that is wanted; ValueError = there is no such."""
    if number is None and count != 1:
        raise ValueError(f'{where}: expected one print, found {count}'
                         '; choose one with --print')
    if number is not None and number > count:
        raise ValueError(f'{where}: expected print {number}, found {count}'
                         '; choose one of these with --print')
    return (number or 1) - 1


def measure_print(recording: inputs.Inputs, number: int | None,
                  terminal: Terminal) -> MeasuredPrint:
    """Measure a recording, and return a print of it as its last capture shows it.

    Raises ValueError if there is none, or not the one that is wanted.
    """
    last: dict[str, Result] = {}
    refusals: set[str] = set()
    with terminal.progress('measure', capture_count(recording.bag)) as advance:
        for result in measure_bag(recording.bag, recording.hand_eye, recording.thickness,
                                  recording.recorder, recording.print_id):
            if result.profile is not None:
                last[result.profile.print_id] = result
            else:
                refusals.add(result.refusal)
            advance()
    if not last:
        raise ValueError(f'{recording.bag.path}: expected a capture that can be measured, found: '
                         f'{"; ".join(sorted(refusals)) or "no capture"}')
    result = list(last.values())[_chosen(recording.bag.path, len(last), number)]
    assert result.profile is not None
    targets = (recording.targets if result.design is None else
               result.design.targets(result.profile.arc_length, recording.targets))
    return MeasuredPrint(result.profile, targets, _cloud(result))


def _cloud(result: Result) -> Array | None:
    """Return the points (M, 3) of a capture in the base frame [m]."""
    if result.T_base_camera is None:
        return None
    points = result.capture.cloud.reshape(-1, 3).astype(float)
    return transform(result.T_base_camera, points[np.isfinite(points).all(axis=1)])
