"""A recording as the LBR stack makes it: joint states only, and the camera on the arm."""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np
import pytest
from sensor_msgs.msg import JointState
import yaml

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.config import BASE, FLANGE
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.robot.kinematics import JOINTS
from bpc_perception.files.hand_eye_file import save_hand_eye
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.recording.bag_writer import BagWriter
from bpc_perception.recording.inputs import load
from bpc_perception.recording.offline import measure_bag
from bpc_sim.doubles.rig import Rig
from bpc_sim.printer.arm import Arm
from bpc_sim.printer.messages import CAMERA_LATENCY_NS, extruder_message
from bpc_sim.printer.print_recording import START_NS
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_sim.printer.settings import node_parameters
from bpc_system_tests.parts.command_line import succeed
from bpc_system_tests.parts.print_comparison import compare, expect_the_truth, pixel_size
from bpc_system_tests.parts.ros_graph import own_domain

pytestmark = [pytest.mark.system, pytest.mark.ros]
RIG = Rig(SCENARIOS['line'](0.025), on_base=False)
CAPTURE_TIMES_S = 1.3, 2.0, RIG.job.duration  # the arm moves at the first two


def joint_state(arm: Arm, t: float, stamp_ns: int) -> JointState:
    angles = arm.joint_angles(RIG.job.flange_pose(t))
    message = JointState(name=[f'lbr_{joint}' for joint in JOINTS],
                         position=array('d', angles.tolist()))
    message.header.stamp = ns_to_stamp(stamp_ns)
    return message


@pytest.fixture(scope='module')
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording, with calibration and parameters beside it."""
    folder = tmp_path_factory.mktemp('arm') / 'print'
    names = {topics.JOINTS: '/lbr/joint_states'}
    arm = Arm()
    with BagWriter(folder) as writer:
        for name, kind in {**topics.CAMERA, topics.JOINTS: JointState,
                           topics.EXTRUSION: ExtrusionState}.items():
            writer.add_topic(names.get(name, f'/{name}'), topics.type_name(kind))
        for t in np.arange(0, RIG.job.duration + 0.5, 0.01).tolist():
            log_ns = START_NS + round(t * 1e9)
            writer.write('/lbr/joint_states', log_ns, joint_state(arm, t, log_ns))
            writer.write(f'/{topics.EXTRUSION}', log_ns, extruder_message(RIG.job, t, log_ns))
        for number, t in enumerate(CAPTURE_TIMES_S):
            stamp_ns = START_NS + round(t * 1e9)
            capture = RIG.seen_by_camera(t).capture(t, number, stamp_ns)
            for name, message in zip(topics.CAMERA, capture_to_messages(capture), strict=True):
                writer.write(f'/{name}', stamp_ns + CAMERA_LATENCY_NS, message)
    save_hand_eye(folder / 'hand_eye.calib', HandEye(False, RIG.T_parent_camera), 'arm', BASE,
                  FLANGE, 'camera_optical_frame')
    pose = {'pose': {'source': 'joint_states', 'robot': 'lbr_med_7'}}
    (folder / 'params.yaml').write_text(yaml.safe_dump(
        {'/**': {'ros__parameters': pose}, **node_parameters(RIG.job, 0.002)}))
    return folder


@pytest.mark.accuracy
def test_it_is_measured_as_it_is(bag: Path) -> None:
    given = load(bag, None, None)
    results = list(measure_bag(given.bag, given.hand_eye, given.thickness, given.recorder))
    assert [result.refusal for result in results] == [''] * len(CAPTURE_TIMES_S)
    profile = results[-1].profile
    assert profile is not None
    seen = RIG.seen_by_camera(CAPTURE_TIMES_S[-1])
    compared = compare(profile, seen)
    assert compared.s.min() < 1e-3
    assert compared.s.max() > RIG.job.length - 1e-3
    expect_the_truth(compared, pixel_size(seen))


def test_replay_gives_what_measure_does(bag: Path, tmp_path: Path) -> None:
    succeed('measure', bag, '--out', tmp_path / 'measured')
    with own_domain():
        succeed('replay', bag, '--rate', 2, '--out', tmp_path / 'replayed')
    measured, replayed = ((tmp_path / name / 'profile.csv').read_bytes()
                          for name in ('measured', 'replayed'))
    assert measured.count(b'MEASURED') > 100  # of 250; the rest is gap
    assert replayed == measured
