"""A rig made of doubles that prints: what its camera sees, fixed beside the robot or in its hand.

A process that imports ``zivid`` gets this rig's camera if a package of that name calls
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

# How a process is told which rig it belongs to, and where a file says that the camera is there.
SCENARIO, SPEED, START, MOUNT, PLUG = (
    f'BPC_RIG_{name}' for name in ('SCENARIO', 'SPEED', 'START_NS', 'MOUNT', 'PLUG'))
SIZE = 560, 380  # of the image, so that the print stays in view of a camera in hand [pixels]


def in_hand() -> Array:
    """T_flange_camera (4, 4): beside the nozzle and a hand above its tip, looking at it."""
    eye, tip = np.array((0.0, -0.13, -0.15)), np.array((0.0, 0.0, 0.15))
    return look_at(eye, tip, np.array((1.0, 0.0, 0.0)))


@dataclass(frozen=True, eq=False)
class Rig:
    """A print, and a camera on one of the two mounts.

    Attributes:
        job: what is printed; its own view is that of a camera fixed beside the robot.
        on_base: which mount.
    """

    job: PrintJob
    on_base: bool

    @property
    def T_parent_camera(self) -> Array:
        """(4, 4) what a hand-eye calibration of this rig says."""
        return self.job.view.T_base_camera if self.on_base else in_hand()

    def seen_by_camera(self, t: float) -> PrintJob:
        """The print, with the view that the camera has of it at time t [s]."""
        if self.on_base:
            return self.job
        pose = self.job.flange_pose(t) @ in_hand()
        return replace(self.job, view=View(zivid_m70(*SIZE), pose))

    def see(self, start_ns: int) -> Callable[[float], Capture]:
        """What the camera sees at a time of time.time() [s], of a job that starts then."""
        def at(now: float) -> Capture:
            t = now - start_ns * 1e-9
            return self.seen_by_camera(t).capture(t, round(now * 1e3) % 10**6)

        return at


@dataclass
class PluggedByFile(ZividDouble):
    """A camera that is there as long as a file is."""

    file: str = ''

    def is_plugged(self) -> bool:
        """Whether the camera is there."""
        return Path(self.file).exists()


def install() -> None:
    """Put the double in place of the vendor's package, in this process."""
    rig = Rig(SCENARIOS[os.environ[SCENARIO]](float(os.environ[SPEED])),
              os.environ[MOUNT] == 'eye_on_base')
    double = PluggedByFile(rig.see(int(os.environ[START])), file=os.environ[PLUG])
    sys.modules.update(double.modules())
