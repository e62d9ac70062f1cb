"""What is good or bad about a rig before a print, from what was seen of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from statistics import median
from typing import NamedTuple

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.runtime.transport.dds_profiles import users_profile

OK, WARN, FAIL = 'OK', 'WARN', 'FAIL'

# Least rates of what flows by itself: that which serves, and that which does well [Hz].
RATES = {'pose': (10.0, 50.0), 'extruder': (4.0, 10.0)}
LATE_WARN, LATE_FAIL = 0.1, 1.0  # from a stamp to its receipt [s]
CAPTURE_LATE_WARN, CAPTURE_LATE_FAIL = 2.0, 10.0  # of a capture, which is processed meanwhile [s]
EARLY = 0.02  # a stamp this far ahead of our clock is of another [s]
SET_CLOCKS = 'let chrony or PTP set the clocks of all computers'
OLD_CALIBRATION = 30.0  # [days]
DISK_FAIL, DISK_WARN = 1e9, 20e9  # [bytes]; a capture of full size has 47 MB
SHM_WARN = 300e6  # [bytes] what transport.xml asks for, with room for both sides


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

    @property
    def rate(self) -> float:
        """Messages a second [Hz]."""
        if len(self.arrivals) < 2:
            return 0.0
        return (len(self.arrivals) - 1) / (self.arrivals[-1] - self.arrivals[0] or 1e-9)


def judge_topic(heard: Heard) -> Iterator[Finding]:
    """What is good or bad about a topic; the first thing that keeps it from working ends it."""
    name = heard.topic
    if not heard.publishers:
        yield Finding(FAIL, name, 'nobody publishes it', 'start its node, or name its topic with '
                      '--remap; on another computer set ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET')
        return
    if heard.wanted not in heard.types:
        yield Finding(FAIL, name, f'is {", ".join(heard.types)}, expected {heard.wanted}',
                      'choose the pose.source or back_end that fits, or remap')
        return
    if heard.publishers > 1:
        yield Finding(FAIL, name, f'{heard.publishers} publish it',
                      'end all but one: they would mix')
        return
    if heard.kind != 'pose' and heard.best_effort:
        yield Finding(FAIL, name, 'is published best effort, which a reliable subscriber does '
                      'not hear', 'publish it reliably')
        return
    if not heard.arrivals:
        yield (Finding(WARN, name, 'no capture came', 'call its service capture, or set a rate')
               if heard.kind == 'camera' else
               Finding(FAIL, name, 'nothing came', 'look at the node that publishes it'))
        return
    for problem in dict.fromkeys(heard.problems):
        yield Finding(FAIL, name, problem, 'correct it at its source')
    yield from _judge_rate(heard)
    yield from _judge_clock(heard)


def _judge_rate(heard: Heard) -> Iterator[Finding]:
    if heard.kind == 'camera':
        yield Finding(OK, heard.topic, f'{len(heard.arrivals)} came')
        return
    serves, well = RATES[heard.kind]
    level = FAIL if heard.rate < serves else WARN if heard.rate < well else OK
    todo = '' if level == OK else f'expected {well:g} Hz or more'
    yield Finding(level, heard.topic, f'{heard.rate:.1f} Hz', todo)


def _judge_clock(heard: Heard) -> Iterator[Finding]:
    subject = f'clock of {heard.topic}'
    if not heard.delays:
        yield Finding(WARN, subject, 'its messages have no stamps', 'the path is late by the '
                      'delay of the network; rather publish a stamped pose')
        return
    # The least delay is that of the clocks; what comes on top is the network's and ours.
    least, usual = min(heard.delays), median(heard.delays)
    camera = heard.kind == 'camera'
    warn, fail = ((CAPTURE_LATE_WARN, CAPTURE_LATE_FAIL) if camera else (LATE_WARN, LATE_FAIL))
    if least < -EARLY:
        yield Finding(FAIL, subject, f'stamps are {-least * 1e3:.0f} ms ahead of this computer',
                      SET_CLOCKS)
        return
    level = FAIL if least > fail else WARN if usual > warn else OK
    yield Finding(level, subject, f'stamps come {usual * 1e3:.0f} ms late',
                  '' if level == OK else
                  SET_CLOCKS if least > warn else 'look for a busy computer or network')


def judge_calibration(mount: str, age_days: float) -> Finding:
    """Whether the hand-eye calibration is one to trust."""
    found = f'{mount}, {age_days:.0f} days old'
    if age_days > OLD_CALIBRATION:
        return Finding(WARN, 'hand-eye calibration', found,
                       'see with "bpc calibrate check" on a print whether it still holds')
    return Finding(OK, 'hand-eye calibration', found)


def judge_target(target: float, file: str = '') -> Finding:
    """Whether there is a thickness to reach: the same everywhere [m], or that of a table."""
    if file:
        try:
            wanted = WidthTargets.read(file).thickness
        except (OSError, ValueError) as error:
            return Finding(FAIL, 'target thickness', str(error), 'correct advice.target_file')
        return Finding(OK, 'target thickness', f'{wanted.min() * 1e3:g} to '
                       f'{wanted.max() * 1e3:g} mm in {file}')
    if not target:
        return Finding(WARN, 'target thickness', 'none',
                       'without advice.target_thickness or advice.target_file no advice is '
                       'valid')
    return Finding(OK, 'target thickness', f'{target * 1e3:g} mm')


def judge_disk(folder: str, free: float) -> Finding:
    """Whether a recording has room [bytes]."""
    level = FAIL if free < DISK_FAIL else WARN if free < DISK_WARN else OK
    return Finding(level, 'free disk', f'{free / 1e9:.1f} GB in {folder}',
                   '' if level == OK else f'make room: {DISK_WARN / 1e9:g} GB hold 400 captures')


def judge_transport(environment: Mapping[str, str], shared_memory: float) -> Iterator[Finding]:
    """Whether the middleware can carry captures, from the variables and free memory [bytes]."""
    rmw = environment.get('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp')
    if rmw != 'rmw_fastrtps_cpp':
        yield Finding(WARN, 'middleware', rmw, 'tried is rmw_fastrtps_cpp only')
    else:
        yield Finding(OK, 'middleware', rmw)
    if given := users_profile(environment):
        yield Finding(WARN, 'transport', f'profiles {given} in place of transport.xml',
                      'see that it has shared memory for captures of 37 MB')
    else:
        yield Finding(OK, 'transport', "bpc's own profiles for its nodes")
    level = WARN if shared_memory < SHM_WARN else OK
    yield Finding(level, 'shared memory', f'{shared_memory / 1e6:.0f} MB free',
                  '' if level == OK else 'captures come late or not: make room in /dev/shm')
    reach = environment.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    yield Finding(OK, 'discovery', f'{reach}, domain {environment.get("ROS_DOMAIN_ID", "0")}')


def judge_extruder(error_names: str, position_uncertain: bool, velocity_known: bool,
                   flow_known: bool) -> Iterator[Finding]:
    """What the extruder says of itself."""
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
