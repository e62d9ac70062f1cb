"""Each fault of a rig is named before a print, with what to do."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from bpc_perception.cli.parts.preflight import (
    FAIL,
    Finding,
    Heard,
    judge_calibration,
    judge_design,
    judge_disk,
    judge_domain,
    judge_exposure,
    judge_extruder,
    judge_stamps,
    judge_target,
    judge_topic,
    judge_transport,
    OK,
    WARN,
)
from bpc_perception.core.capture.exposure import Exposure
from bpc_perception.core.config import DesignConfig

POSE = 'geometry_msgs/msg/PoseStamped'


def heard(kind: str = 'pose', rate: float = 100.0, delay: float = 0.01, seconds: float = 5.0,
          **changes: object) -> Heard:
    """A topic on which all is well but for the changes."""
    arrivals = np.arange(0, seconds, 1 / rate).tolist() if rate else []
    made = Heard('/topic', kind, POSE, [POSE], 1, False, arrivals, [delay] * len(arrivals))
    for name, value in changes.items():
        setattr(made, name, value)
    return made


def levels(findings: Iterable[Finding]) -> set[str]:
    return {finding.level for finding in findings}


@pytest.mark.parametrize('kind', ['pose', 'camera', 'extruder'])
def test_all_is_well(kind: str) -> None:
    assert levels(judge_topic(heard(kind))) == {OK}


@pytest.mark.parametrize(('fault', 'level', 'words'), [
    (heard(publishers=0), FAIL, 'nobody publishes it'),
    (heard(types=['geometry_msgs/msg/Pose']), FAIL, f'is geometry_msgs/msg/Pose, expected {POSE}'),
    (heard(publishers=2), FAIL, '2 publish it'),
    (heard('camera', best_effort=True), FAIL, 'best effort'),
    (heard(rate=0), FAIL, 'nothing came'),
    (heard('camera', rate=0), WARN, 'no capture came'),
    (heard(rate=5), FAIL, '5.0 Hz'),
    (heard(rate=20), WARN, '20.0 Hz'),
    (heard('extruder', rate=2), FAIL, '2.0 Hz'),
    (heard(problems=['pose: expected frame a, found b']), FAIL, 'expected frame a, found b'),
    (heard(delay=-0.5), FAIL, '500 ms ahead of this computer'),
    (heard(delay=0.3), WARN, '300 ms late'),
    (heard(delay=40.0), FAIL, '40000 ms late'),
    (heard('camera', delay=0.5), OK, '500 ms late'),
    (heard('camera', delay=3.0), WARN, '3000 ms late'),
    (heard(delays=[]), WARN, 'no stamps'),
    (heard(delays=[0.01, 3.0, 3.0]), WARN, '3000 ms late'),
])
def test_a_fault_is_named(fault: Heard, level: str, words: str) -> None:
    found = [finding for finding in judge_topic(fault) if words in finding.found]
    assert [finding.level for finding in found] == [level]
    assert level == OK or found[0].todo


def test_a_busy_computer_is_told_from_a_clock_that_is_behind() -> None:
    found, = (finding for finding in judge_topic(heard(delays=[0.01, *[3.0] * 9]))
              if 'clock' in finding.subject)
    assert 'busy computer' in found.todo
    found, = (finding for finding in judge_topic(heard(delays=[2.9, *[3.0] * 9]))
              if 'clock' in finding.subject)
    assert (found.level, 'chrony' in found.todo) == (FAIL, True)


def test_a_best_effort_pose_is_heard() -> None:
    assert levels(judge_topic(heard(best_effort=True))) == {OK}


def test_settings() -> None:
    assert judge_calibration(True, 3).level == OK
    assert judge_calibration(True, 300).level == WARN
    assert judge_target(0.002).level == OK
    assert judge_target(0).level == WARN
    assert [judge_disk('.', free).level for free in (1e8, 5e9, 5e10)] == [FAIL, WARN, OK]


@pytest.mark.parametrize(('stamps', 'level'), [
    ([[1, 2], [2, 3], [2]], set()), ([[1, 2], [3], [2]], {FAIL}), ([[1], [], [2]], set()),
    ([], set())])
def test_parts_of_captures_need_one_stamp(stamps: list[list[int]], level: set[str]) -> None:
    """Where a part never came, that says more."""
    assert levels(judge_stamps(stamps)) == level


def test_a_table_of_targets_is_a_target(tmp_path: Path) -> None:
    file = tmp_path / 'targets.csv'
    assert judge_target(0, str(file)).level == FAIL
    file.write_text('arc_length_mm,thickness_mm\n0,1.5\n100,2\n')
    found = judge_target(0, str(file))
    assert (found.level, '1.5 to 2 mm' in found.found) == (OK, True)
    file.write_text('arc_length_mm,thickness_mm\n0,-1\n')
    assert judge_target(0.002, str(file)).level == FAIL


def test_transport() -> None:
    assert levels(judge_transport({}, 1e9)) == {OK}
    assert WARN in levels(judge_transport({'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'}, 1e9))
    assert WARN in levels(judge_transport({'FASTRTPS_DEFAULT_PROFILES_FILE': 'my.xml'}, 1e9))
    assert WARN in levels(judge_transport({}, 6.4e7))  # what a container usually has


def test_extruder() -> None:
    assert levels(judge_extruder('', False, True, True)) == {OK}
    assert levels(judge_extruder('low VIN', False, True, True)) == {FAIL}
    assert levels(judge_extruder('', True, True, True)) == {WARN}
    assert levels(judge_extruder('', False, True, False)) == {WARN}
    assert levels(judge_extruder('', True, True, False)) == {WARN}


def test_an_extruder_that_tells_only_whether_ink_flows_is_not_sent_home() -> None:
    found, = judge_extruder('', True, False, False)
    assert (found.level, 'home' in found.todo) == (WARN, False)
    assert 'bool' in found.todo


@pytest.mark.parametrize(('clipped', 'bright', 'level', 'todo'), [
    (0.0, 230.0, OK, ''), (0.04, 255.0, OK, ''), (0.2, 255.0, WARN, 'expose less'),
    (0.0, 40.0, WARN, 'expose more')])
def test_how_a_picture_is_exposed_is_judged(clipped: float, bright: float, level: str,
                                            todo: str) -> None:
    finding = judge_exposure(Exposure(clipped, bright))
    assert (finding.level, finding.subject) == (level, 'exposure')
    assert f'{clipped:.0%} of the picture is overexposed' in finding.found
    assert todo in finding.todo


def test_who_is_in_the_domain_already_is_named() -> None:
    assert judge_domain('7', '').level == OK
    taken = judge_domain('7', 'process 12 (bpc live)')
    assert (taken.level, taken.found) == (FAIL, 'in use by process 12 (bpc live)')
    assert 'ROS_DOMAIN_ID' in taken.todo


def test_a_design_is_read_before_a_print(tmp_path: Path) -> None:
    file = tmp_path / 'line.csv'
    file.write_text('x_mm,y_mm,z_mm\n0,0,0\n20,0,0\n')
    found = judge_design(DesignConfig(str(file)))
    assert (found.level, found.found) == (OK, f'1 strokes, 20 mm, in {file}')
    assert judge_design(DesignConfig(str(file), place='1,2')).level == FAIL
    assert judge_design(DesignConfig(str(tmp_path / 'no.gcode'))).level == FAIL
