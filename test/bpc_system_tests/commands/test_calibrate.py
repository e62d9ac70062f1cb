"""``bpc calibrate`` on recordings of a robot with known nozzle and camera."""

from __future__ import annotations

from pathlib import Path
import re
import shutil

from geometry_msgs.msg import PoseStamped
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState
import yaml

from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.board import Board
from bpc_perception.core.robot.kinematics import flange_pose, JOINTS
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.poses.pose import pose_to_message
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.recording.bag_writer import BagWriter
from bpc_sim.scene.calibration_rig import CalibrationRig
from bpc_system_tests.parts.command_line import refusal, run, SAMPLE, succeed

pytestmark = [pytest.mark.system, pytest.mark.ros]
START_NS, SECOND_NS = 1_790_000_000 * 10**9, 10**9
BOARD = Board(9, 6, 0.02, 0.015)
BASE = 'lbr_link_0'


def tip_in_one_spot(rng: np.random.Generator) -> list[Array]:
    """Return flange poses around a nozzle of 12, -4, 151 mm; the tip slips by 0.02 mm."""
    poses = []
    for turn in 0.4 * np.array(((0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0),
                                (1, 1, 1))):
        T = np.eye(4)
        T[:3, :3] = (Rotation.from_rotvec((np.pi, 0, 0)) * Rotation.from_rotvec(turn)).as_matrix()
        T[:3, 3] = np.array((0.55, 0.1, 0.02)) - T[:3, :3] @ (0.012, -0.004, 0.151)
        T[:3, 3] += 2e-5 * rng.standard_normal(3)
        poses.append(T)
    return poses


