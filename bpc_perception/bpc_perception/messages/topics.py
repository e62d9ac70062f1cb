"""Names, types and quality of service of the suite's topics; names are relative."""

from __future__ import annotations

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image, JointState, PointCloud2
from std_msgs.msg import Float64
from visualization_msgs.msg import MarkerArray

from bpc_interfaces.msg import DepositionPath, ExtrusionState, RateAdvice, ThicknessProfile

IMAGE, CAMERA_INFO, CLOUD = 'color/image_color', 'color/camera_info', 'points/xyzrgba'
CAMERA: dict[str, Any] = {IMAGE: Image, CAMERA_INFO: CameraInfo, CLOUD: PointCloud2}
SNR = 'snr/image'  # optional, Image
POSE, EXTRUSION = 'end_effector_pose', 'extrusion_state'
PRINT: dict[str, Any] = {POSE: PoseStamped, EXTRUSION: ExtrusionState}
# Other sources of the flange's pose, each in place of POSE.
JOINTS, LBR_STATE = 'joint_states', 'lbr_state'
ROBOT: dict[str, Any] = {POSE: PoseStamped, JOINTS: JointState}  # what has a package anywhere
POSES = *ROBOT, LBR_STATE
# What other extruders say of themselves.
PLUNGER, EXTRUDING = 'plunger_joint_states', 'extruding'
PATH, NAV_PATH = 'deposition_path', 'deposition_path/nav'
PATH_UPDATE = 'deposition_path/update'  # what is new in PATH; not recorded
PROFILE, ADVICE = 'thickness_profile', 'rate_advice'
MARKERS, OVERLAY = 'thickness/markers', 'thickness/overlay'
WIDTH, DEVIATION = 'thickness/width', 'thickness/deviation'
RESULTS: dict[str, Any] = {PATH: DepositionPath, NAV_PATH: Path, PROFILE: ThicknessProfile,
                           ADVICE: RateAdvice, '/diagnostics': DiagnosticArray}

# For people to look at; made only while someone does.
VIEWS: dict[str, Any] = {MARKERS: MarkerArray, OVERLAY: Image, WIDTH: Float64,
                         DEVIATION: Float64}

# Reliable as the vendor's camera node publishes; shallow, since a message may be 37 MB.
CAMERA_QOS = QoSProfile(depth=2, reliability=ReliabilityPolicy.RELIABLE)
# Small, so that those who are too slow for all captures know of each.
CAMERA_INFO_QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
# Sensor data, but deep enough for what a 1000 Hz robot sends while a busy machine has no time.
POSE_QOS = QoSProfile(depth=2000, reliability=ReliabilityPolicy.BEST_EFFORT)
EXTRUSION_QOS = QoSProfile(depth=2000, reliability=ReliabilityPolicy.RELIABLE)
# The whole path is in each message, so a late subscriber needs the last one only.
PATH_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.TRANSIENT_LOCAL)
PATH_UPDATE_QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
# The last is enough, also for who comes to look between two captures.
VIEW_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE,
                      durability=DurabilityPolicy.TRANSIENT_LOCAL)
RESULT_QOS = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


def type_name(message_class: Any) -> str:
    """The name of a message class, such as ``sensor_msgs/msg/Image``."""
    return f'{message_class.__module__.split(".")[0]}/msg/{message_class.__name__}'
