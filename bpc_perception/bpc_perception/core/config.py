"""Validated, frozen configuration objects: the one home of every default.

A field is annotated with a :class:`Parameter`, from which nodes derive the description and
range of the ROS parameter, so that a default, its unit and its limits are written once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from bpc_perception.core.capture.colour_space import COLOUR_SPACES, LINEAR
from bpc_perception.core.parameter import Config, ConfigError, Parameter
from bpc_perception.core.robot.kinematics import LINK_OFFSETS_M

LEAST_TARGET_M, LARGEST_TARGET_M = 2e-5, 0.1  # of a bead; other numbers have another unit
BASE, FLANGE = 'lbr_link_0', 'lbr_link_ee'


@dataclass(frozen=True)
class SegmentationConfig(Config):
    """Delineation of the deposit in the image (paper, Sec. III-A)."""

    canny_low: Annotated[float, Parameter(
        'Canny: gradient from which an edge is continued', 'grey levels', 0, 10000)] = 50.0
    canny_high: Annotated[float, Parameter(
        'Canny: gradient from which an edge is started', 'grey levels', 0, 10000)] = 150.0
    kernel_size: Annotated[int, Parameter(
        'Side of the square that dilates the filled raw contours', 'pixels', 1, 101)] = 3
    jump_threshold: Annotated[int, Parameter(
        'Largest step along a raw contour that still continues it', 'vertices', 1, 10000)] = 10

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.canny_low > self.canny_high:
            raise ConfigError('canny_low: expected at most canny_high '
                              f'({self.canny_high:g}), found {self.canny_low:g}')
        if self.kernel_size % 2 == 0:
            raise ConfigError(f'kernel_size: expected an odd number, found {self.kernel_size}')


@dataclass(frozen=True)
class CrossSectionConfig(Config):
    """Thickness from the image across the path, the default method."""

    reach: Annotated[float, Parameter(
        'How far from the path an edge is looked for', 'm', 0.0002, 0.05)] = 0.004
    tangent_length: Annotated[float, Parameter(
        'Length of path over which its direction is taken', 'm', 1e-5, 0.02)] = 0.001
    noise_gain: Annotated[float, Parameter(
        'Uncertainty of a width per that from noise alone', '', 0.1, 10)] = 1.15
    edge_sigma: Annotated[float, Parameter(
        'Uncertainty of a width from sampling', 'pixels', 0, 2)] = 0.05
    light_sigma: Annotated[float, Parameter(
        'Uncertainty of a width from the light on a bead 10 pixels wide', 'pixels', 0, 2)] = 0.03
    maximum_noise: Annotated[float, Parameter(
        'Noise, as a share of the contrast of ink and bed, above which nothing is known',
        '', 0.01, 1)] = 0.25
    color_space: Annotated[str, Parameter(
        'What the image says of the light: its levels are in proportion to it, or coded for a '
        'screen', choices=COLOUR_SPACES)] = LINEAR
    maximum_sigma: Annotated[float, Parameter(
        'Uncertainty of a width, as a share of it, above which it is not told', '', 0.01, 10)
    ] = 0.15


@dataclass(frozen=True)
class AdviceConfig(Config):
    """From measured thickness to rate advice."""

    target_thickness: Annotated[float, Parameter(
        'Thickness wanted; 0 = none set, no valid advice', 'm', 0, LARGEST_TARGET_M)] = 0.0
    target_file: Annotated[str, Parameter(
        'Thickness wanted along the path, a CSV table; empty = the same everywhere',
        read_only=True)] = ''
    window: Annotated[float, Parameter(
        'Length of the newest stretch of path looked at', 'm', 0.0005, 1)] = 0.02
    minimum_samples: Annotated[int, Parameter(
        'Fewest measured samples in the window for valid advice', '', 1, 100000)] = 10
    minimum_coverage: Annotated[float, Parameter(
        'Least share of measured samples in the window for valid advice', '', 0, 1)] = 0.5
    dead_band: Annotated[float, Parameter(
        'Relative deviation from the target that needs no correction', '', 0, 1)] = 0.02
    minimum_scale: Annotated[float, Parameter('Least factor advised', '', 0.01, 1)] = 0.5
    maximum_scale: Annotated[float, Parameter('Largest factor advised', '', 1, 100)] = 2.0
    slew_rate: Annotated[float, Parameter(
        'Largest change advised, as natural logarithm of the factor, for each second since the '
        'capture before', '1/s', 0.001, 100)] = 0.25
    gap_length: Annotated[float, Parameter(
        'Shortest gap or clog, where ink was pushed out, that is reported', 'm', 0, 1)] = 0.002
    clog_drop: Annotated[float, Parameter(
        'Share of the delivered flow that is lost at once in a clog', '', 0.05, 1)] = 0.4
    maximum_offset: Annotated[float, Parameter(
        'Farthest that the deposit may lie beside the path', 'm', 0, 1)] = 0.001
    acquisition_time: Annotated[float, Parameter(
        'What was laid this short before a capture may have come during it, and does not count',
        's', 0, 10)] = 0.4
    stale_after: Annotated[float, Parameter(
        'Age of the newest measured sample from which advice is invalid', 's', 0.1, 3600)] = 20.0
    by_volume: Annotated[bool, Parameter(
        'Change only what width and volume agree on, where areas are known and the flow rate is '
        'calibrated')] = True
    lifetime: Annotated[float, Parameter(
        'How long advice holds after its capture', 's', 0.1, 3600)] = 5.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if 0 < self.target_thickness < LEAST_TARGET_M:
            raise ConfigError(f'target_thickness: expected 0, or {LEAST_TARGET_M:g} m or more, '
                              f'found {self.target_thickness:g}')


@dataclass(frozen=True)
class LearningConfig(Config):
    """What is learned of a layer for the next of the same path."""

    enabled: Annotated[bool, Parameter(
        'Whether a schedule of factors is made for each layer whose path was printed before')
    ] = True
    followed: Annotated[bool, Parameter(
        'Whether the print controller follows rate_schedule. Then rate_advice is on top of it',
        read_only=True)] = False
    file: Annotated[str, Parameter(
        'File in which is kept what was learned, for the next prints; empty = it is not',
        read_only=True)] = ''
    ink: Annotated[str, Parameter(
        'Name of the ink; what is kept of another is refused', read_only=True)] = ''
    nozzle: Annotated[str, Parameter(
        'Name or size of the nozzle; what is kept of another is refused', read_only=True)] = ''


@dataclass(frozen=True)
class ToleranceConfig(Config):
    """How far a print may be off, before it is not good; 0 = not judged."""

    width: Annotated[float, Parameter(
        'How far a width may be off its target, per the target; 0 = not judged', '', 0, 10)
    ] = 0.15
    target_height: Annotated[float, Parameter(
        'Height wanted; 0 = none set, heights are not judged', 'm', 0, LARGEST_TARGET_M)] = 0.0
    height: Annotated[float, Parameter(
        'How far a height may be off its target, per the target; 0 = not judged', '', 0, 10)
    ] = 0.25
    offset: Annotated[float, Parameter(
        "How far the bead's middle may lie beside the path, and beside the design, per the width "
        'wanted; 0 = not judged', '', 0, 10)] = 0.25
    gap_length: Annotated[float, Parameter(
        'Longest gap allowed; 0 = not judged', 'm', 0, 1)] = 0.002
    neck: Annotated[float, Parameter(
        'How much narrower than around it a bead may be, per its width; 0 = not judged', '', 0, 1)
    ] = 0.3
    ooze_length: Annotated[float, Parameter(
        'Longest ink on travel allowed; 0 = not judged', 'm', 0, 1)] = 0.002
    missing_strokes: Annotated[bool, Parameter(
        'Whether strokes without ink are looked for, and strokes of the design that are skipped')
    ] = True
    samples: Annotated[int, Parameter(
        'So many samples in a row are a defect, where each is out of its band', '', 1, 1000)] = 5
    ends: Annotated[float, Parameter(
        'At each end of a stroke so much is not judged by width, height and offset', 'm', 0, 1)
    ] = 0.002
    coverage: Annotated[float, Parameter(
        'Least share of a stroke that has to be seen for it to pass', '', 0, 1)] = 0.8


@dataclass(frozen=True)
class RepairConfig(Config):
    """What of a layer is to be filled, and what hinders the next one."""

    least_length: Annotated[float, Parameter(
        'Shortest stretch that is filled, per the width of the bead: the ends of a bead are as '
        'round as it is wide', '', 0.1, 100)] = 1.0
    overlap: Annotated[float, Parameter(
        'How far a stroke that fills begins and ends on the ink beside the gap, per the width of '
        'the bead: its end is round over half of it', '', 0, 10)] = 0.5
    nozzle_radius: Annotated[float, Parameter(
        'Outer radius of the nozzle, which must not touch ink of a higher layer', 'm', 0, 0.1)
    ] = 0.001  # steel tips have 0.3 to 0.9 mm, gauges 25 to 15
    bridged_length: Annotated[float, Parameter(
        'Longest gap, or stretch of low ink, that a bead of the next layer spans', 'm', 0, 1)
    ] = 0.002  # as tolerance.gap_length: what is no defect hinders nothing
    highest: Annotated[float, Parameter(
        'How far ink may stand above its layer, per the room below the nozzle; at 1 the nozzle of '
        'the next layer touches it', '', 0, 10)] = 0.75
    lowest: Annotated[float, Parameter(
        'Least height of ink that carries the next bead, per the height of its layer; 0 = any', '',
        0, 1)] = 0.5


@dataclass(frozen=True)
class DesignConfig(Config):
    """What a print shall be."""

    file: Annotated[str, Parameter(
        'Design of the print, G-code or a CSV path; empty = none', read_only=True)] = ''
    place: Annotated[str, Parameter(
        "Where the design's origin lies in the robot base frame, and how it is turned about z, as "
        '"x,y,z,yaw" in millimetres and degrees; empty = found from the path',
        read_only=True)] = ''
    ink_on: Annotated[str, Parameter(
        'Commands of the G-code that switch ink on, as "M42 P32 S255", where it is not E; with ; '
        'between several', read_only=True)] = ''
    ink_off: Annotated[str, Parameter(
        'Commands that switch it off, alike', read_only=True)] = ''


@dataclass(frozen=True)
class PathConfig(Config):
    """From poses and extruder states to the path of a print."""

    spacing: Annotated[float, Parameter(
        'Distance between path points', 'm', 1e-5, 0.1, read_only=True)] = 0.0002
    smoothing_time: Annotated[float, Parameter(
        'Poses within this time around each are averaged; 0 = none',
        's', 0, 10, read_only=True)] = 0.1
    maximum_gap: Annotated[float, Parameter(
        'Time without a pose after which the path between is unknown', 's', 0.01, 60,
        read_only=True)] = 0.2  # as watch.warn_after: what is warned of is not bridged
    maximum_speed: Annotated[float, Parameter(
        'Of the nozzle tip; a pose that it cannot have reached is refused', 'm/s', 0.01, 100,
        read_only=True)] = 2.0
    extrusion_timeout: Annotated[float, Parameter(
        'Age from which an extruder state is no longer believed', 's', 0.01, 60,
        read_only=True)] = 0.5
    auto: Annotated[bool, Parameter(
        'Start a print by itself when ink is pushed out', read_only=True)] = True
    auto_stop_after: Annotated[float, Parameter(
        'With auto: a print ends when no ink was pushed out for this long; it goes on when more '
        'comes over, beside or above it', 's', 0.1, 3600,
        read_only=True)] = 10.0


@dataclass(frozen=True)
class WatchConfig(Config):
    """From when on an input is at fault."""

    warn_after: Annotated[float, Parameter(
        'Silence of an input from which there is a warning; of captures, after the next was due; '
        '0 = not watched', 's', 0, 3600, read_only=True)] = 0.2
    error_after: Annotated[float, Parameter(
        'Silence from which it is an error; 0 = never', 's', 0, 3600, read_only=True)] = 1.0
    maximum_lead: Annotated[float, Parameter(
        'What is stamped farther in the future is refused', 's', 0.001, 3600,
        read_only=True)] = 0.1


@dataclass(frozen=True)
class ProcessConfig(Config):
    """How much of the computer a node's process takes."""

    threads: Annotated[int, Parameter(
        'Threads that OpenCV may use', '', 1, 64, read_only=True)] = 1
    niceness: Annotated[int, Parameter(
        'Above 0 gives way to other processes; below 0 needs the right to', '', -20, 19,
        read_only=True)] = 0


