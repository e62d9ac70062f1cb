"""What prints in an open and in a closed loop share: files for the nodes, and times."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
import time

import yaml

from bpc_perception.cli.parts.monitor import Monitor
from bpc_perception.cli.parts.saved_prints import SavedPrints
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.display.units import MM_PER_M, S_PER_NS
from bpc_perception.messages import topics
from bpc_perception.runtime.child_processes import Nodes

START_DELAY_S = 6.0  # in which all nodes find each other
START_TIMEOUT_S = 60.0  # for the nodes, on a busy machine
END_MARGIN_S = 10.0  # for the last results


@dataclass(frozen=True)
class Settings:
    """Files for the nodes.

    Attributes:
        parameters: ROS parameter file.
        hand_eye: hand-eye calibration.
    """

    parameters: Path
    hand_eye: Path


def write_settings(folder: Path, hand_eye: dict[str, object],
                   parameters: dict[str, object]) -> Settings:
    """Write calibration and parameters into a folder."""
    settings = Settings(folder / 'params.yaml', folder / 'hand_eye.calib')
    settings.hand_eye.write_text(yaml.safe_dump(hand_eye))
    settings.parameters.write_text(yaml.safe_dump(parameters))
    return settings


def saved_print(prints: Path | None, settings: Settings) -> SavedPrints | None:
    """Return what is needed to keep a print in a folder of prints; None = it is not kept."""
    if prints is None:
        return None
    return SavedPrints(prints, settings.hand_eye, settings.parameters)


def announce(length: float, speed: float, end_ns: int, terminal: Terminal) -> None:
    """Say how long it takes until the last capture of a print.

    Args:
        length: of the path [m].
        speed: of the nozzle along it [m/s].
        end_ns: when that capture is taken [ns].
        terminal: of the command.
    """
    left = (end_ns - time.time_ns()) * S_PER_NS
    terminal.say(f'{length * MM_PER_M:.0f} mm at {speed * MM_PER_M:g} mm/s: done in {left:.0f} s; '
                 'Ctrl-C ends it before.')


def reasons(monitor: Monitor) -> str:
    """Return what the nodes said about why there is no result."""
    return '; '.join(monitor.warnings) or 'the nodes gave no reason'


def wait_for_recorders(monitor: Monitor, nodes: Nodes, prints: Path | None) -> None:
    """Wait until those who keep poses and states listen: path recorder, and bag recorder if any.

    What a robot says before they do is in neither path nor recording.

    Raises:
        ValueError: one does not start in time.
    """
    expected = 1 if prints is None else 2
    if not monitor.spin_until(lambda: all(monitor.subscribers(name) >= expected
                                          for name in (topics.POSE, topics.EXTRUSION)),
                              START_TIMEOUT_S, nodes.check):
        raise ValueError('expected the recorders of path and print to start, found one that did '
                         f'not; {reasons(monitor)}')
