"""A rig of device doubles that prints, with its camera beside the robot or in its hand.

A process that imports ``zivid`` gets the camera of this rig if a package of that name calls
:func:`install`; see ``test/bpc_system_tests/prints/test_rig.py``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
import os
from pathlib import Path
import sys

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_sim.doubles.zivid import ZividDouble
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_sim.scene.camera import look_at, View, zivid_m70

# Environment variables that tell a process which rig it belongs to.
SCENARIO_VARIABLE = 'BPC_RIG_SCENARIO'
SPEED_VARIABLE = 'BPC_RIG_SPEED'
START_VARIABLE = 'BPC_RIG_START_NS'
MOUNT_VARIABLE = 'BPC_RIG_MOUNT'
PLUG_VARIABLE = 'BPC_RIG_PLUG'  # names the file that exists while the camera is plugged in
# Large enough for the print to stay in view of a camera in the hand.
HAND_IMAGE_SIZE_PX = 560, 380


def hand_camera_pose() -> Array:
    """Return T_flange_camera (4, 4): beside the nozzle, above its tip, looking at the tip."""
    eye, tip = np.array((0.0, -0.13, -0.15)), np.array((0.0, 0.0, 0.15))
    return look_at(eye, tip, np.array((1.0, 0.0, 0.0)))


@dataclass(frozen=True, eq=False)
class Rig:
    """A print, and a camera on one of the two mounts.

    Attributes:
        job: the print; its own view is that of a camera fixed beside the robot.
        on_base: whether the camera is fixed beside the robot; otherwise it is in the hand.
    """

    job: PrintJob
    on_base: bool

    @property
    def T_parent_camera(self) -> Array:
        """Pose (4, 4) of the camera in base or flange, as a hand-eye calibration says."""
        return self.job.view.T_base_camera if self.on_base else hand_camera_pose()

    def seen_by_camera(self, t: float) -> PrintJob:
        """Return the print with the view that the camera has at time t [s]."""
        if self.on_base:
            return self.job
        pose = self.job.flange_pose(t) @ hand_camera_pose()
        return replace(self.job, view=View(zivid_m70(*HAND_IMAGE_SIZE_PX), pose))

    def see(self, start_ns: int) -> Callable[[float], Capture]:
        """Return what the camera sees of a job that starts at a time [ns].

        The result takes a time of time.time() [s].
        """
        def at(now: float) -> Capture:
            t = now - start_ns * 1e-9
            return self.seen_by_camera(t).capture(t, round(now * 1e3) % 10**6)

        return at


@dataclass
class PluggedByFile(ZividDouble):
    """A camera that is plugged in as long as a file exists."""

    file: str = ''

    def is_plugged(self) -> bool:
        """Tell whether the file exists."""
        return Path(self.file).exists()


def install() -> None:
    """Put the double in place of the vendor's package in this process."""
    rig = Rig(SCENARIOS[os.environ[SCENARIO_VARIABLE]](float(os.environ[SPEED_VARIABLE])),
              os.environ[MOUNT_VARIABLE] == 'eye_on_base')
    double = PluggedByFile(rig.see(int(os.environ[START_VARIABLE])),
                           file=os.environ[PLUG_VARIABLE])
    sys.modules.update(double.modules())