@dataclass(frozen=True)
class PoseConfig(Config):
    """Where the poses of the flange come from."""

    source: Annotated[str, Parameter(
        'What tells the pose of the flange', choices=(
            'pose_stamped', 'pose', 'joint_states', 'lbr_state', 'tf'),
        read_only=True)] = 'pose_stamped'
    robot: Annotated[str, Parameter(
        'With joint_states and lbr_state: whose joints they are; none = not said',
        choices=('none', *LINK_OFFSETS_M), read_only=True)] = 'none'
    flange_frame: Annotated[str, Parameter(
        'With tf: name of the flange', read_only=True)] = FLANGE

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.robot == 'none' and self.source in ('joint_states', 'lbr_state'):
            raise ConfigError(f'robot: expected one of {", ".join(LINK_OFFSETS_M)} with source '
                              f'{self.source}, found none')


@dataclass(frozen=True)
class RecorderConfig(Config):
    """All of the path recorder."""

    base_frame: Annotated[str, Parameter(
        'Robot base frame, in which poses come and the path is given', read_only=True)] = BASE
    nozzle_offset: Annotated[tuple[float, float, float], Parameter(
        'Nozzle tip in the flange frame: x, y, z', 'm', -2, 2, read_only=True)] = (0.0, 0.0, 0.0)
    publish_rate: Annotated[float, Parameter(
        'How often what is new of the path is published while it grows', 'Hz', 0.1, 100,
        read_only=True)] = 50.0
    output_folder: Annotated[str, Parameter(
        'Folder into which prints are saved', read_only=True)] = '.'
    state_folder: Annotated[str, Parameter(
        'Folder in which the running print is kept, to be resumed after a restart; empty = it '
        'is not', read_only=True)] = ''
    resume: Annotated[str, Parameter(
        'Which print in state_folder is gone on with at the start: one that was not ended, as '
        'after a crash, or the newest, ended or not', choices=('crashed', 'newest', 'none'),
        read_only=True)] = 'crashed'
    resume_within: Annotated[float, Parameter(
        'A print that crashed is resumed if it was last written to so long ago', 's', 0, 3600,
        read_only=True)] = 30.0
    pose: PoseConfig = field(default_factory=PoseConfig)
    path: PathConfig = field(default_factory=PathConfig)
    watch: WatchConfig = field(default_factory=WatchConfig)
    process: ProcessConfig = field(default_factory=ProcessConfig)


