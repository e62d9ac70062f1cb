"""Judges a rig before a print, from what was seen of it: what is good or bad, and what to do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import NamedTuple

from bpc_perception.core.capture.exposure import Exposure
from bpc_perception.core.config import DesignConfig
from bpc_perception.core.robot.hand_eye import mount_name
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.units import MM_PER_M
from bpc_perception.files.design.wanted import wanted_design
from bpc_perception.runtime.transport.dds_profiles import lost_captures_hint, users_profile

OK, WARN, FAIL = 'OK', 'WARN', 'FAIL'

MS_PER_S = 1e3
BYTES_PER_MB, BYTES_PER_GB = 1e6, 1e9
# What is sent steadily: the rates below which it fails, and below which it is warned of.
FAIL_BELOW_HZ = {'pose': 10.0, 'extruder': 4.0}
WARN_BELOW_HZ = {'pose': 50.0, 'extruder': 10.0}
# From a stamp to its receipt; a capture is processed in the meantime.
WARN_LATE_S = {'pose': 0.1, 'extruder': 0.1, 'camera': 2.0}
FAIL_LATE_S = {'pose': 1.0, 'extruder': 1.0, 'camera': 10.0}
OTHER_CLOCK_AHEAD_S = 0.02  # a stamp so far ahead of our clock is from another clock
SET_CLOCKS = 'let chrony or PTP set the clocks of all computers'
WARN_CLIPPED, WARN_DARK = 0.05, 60.0  # share of the picture, and grey levels
OLD_CALIBRATION_DAYS = 30.0
FAIL_DISK_BYTES, WARN_DISK_BYTES = 1e9, 20e9  # a capture of full size has 47 MB
# What transport.xml asks for, with room for both sides.
WARN_SHARED_MEMORY_BYTES = 300e6
TESTED_MIDDLEWARE = 'rmw_fastrtps_cpp'


class Finding(NamedTuple):
    """One line of the check."""

    level: str
    subject: str
    found: str
    todo: str = ''


@dataclass
class Heard:
    """What was heard on a topic.

    Attributes:
        topic: its full name.
        kind: 'camera', 'pose' or 'extruder'.
        wanted, types: the type that is read, and those that are published.
        publishers: how many there are.
        best_effort: whether one of them does not repeat what gets lost.
        arrivals: when messages came, by a steady clock [s].
        delays: from stamp to receipt [s]; empty without stamps.
        stamps: of the parts of captures [ns].
        lost: stamps of captures of which another part came, but not this one.
        due: number of captures of which it could have come.
        problems: what is wrong with their content.
    """

    topic: str
    kind: str
    wanted: str
    types: list[str] = field(default_factory=list)
    publishers: int = 0
    best_effort: bool = False
    arrivals: list[float] = field(default_factory=list)
    delays: list[float] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    stamps: list[int] = field(default_factory=list)
    lost: set[int] = field(default_factory=set)
    due: int = 0

    @property
    def rate(self) -> float:
        """Messages per second [Hz]."""
        if len(self.arrivals) < 2:
            return 0.0
        return (len(self.arrivals) - 1) / (self.arrivals[-1] - self.arrivals[0] or 1e-9)


def judge_topic(heard: Heard) -> Iterator[Finding]:
    """Judge a topic, up to the first thing that keeps it from working."""
    obstacle = _obstacle(heard)
    if obstacle is not None:
        yield obstacle
        return
    for problem in dict.fromkeys(heard.problems):
        found, _, todo = problem.partition('; ')
        yield Finding(FAIL, heard.topic, found, todo or 'correct it at its source')
    yield _judge_rate(heard)
    yield _judge_clock(heard)


def _obstacle(heard: Heard) -> Finding | None:
    """Return what keeps a topic from working; None = nothing."""
    name = heard.topic
    if not heard.publishers:
        return Finding(FAIL, name, 'nobody publishes it', 'start its node, or name its topic with '
                       '--remap; on another computer set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET')
    if heard.wanted not in heard.types:
        return Finding(FAIL, name, f'is {", ".join(heard.types)}, expected {heard.wanted}',
                       'choose the pose.source or back_end that fits, or remap')
    if heard.publishers > 1:
        return Finding(FAIL, name, f'{heard.publishers} publish it',
                       'end all but one: they would mix')
    if heard.kind != 'pose' and heard.best_effort:
        return Finding(FAIL, name, 'is published best effort, which a reliable subscriber does '
                       'not hear', 'publish it reliably')
    if heard.lost:
        return Finding(FAIL, name, f'{len(heard.lost)} of {heard.due} captures came without it',
                       lost_captures_hint())
    if heard.arrivals:
        return None
    if heard.kind == 'camera':
        return Finding(WARN, name, 'no capture came', 'call its service capture, or set a rate')
    return Finding(FAIL, name, 'nothing came', 'look at the node that publishes it')


def _judge_rate(heard: Heard) -> Finding:
    if heard.kind == 'camera':
        return Finding(OK, heard.topic, f'{len(heard.arrivals)} came')
    level = _level_if_small(heard.rate, WARN_BELOW_HZ[heard.kind], FAIL_BELOW_HZ[heard.kind])
    todo = '' if level == OK else f'expected {WARN_BELOW_HZ[heard.kind]:g} Hz or more'
    return Finding(level, heard.topic, f'{heard.rate:.1f} Hz', todo)


def _level_if_small(value: float, warn_below: float, fail_below: float) -> str:
    """Return the level of a quantity that may be too small."""
    if value < fail_below:
        return FAIL
    return WARN if value < warn_below else OK


def _judge_clock(heard: Heard) -> Finding:
    subject = f'clock of {heard.topic}'
    if not heard.delays:
        return Finding(WARN, subject, 'its messages have no stamps', 'the path is late by the '
                       'delay of the network; rather publish a stamped pose')
    # The least delay is that of the clocks; network and this computer add to it.
    least, usual = min(heard.delays), median(heard.delays)
    if least < -OTHER_CLOCK_AHEAD_S:
        return Finding(FAIL, subject,
                       f'stamps are {-least * MS_PER_S:.0f} ms ahead of this computer', SET_CLOCKS)
    warn, late = WARN_LATE_S[heard.kind], f'stamps come {usual * MS_PER_S:.0f} ms late'
    if least > FAIL_LATE_S[heard.kind]:
        return Finding(FAIL, subject, late, SET_CLOCKS)
    if usual <= warn:
        return Finding(OK, subject, late)
    return Finding(WARN, subject, late,
                   SET_CLOCKS if least > warn else 'look for a busy computer or network')


def judge_calibration(on_base: bool, age_days: float) -> Finding:
    """Judge whether the hand-eye calibration can be trusted."""
    found = f'{mount_name(on_base)}, {age_days:.0f} days old'
    if age_days > OLD_CALIBRATION_DAYS:
        return Finding(WARN, 'hand-eye calibration', found,
                       'see with "bpc calibrate check" on a print whether it still holds')
    return Finding(OK, 'hand-eye calibration', found)


def judge_frames(contradiction: str) -> Iterator[Finding]:
    """Judge whether the calibration names the camera and the base that are there."""
    if contradiction:
        yield Finding(WARN, 'hand-eye calibration', contradiction,
                      'give the file of this camera, or correct the names in it')


def judge_stamps(stamps: Sequence[Sequence[int]]) -> Iterator[Finding]:
    """Judge whether image, camera info and cloud, with these stamps [ns], make captures."""
    if stamps and all(stamps) and not set(stamps[0]).intersection(*stamps[1:]):
        yield Finding(FAIL, 'captures', 'image, camera info and cloud have no stamp in common',
                      'let the camera give all three the stamp of their capture')


def judge_target(target: float, file: str = '') -> Finding:
    """Judge the target thickness: the same everywhere [m] (0 = none), or that of a table."""
    if file:
        try:
            thickness = WidthTargets.read(file).thickness
        except (OSError, ValueError) as error:
            return Finding(FAIL, 'target thickness', str(error), 'correct advice.target_file')
        return Finding(OK, 'target thickness', f'{thickness.min() * MM_PER_M:g} to '
                       f'{thickness.max() * MM_PER_M:g} mm in {file}')
    if not target:
        return Finding(WARN, 'target thickness', 'none',
                       'without advice.target_thickness or advice.target_file no advice is '
                       'valid')
    return Finding(OK, 'target thickness', f'{target * MM_PER_M:g} mm')


def judge_design(config: DesignConfig) -> Finding:
    """Judge the design that is named; its file is told."""
    try:
        wanted = wanted_design(config)
    except (OSError, ValueError) as error:
        return Finding(FAIL, 'design', str(error), 'correct design.file and what belongs to it')
    assert wanted is not None
    design = wanted.design
    return Finding(OK, 'design', f'{len(design.strokes)} strokes, {design.length * MM_PER_M:.0f} '
                   f'mm, in {config.file}')


def judge_disk(folder: str, free: float) -> Finding:
    """Judge whether a folder with this free space [bytes] has room for a recording."""
    level = _level_if_small(free, WARN_DISK_BYTES, FAIL_DISK_BYTES)
    todo = ('' if level == OK else
            f'make room: {WARN_DISK_BYTES / BYTES_PER_GB:g} GB hold 400 captures')
    return Finding(level, 'free disk', f'{free / BYTES_PER_GB:.1f} GB in {folder}', todo)


def judge_transport(environment: Mapping[str, str], shared_memory: float) -> Iterator[Finding]:
    """Judge whether the middleware can carry captures.

    Args:
        environment: variables of the process.
        shared_memory: that is free [bytes].
    """
    rmw = environment.get('RMW_IMPLEMENTATION', TESTED_MIDDLEWARE)
    if rmw != TESTED_MIDDLEWARE:
        yield Finding(WARN, 'middleware', rmw, f'tried is {TESTED_MIDDLEWARE} only')
    else:
        yield Finding(OK, 'middleware', rmw)
    if profile := users_profile(environment):
        yield Finding(WARN, 'transport', f'profiles {profile} in place of transport.xml',
                      'see that it has shared memory for captures of 37 MB')
    else:
        yield Finding(OK, 'transport', "bpc's own profiles for its nodes")
    enough = shared_memory >= WARN_SHARED_MEMORY_BYTES
    yield Finding(OK if enough else WARN, 'shared memory',
                  f'{shared_memory / BYTES_PER_MB:.0f} MB free',
                  '' if enough else 'captures come late or not: make room in /dev/shm')
    reach = environment.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    yield Finding(OK, 'discovery', f'{reach}, domain {environment.get("ROS_DOMAIN_ID", "0")}')


def judge_domain(domain: str, holder: str) -> Finding:
    """Judge whether a suite can begin in a ROS domain; ``holder`` has it, empty = nobody."""
    if holder:
        return Finding(FAIL, f'ROS domain {domain}', f'in use by {holder}',
                       'stop it, or set ROS_DOMAIN_ID to another number')
    return Finding(OK, f'ROS domain {domain}', 'no suite on this computer is in it')


def judge_exposure(exposure: Exposure) -> Finding:
    """Judge how a picture is exposed."""
    found = (f'{exposure.clipped:.0%} of the picture is overexposed, the brightest of the rest '
             f'reaches {min(exposure.bright, 255):.0f} of 255')
    if exposure.clipped > WARN_CLIPPED:
        return Finding(WARN, 'exposure', found,
                       'expose less: beside what is overexposed nothing is measured')
    if exposure.bright < WARN_DARK:
        return Finding(WARN, 'exposure', found, 'expose more: noise makes widths uncertain')
    return Finding(OK, 'exposure', found)


def judge_extruder(error_names: str, position_uncertain: bool, velocity_known: bool,
                   flow_known: bool) -> Iterator[Finding]:
    """Judge what the extruder says about itself; ``error_names`` is empty without an error."""
    if error_names:
        yield Finding(FAIL, 'extruder', f'the motor is stopped: {error_names}',
                      'clear the error at the driver')
    if position_uncertain and not velocity_known and not flow_known:
        yield Finding(WARN, 'extruder', 'neither its position nor its flow is known', 'back_end '
                      'bool of extruder_bridge knows neither; for others set plunger.lead and '
                      'plunger.bore')
        return
    if position_uncertain:
        yield Finding(WARN, 'extruder', 'its position is uncertain', 'home it')
    if not flow_known:
        yield Finding(WARN, 'extruder', 'its flow is not known',
                      'set plunger.lead and plunger.bore of extruder_bridge')
    if not error_names and not position_uncertain and flow_known:
        yield Finding(OK, 'extruder', 'no error, position and flow known')
