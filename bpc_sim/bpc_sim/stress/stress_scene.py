"""A capture, the path of its print, and the truth about each sample of the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_sim.stress.truth import Categories

STAMP_NS = 10**12  # of every capture: any time after the print
NOZZLE_SPEED_M_PER_S = 3e-3


@dataclass(frozen=True, eq=False)
class StressScene:
    """A capture, the path of its print, and the truth; arrays of N samples.

    Attributes:
        name: name of the scene.
        capture: what the camera delivers.
        T_base_camera: (4, 4) pose of the camera's optical frame in the base frame.
        points: (N, 3) nozzle tip in the base frame [m].
        arc_length: (N,) arc length along these points, evenly spaced [m].
        thickness: (N,) true width of the pass [m], 0 in gaps; compared where MEASURED.
        expected: (N,) values of Truth.
        pixel: length of a pixel's side on the bed [m].
    """

    name: str
    capture: Capture
    T_base_camera: Array
    points: Array
    arc_length: Array
    thickness: Array
    expected: Categories
    pixel: float

    def __len__(self) -> int:
        return len(self.points)

    @property
    def path(self) -> DepositionPath:
        """The path as a recorder gives it; the extruder does not know of the gaps."""
        unknown = np.full(len(self), np.nan)
        return DepositionPath(
            self.name, 0, STAMP_NS * 1e-9, True, self.arc_length / NOZZLE_SPEED_M_PER_S,
            self.arc_length, self.points, unknown, unknown, np.ones(len(self), bool),
            np.ones(len(self), bool))