@dataclass(frozen=True)
class ThicknessConfig(Config):
    """All of the measurement."""

    base_frame: Annotated[str, Parameter(
        'Robot base frame, in which path and profile are given', read_only=True)] = BASE
    hand_eye_file: Annotated[str, Parameter(
        'Hand-eye calibration file', read_only=True)] = ''
    method: Annotated[str, Parameter(
        'How thickness is measured: "paper" is the published method',
        choices=('cross_section', 'paper'))] = 'cross_section'
    patience: Annotated[float, Parameter(
        'How long a capture waits for path and poses to reach its stamp', 's', 0.01, 60)] = 2.0
    maximum_pose_gap: Annotated[float, Parameter(
        'Camera in hand: poses around a capture may be this far apart', 's', 0.001, 10)] = 0.1
    maximum_tip_height: Annotated[float, Parameter(
        'Where the nozzle was higher above the bed, or above earlier ink, it laid nothing', 'm',
        0.0001, 1)] = 0.005
    overlay_layer: Annotated[int, Parameter(
        'Layer that the overlay shows; -1 = the newest', '', -1, 10_000)] = -1
    obstacle_height: Annotated[float, Parameter(
        'What stands this far above the bed hides it, as the nozzle does', 'm',
        0.0005, 1)] = 0.0025
    obstacle_margin: Annotated[float, Parameter(
        'Nothing is measured this close to an obstacle', 'pixels', 0, 50)] = 2.0
    state_folder: Annotated[str, Parameter(
        'Folder in which is kept what prints were set up with, so that the limits of advice hold '
        'over restarts; empty = it is not', read_only=True)] = ''
    maximum_offset: Annotated[float, Parameter(
        'How far off the path the deposit may lie, per its width, before it is warned of', '',
        0.01, 10)] = 0.25
    longest_whole_profile: Annotated[int, Parameter(
        'Of a profile with more samples what changed is published with each capture, the whole on '
        'request and at the end', 'samples', 0, 1_000_000)] = 2000
    pose: PoseConfig = field(default_factory=PoseConfig)
    segmentation: SegmentationConfig = field(default_factory=SegmentationConfig)
    cross_section: CrossSectionConfig = field(default_factory=CrossSectionConfig)
    advice: AdviceConfig = field(default_factory=AdviceConfig)
    tolerance: ToleranceConfig = field(default_factory=ToleranceConfig)
    repair: RepairConfig = field(default_factory=RepairConfig)
    design: DesignConfig = field(default_factory=DesignConfig)
    learning: LearningConfig = field(default_factory=LearningConfig)
    watch: WatchConfig = field(default_factory=WatchConfig)
    process: ProcessConfig = field(default_factory=ProcessConfig)


