"""What the commands share: the poses in a recording, and doubts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import RecorderConfig
from bpc_perception.files.parameter_file import configure
from bpc_perception.recording import inputs
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.contents import flange_poses


def recorded_poses(bag: Bag, parameters: Path | None) -> tuple[NDArray[np.int64], Array]:
    """Return the flange poses in a recording; the parameters say where they come from.

    Args:
        bag: the recording.
        parameters: file for the nodes; None = the one beside the recording, if any.

    Returns:
        (N,) stamps [ns] and (N, 4, 4) poses T_base_flange.
    """
    beside = bag.files[0].parent / inputs.PARAMETERS
    config = configure(RecorderConfig(), 'path_recorder',
                       parameters or (beside if beside.exists() else None))
    return flange_poses(bag, config.pose, config.base_frame)


def emit_doubt(terminal: Terminal, text: str) -> None:
    """Show why a result is doubtful."""
    terminal.emit('doubt', f'WARN {text}', text=text)
