"""The messages of robot and extruder of a simulated print."""

from __future__ import annotations

from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.config import BASE
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_sim.printer.print_job import PrintJob

EXTRUDER_RATE_HZ = 50.0  # of the extruder's states
CAMERA_LATENCY_NS = 120_000_000  # from the stamp of a capture to its messages


def robot_message(job: PrintJob, t: float, stamp_ns: int) -> PoseStamped:
    """Return the flange's pose at time t [s] of the job."""
    return pose_to_message(stamp_ns, BASE, job.flange_pose(t))


def extruder_message(job: PrintJob, t: float, stamp_ns: int) -> ExtrusionState:
    """Return the extruder's state at time t [s] of the job."""
    return ExtrusionState(
        header=Header(stamp=ns_to_stamp(stamp_ns)), extruding=bool(job.extruding(t)),
        plunger_velocity=float(job.plunger_velocity(t)),
        plunger_position=float(job.plunger_position(t)), flow_rate=float(job.flow_rate(t)))