@dataclass(frozen=True)
class PlayerConfig(Config):
    """All of the bag player."""

    bag: Annotated[str, Parameter('Recording to play', read_only=True)] = ''
    rate: Annotated[float, Parameter(
        'Speed of the clock; 1 = as recorded', '', 0.01, 100, read_only=True)] = 1.0
    loop: Annotated[bool, Parameter('Start again at the end', read_only=True)] = False
    remap: Annotated[str, Parameter(
        'Recorded topics to play in the place of others, TOPIC:=OTHER, with spaces between',
        read_only=True)] = ''


@dataclass(frozen=True)
class BagRecorderConfig(Config):
    """All of the bag recorder."""

    bag: Annotated[str, Parameter('Folder of the new recording', read_only=True)] = 'recording'
    prints: Annotated[str, Parameter(
        'Folder in which each print gets a folder with its own recording; empty = one recording '
        'of all, in bag', read_only=True)] = ''
    compress: Annotated[bool, Parameter(
        'One recording of all: images and clouds are packed without loss', read_only=True)] = False
    least_free: Annotated[float, Parameter(
        'With prints: recording ends where less is free on the disk', 'GB', 0, 100000,
        read_only=True)] = 2.0
    hand_eye_file: Annotated[str, Parameter(
        'Hand-eye calibration that is kept with each recording; empty = none',
        read_only=True)] = ''
    parameter_file: Annotated[str, Parameter(
        'ROS parameter file that is kept with each recording; empty = none',
        read_only=True)] = ''
    design_file: Annotated[str, Parameter(
        'Design that is kept with each recording; empty = that of the parameter file',
        read_only=True)] = ''
    pose: PoseConfig = field(default_factory=PoseConfig)


