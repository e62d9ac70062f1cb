"""Robot and extruder of a print whose rate is corrected while it runs."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from std_msgs.msg import Float64, Header

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.messages import topics
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.run import run
from bpc_sim.closed_loop.controllers import FLOW_SCALE, SPEED_SCALE
from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.config import SimConfig
from bpc_sim.printer.messages import robot_message
from bpc_sim.printer.print_job import PLUNGER_AREA_M2

POSES_PER_EXTRUDER_STATE = 2
KILL_SWITCH_ACTIVE = 1 << 4  # error status of a Tic


class SyntheticPrinterNode(Node):
    """Follows its program at the nominal rate times the factors; see docs/reference/nodes."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('synthetic_printer', **kwargs)
        config = NodeConfig(self, SimConfig()).value
        self._print: ClosedLoopJob = config.closed_loop_job()
        self._start_ns = config.start_time_ns
        self._diagnostics = Diagnostics(self)
        self._scales = {FLOW_SCALE: 1.0, SPEED_SCALE: 1.0}
        for name in self._scales:
            self.create_subscription(Float64, name, self._follow(name), topics.RESULT_QOS)
        # A reliable publisher also serves subscribers that ask for best effort.
        self._poses = self.create_publisher(PoseStamped, topics.POSE, topics.EXTRUSION_QOS)
        self._states = self.create_publisher(
            ExtrusionState, topics.EXTRUSION, topics.EXTRUSION_QOS)
        self._last_ns = self._now_ns()
        # Time of the job [s]. A job whose start is past begins with this node.
        self._time = min((self._last_ns - self._start_ns) * 1e-9, 0.0)
        self._plunger_position = 0.0  # [m]
        self._ticks = 0
        self.create_timer(1.0 / config.pose_rate, self._tick)

    def _follow(self, name: str) -> Any:
        """Return a callback that takes the factor on the topic of this name."""
        def take(message: Float64) -> None:
            if math.isfinite(message.data) and message.data >= 0:
                self._scales[name] = message.data
            else:
                self._diagnostics.refuse(
                    f'{name}: expected a factor of at least 0, found {message.data}')
        return take

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)

    def _tick(self) -> None:
        now_ns = self._now_ns()
        elapsed, self._last_ns = (now_ns - self._last_ns) * 1e-9, now_ns
        job = self._print.job
        s = float(job.laid(self._time))
        extruding = bool(job.extruding(self._time))
        lost = s >= self._print.situation.extruder_lost
        pushing = extruding and not lost
        flow = self._print.flow(s) * self._scales[FLOW_SCALE] if pushing else 0.0
        # Before and after its path the robot waits in real time.
        self._time += elapsed * (
            self._print.speed(s) * self._scales[SPEED_SCALE] / job.speed if extruding else 1.0)
        self._plunger_position += flow / PLUNGER_AREA_M2 * elapsed
        self._poses.publish(robot_message(job, self._time, now_ns))
        self._ticks += 1
        if self._ticks % POSES_PER_EXTRUDER_STATE == 0:
            self._states.publish(ExtrusionState(
                header=Header(stamp=ns_to_stamp(now_ns)), extruding=pushing,
                plunger_velocity=flow / PLUNGER_AREA_M2, plunger_position=self._plunger_position,
                flow_rate=flow, error_status=KILL_SWITCH_ACTIVE if lost else 0))


def main() -> None:
    """Run the node."""
    run(SyntheticPrinterNode)


if __name__ == '__main__':
    main()
