"""Names, types and quality of service of all topics of bpc; names are relative."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from bpc_interfaces.msg import (
    DepositionPath,
    DesignComparison,
    ExtrusionState,
    PrintVerdict,
    RateAdvice,
    RateSchedule,
    RepairPlan,
    ThicknessProfile,
    ThicknessProfileUpdate,
)

IMAGE, CAMERA_INFO, CLOUD = 'color/image_color', 'color/camera_info', 'points/xyzrgba'
CAMERA: dict[str, Any] = {IMAGE: Image, CAMERA_INFO: CameraInfo, CLOUD: PointCloud2}
SNR = 'snr/image'  # optional, Image
POSE, EXTRUSION = 'end_effector_pose', 'extrusion_state'
PRINT: dict[str, Any] = {POSE: PoseStamped, EXTRUSION: ExtrusionState}
# Other sources of the flange's pose; one of them may replace POSE.
JOINTS, LBR_STATE = 'joint_states', 'lbr_state'
ROBOT: dict[str, Any] = {POSE: PoseStamped, JOINTS: JointState}  # types that are always installed
POSES = *ROBOT, LBR_STATE
# States of other extruders.
PLUNGER, EXTRUDING = 'plunger_joint_states', 'extruding'
PATH, NAV_PATH = 'deposition_path', 'deposition_path/nav'
PATH_UPDATE = 'deposition_path/update'  # what is new in PATH; not recorded
PROFILE, ADVICE, VERDICT = 'thickness_profile', 'rate_advice', 'print_verdict'
DESIGN = 'design_comparison'  # only where the thickness node has a design
REPAIR = 'repair_plan'
SCHEDULE = 'rate_schedule'  # of the layer that is printed, or the next
PROFILE_UPDATE = 'thickness_profile/update'  # what changed in a long PROFILE
SEND_PROFILE = 'thickness/send_profile'  # service: publish the whole
MARKERS, OVERLAY = 'thickness/markers', 'thickness/overlay'
WIDTH, DEVIATION = 'thickness/width', 'thickness/deviation'
RESULTS: dict[str, Any] = {PATH: DepositionPath, NAV_PATH: Path, PROFILE: ThicknessProfile,
                           PROFILE_UPDATE: ThicknessProfileUpdate, ADVICE: RateAdvice,
                           VERDICT: PrintVerdict, DESIGN: DesignComparison, REPAIR: RepairPlan,
                           SCHEDULE: RateSchedule,
                           '/diagnostics': DiagnosticArray}

# For people; made only while someone subscribes.
VIEWS: dict[str, Any] = {MARKERS: MarkerArray, OVERLAY: Image, WIDTH: Float64,
                         DEVIATION: Float64}

# Reliable, as the vendor's camera node publishes; shallow, since a message may have 37 MB.
CAMERA_QOS = QoSProfile(depth=2, reliability=ReliabilityPolicy.RELIABLE)
# These messages are small: with a deep queue, even a slow subscriber knows of each capture.
CAMERA_INFO_QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
# Sensor data, but deep enough for a robot that sends at 1000 Hz to a busy machine.
POSE_QOS = QoSProfile(depth=2000, reliability=ReliabilityPolicy.BEST_EFFORT)
EXTRUSION_QOS = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
# Each message has the whole path, so a late subscriber needs only the last one.
PATH_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Published when it changes: a late subscriber needs the last one.
SCHEDULE_QOS = PATH_QOS
UPDATE_QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
# The last one is enough, also for a subscriber that comes between two captures.
VIEW_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.TRANSIENT_LOCAL)
RESULT_QOS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
# As results, and also for a controller that comes when the layer is laid.
REPAIR_QOS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE,
                        durability=DurabilityPolicy.TRANSIENT_LOCAL)


def type_name(message_class: Any) -> str:
    """Return the name of a message class, such as ``sensor_msgs/msg/Image``."""
    return f'{message_class.__module__.split(".")[0]}/msg/{message_class.__name__}'