@dataclass(frozen=True)
class ResultsWriterConfig(Config):
    """All of the results writer."""

    prints: Annotated[str, Parameter(
        'Folder in which each print gets a folder with its results', read_only=True)] = 'prints'
    hand_eye_file: Annotated[str, Parameter(
        'Hand-eye calibration with which is measured', read_only=True)] = ''
    parameter_file: Annotated[str, Parameter(
        'ROS parameter file of the nodes that measure; empty = none', read_only=True)] = ''
    design_file: Annotated[str, Parameter(
        'Design of the prints; empty = that of the parameter file', read_only=True)] = ''
    period: Annotated[float, Parameter(
        'How often the results of a print are written while it grows', 's', 0.1, 3600,
        read_only=True)] = 10.0
    process: ProcessConfig = field(default_factory=lambda: ProcessConfig(niceness=10))


@dataclass(frozen=True)
class PageConfig(Config):
    """All of the live page."""

    port: Annotated[int, Parameter(
        'Where the page is served on this computer; 0 = any port that is free', '', 0, 65535,
        read_only=True)] = 8770
    process: ProcessConfig = field(default_factory=lambda: ProcessConfig(niceness=5))


@dataclass(frozen=True)
class PlungerConfig(Config):
    """Geometry of syringe and drive."""

    lead: Annotated[float, Parameter(
        'Travel of the plunger per turn of the motor, gears included; 0 = not known', 'm', 0,
        0.1, read_only=True)] = 0.0
    steps_per_revolution: Annotated[int, Parameter(
        'Full steps of the motor per turn', '', 1, 100000, read_only=True)] = 200
    bore: Annotated[float, Parameter(
        'Inner diameter of the syringe; 0 = not known', 'm', 0, 0.2, read_only=True)] = 0.0
    reversed: Annotated[bool, Parameter(
        'Whether ink is pushed out while positions fall', read_only=True)] = False
    minimum_velocity: Annotated[float, Parameter(
        'Velocity of the plunger from which ink is taken to be pushed out', 'm/s', 0, 0.1,
        read_only=True)] = 1e-7


