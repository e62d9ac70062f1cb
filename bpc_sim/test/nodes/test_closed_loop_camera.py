"""The camera of the closed loop follows the robot along its path."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bpc_interfaces.msg import ExtrusionState
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.nodes.closed_loop_camera import ClosedLoopCamera
from bpc_sim.printer.messages import robot_message

pytestmark = pytest.mark.ros
SPEED_M_PER_S = 0.006


@pytest.mark.parametrize('held_up', [2.0, 4.0, 6.0, 8.0, 10.0, 12.0])
def test_a_robot_whose_poses_were_held_up_at_a_corner_is_found_again(held_up: float) -> None:
    print_ = ClosedLoopJob.named('under_delivery', 0, SPEED_M_PER_S)
    node: Any = SimpleNamespace(create_subscription=lambda *_: None)
    camera = ClosedLoopCamera(node, print_)
    camera._on_extruder(ExtrusionState(extruding=True, flow_rate=1e-8))
    for time in np.arange(1.0, 20.0, 0.02):
        if not held_up < time < held_up + 0.9:
            job_time = print_.job.dwell_before + time
            camera._on_pose(robot_message(print_.job, job_time, round(time * 1e9)))
    assert camera._s == pytest.approx(print_.job.laid(print_.job.dwell_before + time), abs=2e-4)