def stand_and_go(poses: list[Array]) -> list[tuple[int, Array]]:
    """Return stamps and poses of a robot that stops in each pose, at 50 Hz.

    It stands for 1.5 s in each pose and takes 0.5 s to the next.
    """
    found = []
    for index, pose in enumerate(poses):
        following = poses[min(index + 1, len(poses) - 1)]
        turn = Rotation.from_matrix(pose[:3, :3].T @ following[:3, :3]).as_rotvec()
        for tick in range(100):
            share = max(0.0, (tick - 75) / 25)
            T = pose.copy()
            T[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(share * turn).as_matrix()
            T[:3, 3] = (1 - share) * pose[:3, 3] + share * following[:3, 3]
            T[2, 3] += 0.05 * np.sin(np.pi * share)
            found.append((START_NS + (2 * index * 50 + tick) * SECOND_NS // 50, T))
    return found


def test_nozzle(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/end_effector_pose', topics.type_name(PoseStamped))
        for stamp_ns, pose in stand_and_go(tip_in_one_spot(np.random.default_rng(0))):
            bag.write('/end_effector_pose', stamp_ns, pose_to_message(stamp_ns, BASE, pose))
    text = succeed('calibrate', 'nozzle', tmp_path / 'bag')
    assert text.startswith('6 poses')
    # The output is a parameter file.
    found = yaml.safe_load(text[text.index('path_recorder:'):])
    offset = found['path_recorder']['ros__parameters']['nozzle_offset']
    np.testing.assert_allclose(offset, (0.012, -0.004, 0.151), atol=1e-4)
    residual = re.search(r'residual ([\d.]+) mm \(root mean square\)', text)
    assert residual is not None
    assert 0 < float(residual[1]) < 0.06
    assert 'WARN' not in text


def test_nozzle_from_joints_that_stand_in_one_pose_is_refused(tmp_path: Path) -> None:
    angles = np.radians((0, 30, 0, -60, 0, 90, 0))
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/lbr/joint_states', topics.type_name(JointState))
        for tick in range(100):
            message = JointState(name=list(JOINTS), position=angles.tolist())
            message.header.stamp = ns_to_stamp(START_NS + tick * SECOND_NS // 50)
            bag.write('/lbr/joint_states', START_NS + tick * SECOND_NS // 50, message)
    (tmp_path / 'bag' / 'params.yaml').write_text(
        '/**: {ros__parameters: {pose: {source: joint_states, robot: lbr_med_7}}}\n')
    assert 'pivoting: expected 3 poses or more, found 1' in refusal(
        'calibrate', 'nozzle', tmp_path / 'bag')
    assert np.isfinite(flange_pose('lbr_med_7', angles)).all()


@pytest.fixture(scope='module', params=[True, False], ids=['eye_on_base', 'eye_in_hand'])
def board_bag(request: pytest.FixtureRequest,
              tmp_path_factory: pytest.TempPathFactory) -> tuple[CalibrationRig, Path]:
    """Eight captures of a board, a second after each stop; one while the robot moves."""
    rig = CalibrationRig(BOARD, request.param)
    folder = tmp_path_factory.mktemp('board') / 'bag'
    taken = list(rig.captures(8, START_NS + SECOND_NS, 2 * SECOND_NS))
    events = [(stamp_ns, pose_to_message(stamp_ns, BASE, pose))
              for stamp_ns, pose in stand_and_go([pose for pose, _ in taken])]
    with BagWriter(folder, compress=True) as bag:
        for name, kind in {topics.POSE: PoseStamped, **topics.CAMERA}.items():
            bag.add_topic(f'/{name}', topics.type_name(kind))
        for stamp_ns, message in events:
            bag.write('/end_effector_pose', stamp_ns, message)
        for index, (_, capture) in enumerate(taken):
            late = SECOND_NS * 3 // 4 if index == 3 else 0
            for name, message in zip(topics.CAMERA, capture_to_messages(capture), strict=True):
                message.header.stamp = ns_to_stamp(capture.stamp_ns + late)
                bag.write(f'/{name}', capture.stamp_ns + late + SECOND_NS // 10, message)
    return rig, folder


@pytest.mark.accuracy
def test_hand_eye(board_bag: tuple[CalibrationRig, Path], tmp_path: Path) -> None:
    rig, bag = board_bag
    mount = 'eye_on_base' if rig.on_base else 'eye_in_hand'
    out = tmp_path / 'cell.calib'
    options = ['--mount', mount, '--squares', '9x6', '--square-mm', 20, '--marker-mm', 15,
               '--out', out]
    text = succeed('calibrate', 'handeye', bag, *options)
    found = load_hand_eye(out)
    assert found.on_base == rig.on_base
    true, pose = rig.T_parent_camera, found.T_parent_camera
    assert np.linalg.norm(pose[:3, 3] - true[:3, 3]) < 2e-4
    turned = Rotation.from_matrix(pose[:3, :3].T @ true[:3, :3]).magnitude()
    assert np.degrees(turned) < 0.05
    assert 'capture 3: left out: pose: expected the flange to stand still' in text
    assert '7 captures of the board' in text
    assert 'WARN 7 captures are few' in text
    for method in ('Tsai-Lenz', 'Park', 'Horaud', 'Andreff', 'Daniilidis'):
        assert f'\n{method} ' in text
    assert 'expected a new file' in refusal('calibrate', 'handeye', bag, *options)


@pytest.mark.parametrize(('changed', 'words'), [
    (('--mount', 'eye'), 'expected eye_on_base or eye_in_hand'),
    (('--squares', '9'), 'expected two numbers as 9x6'),
    (('--corners', 'guess'), 'expected cloud or image'),
    (('--marker-mm', 21), 'expected markers smaller'),
])
def test_wrong_options_are_refused(tmp_path: Path, changed: tuple[object, object],
                                   words: str) -> None:
    options: dict[object, object] = {'--mount': 'eye_on_base', '--squares': '9x6',
                                     '--square-mm': 20, '--out': tmp_path / 'cell.calib'}
    options[changed[0]] = changed[1]
    assert words in refusal('calibrate', 'handeye', SAMPLE, *(
        part for option in options.items() for part in option))
    assert not list(tmp_path.iterdir())


def test_a_print_without_a_board_is_no_calibration(tmp_path: Path) -> None:
    ended = run('calibrate', 'handeye', SAMPLE, '--mount', 'eye_on_base', '--squares', '9x6',
                '--square-mm', 20, '--out', tmp_path / 'cell.calib')
    assert ended.returncode == 2
    assert 'expected 4 captures of the board or more, found 0' in ended.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.accuracy
def test_check_holds_on_the_sample() -> None:
    text = succeed('calibrate', 'check', SAMPLE)
    assert 'OK the calibration holds within 0.2 mm' in text


@pytest.mark.accuracy
@pytest.mark.parametrize('shift_mm', [(0.4, -0.3), (5.0, 0.0), (-3.0, 4.0)])
def test_check_finds_how_far_the_camera_was_moved(tmp_path: Path,
                                                  shift_mm: tuple[float, float]) -> None:
    file = tmp_path / 'moved.calib'
    shutil.copy(SAMPLE / 'hand_eye.calib', file)
    content = yaml.safe_load(file.read_text())
    content['transform']['translation']['x'] += shift_mm[0] * 1e-3
    content['transform']['translation']['y'] += shift_mm[1] * 1e-3
    file.write_text(yaml.safe_dump(content))
    ended = run('calibrate', 'check', SAMPLE, '--handeye', file)
    assert ended.returncode == 1
    assert 'FAIL the calibration is off by more than 0.2 mm' in ended.stdout
    found = re.search(r'mm: ([-+.\d]+), ([-+.\d]+), ([-+.\d]+) mm in the base', ended.stdout)
    assert found is not None
    # The bed is about a degree off level.
    np.testing.assert_allclose([float(value) for value in found.groups()], (*shift_mm, 0.0),
                               atol=0.02 + 0.02 * max(map(abs, shift_mm)))


@pytest.mark.accuracy
def test_of_strokes_in_one_direction_a_large_shift_is_told_roughly(tmp_path: Path) -> None:
    """Along them it is seen by their ends."""
    bag = SAMPLE.parent / 'strokes'
    file = tmp_path / 'moved.calib'
    content = yaml.safe_load((bag / 'hand_eye.calib').read_text())
    content['transform']['translation']['x'] += 5e-3
    file.write_text(yaml.safe_dump(content))
    ended = run('calibrate', 'check', bag, '--handeye', file)
    assert ended.returncode == 1
    assert 'FAIL the calibration is off' in ended.stdout
    assert 'the shift is known roughly only' in ended.stderr
    found = re.search(r'by ([.\d]+) ', ended.stdout)
    assert found is not None
    assert float(found.group(1)) == pytest.approx(5.0, abs=0.6)