@dataclass(frozen=True)
class ExtruderConfig(Config):
    """All of the extruder bridge."""

    back_end: Annotated[str, Parameter(
        'What tells the state of the extruder', choices=('serial', 'tic', 'joint_state', 'bool'),
        read_only=True)] = 'serial'
    port: Annotated[str, Parameter(
        'With serial and tic: the serial line, best by its name in /dev/serial/by-id; empty = the '
        'only device there; "usb" = the Tic itself over USB',
        read_only=True)] = ''
    baud: Annotated[int, Parameter(
        'With serial and tic: speed of the line', 'baud', 300, 4000000,
        read_only=True)] = 115200
    device_number: Annotated[int, Parameter(
        'With tic: its device number', '', 0, 127, read_only=True)] = 14
    rate: Annotated[float, Parameter(
        'How often the device is read, and with bool the state repeated', 'Hz', 1, 200,
        read_only=True)] = 50.0
    timeout: Annotated[float, Parameter(
        'Silence after which the device is opened anew', 's', 0.1, 60, read_only=True)] = 1.0
    joint: Annotated[str, Parameter(
        'With joint_state: name of the plunger', read_only=True)] = 'plunger'
    plunger: PlungerConfig = field(default_factory=PlungerConfig)


@dataclass(frozen=True)
class CameraConfig(Config):
    """All of the camera driver but its back end's own."""

    back_end: Annotated[str, Parameter(
        'Where captures come from: "bag", a recording, "zivid", a Zivid camera, or a back end of '
        'another package, as "synthetic", the simulated printer', read_only=True)] = 'bag'
    autostart: Annotated[bool, Parameter(
        'Whether it configures and activates itself at the start; if not, a lifecycle manager '
        'has to', read_only=True)] = True
    rate: Annotated[float, Parameter(
        'Captures taken by itself; 0 = only on request', 'Hz', 0, 30)] = 0.0
    region: Annotated[tuple[int, int, int, int], Parameter(
        'The part of a capture that is delivered: x, y, width, height; width or height 0 = all',
        'pixels', 0, 100000)] = (0, 0, 0, 0)
    process: ProcessConfig = field(default_factory=ProcessConfig)


@dataclass(frozen=True)
class ZividConfig(Config):
    """The back end zivid of the camera driver."""

    serial_number: Annotated[str, Parameter(
        'Which camera; empty = the first that is found', read_only=True)] = ''
    settings_file: Annotated[str, Parameter(
        'Capture settings as Zivid Studio saves them (.yml), with those of the colour image',
        read_only=True)] = ''
    frame_id: Annotated[str, Parameter(
        'Name of the optical frame', read_only=True)] = 'zivid_optical_frame'
    color_space: Annotated[str, Parameter(
        'Colours in proportion to the light, for right widths, or brighter for people',
        choices=COLOUR_SPACES, read_only=True)] = LINEAR
    intrinsics: Annotated[str, Parameter(
        'Whose intrinsics: of the camera, or estimated for each capture',
        choices=('camera', 'frame'), read_only=True)] = 'camera'
