"""A print on a rig of device doubles, through ``bpc live``: every device in its own protocol.

The arm publishes its joints as the LBR stack does, the Tic is on a pseudo-terminal, and the Zivid
camera is behind a stand-in for the vendor's package. The camera is fixed beside the robot, with
poses from joint states; or it is in the robot's hand and moves with it, with poses from the
controller's state.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
import os
from pathlib import Path
import re
import signal
import subprocess
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

from bpc_perception.core.config import BASE, FLANGE
from bpc_perception.core.profile import Status
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.files.hand_eye_file import save_hand_eye
from bpc_perception.messages.profile import profile_from_message
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.runtime.child_processes import Nodes
from bpc_sim.doubles import rig as doubles
from bpc_sim.doubles.extruder import TicDouble, Wire
from bpc_sim.printer.print_job import SYRINGE_BORE_M
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_system_tests.parts.command_line import command, run
from bpc_system_tests.parts.lbr_messages import lbr_messages
from bpc_system_tests.parts.print_comparison import (
    compare,
    expect_the_truth,
    MILLIMETRE_M,
    pixel_size,
)
from bpc_system_tests.parts.ros_graph import Listener, listening, own_domain

pytestmark = [pytest.mark.system, pytest.mark.ros]
SCENARIO, SPEED_M_PER_S = 'line', 0.01  # 50 mm in 5 s
# Until arm and camera run; the next one is tried if a delay was too short.
START_DELAYS_S = 6.0, 20.0, 60.0
LEAD_M, STEPS_PER_TURN = 1e-3, 200
NOZZLE_OFFSET_M = [0.0, 0.0, 0.15]
REMAPPINGS = {'joint_states': '/lbr/joint_states', 'lbr_state': '/lbr/state'}


@dataclass
class Running:
    """The rig while it runs, and the messages heard from it."""

    rig: doubles.Rig
    start_ns: int
    listener: Listener
    nodes: Nodes
    wire: Wire
    plug: Path
    prints: Path


def cell(folder: Path) -> list[object]:
    """Return the options of a command for this printer."""
    return ['--handeye', folder / 'cell.calib', '--params', folder / 'cell.yaml',
            *(item for topic, other in REMAPPINGS.items()
              for item in ('--remap', f'{topic}:={other}'))]


@contextmanager
def bpc_live(folder: Path) -> Iterator[None]:
    """Run ``bpc live`` with the settings in a folder during the block; it has to end well."""
    live = subprocess.Popen(
        command('live', *cell(folder), '--out', folder / 'prints'),
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield
    finally:
        live.send_signal(signal.SIGINT)
        said, complaints = live.communicate(timeout=30)
    assert live.returncode == 0, complaints
    assert 'Waiting for captures' in said


@contextmanager
def environment(**values: str) -> Iterator[None]:
    """Set environment variables for the processes that start in the block."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


def write_settings(folder: Path, rig: doubles.Rig, source: str) -> None:
    """Write the files that a user has for this printer."""
    save_hand_eye(folder / 'cell.calib', HandEye(rig.on_base, rig.T_parent_camera), 'cell', BASE,
                  FLANGE, 'zivid_optical_frame')
    bridge = {'back_end': 'tic', 'port': str(folder / 'ttyACM0'),
              'plunger': {'lead': LEAD_M, 'bore': SYRINGE_BORE_M}}
    (folder / 'cell.yaml').write_text(yaml.safe_dump({
        '/**': {'ros__parameters': {'pose': {'source': source, 'robot': 'lbr_med_7'}}},
        'path_recorder': {'ros__parameters': {'nozzle_offset': NOZZLE_OFFSET_M}},
        'thickness': {'ros__parameters': {'advice.target_thickness': 0.002}},
        'extruder_bridge': {'ros__parameters': bridge}}))
    (folder / 'vendor' / 'zivid').mkdir(parents=True)
    (folder / 'vendor' / 'zivid' / '__init__.py').write_text(
        'from bpc_sim.doubles.rig import install\n\ninstall()\n')


@pytest.fixture(scope='module', params=[('eye_on_base', 'joint_states'),
                                       ('eye_in_hand', 'lbr_state')], ids='-'.join)
def running(request: pytest.FixtureRequest,
            tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp('rig')
    mount, source = request.param
    rig = doubles.Rig(SCENARIOS[SCENARIO](SPEED_M_PER_S), mount == 'eye_on_base')
    write_settings(folder, rig, source)
    messages = lbr_messages(folder / 'lbr') if source == 'lbr_state' else {}
    plug = folder / 'plugged'
    plug.touch()
    start_ns = 2**62  # not yet

    def motion(now: float) -> tuple[float, float]:
        t = now - start_ns * 1e-9
        steps_per_m = STEPS_PER_TURN / LEAD_M
        return (float(rig.job.plunger_position(t)) * steps_per_m,
                float(rig.job.plunger_velocity(t)) * steps_per_m)

    variables = {doubles.SCENARIO_VARIABLE: SCENARIO, doubles.SPEED_VARIABLE: str(SPEED_M_PER_S),
                 doubles.PLUG_VARIABLE: str(plug), doubles.MOUNT_VARIABLE: mount,
                 'XDG_STATE_HOME': str(folder / 'state')}
    variables |= messages
    variables['PYTHONPATH'] = ':'.join((str(folder / 'vendor'), variables.get(
        'PYTHONPATH', os.environ.get('PYTHONPATH', ''))))
    with own_domain() as domain, listening(domain) as listener, environment(**variables), \
            Wire(TicDouble(motion), folder / 'ttyACM0', lines=False) as wire, \
            Nodes(folder / 'cell.yaml', remappings=REMAPPINGS) as nodes, bpc_live(folder):
        nodes.start('bpc_perception.nodes.extruder_bridge')
        expect(listener, nodes, 'thickness', 'path_recorder', 'extruder_bridge', 'bag_recorder',
               'results_writer')
        start_ns = start_arm_and_camera(listener, nodes)
        yield Running(rig, start_ns, listener, nodes, wire, plug, folder / 'prints')


def start_arm_and_camera(listener: Listener, nodes: Nodes) -> int:
    """Start arm and camera in time; return when the print begins [ns].

    By then the path recorder hears the arm.
    """
    for delay in START_DELAYS_S:
        start_ns = time.time_ns() + round(delay * 1e9)
        poses = count_taken(listener, 'poses')
        nodes.start('bpc_sim.nodes.arm', scenario=SCENARIO, speed=SPEED_M_PER_S,
                    start_time_ns=start_ns)
        with environment(**{doubles.START_VARIABLE: str(start_ns)}):
            nodes.start('bpc_perception.nodes.camera_driver', back_end='zivid', rate=1.0)
        expect(listener, nodes, 'synthetic_arm', 'camera_driver')
        listener.wait(partial(more_taken, listener, 'poses', poses), nodes)
        if time.time_ns() < start_ns:
            return start_ns
        for name in ('arm', 'camera_driver'):
            nodes.kill(name)
    raise AssertionError(f'expected arm and camera to run within {START_DELAYS_S[-1]:g} s')


def expect(listener: Listener, nodes: Nodes, *names: str) -> None:
    """Wait until nodes of these names are there."""
    listener.wait(lambda: set(names) <= set(listener.node.get_node_names()), nodes)


def count_taken(listener: Listener, what: str) -> int:
    """Return how many poses, or extrusion states, the path recorder has taken."""
    counts = [int(item.value) for message in listener.heard['/diagnostics']
              for status in message.status if status.name == 'path_recorder'
              for item in status.values if item.key == what]
    return max(counts, default=0)


def more_taken(listener: Listener, what: str, than: int) -> bool:
    return count_taken(listener, what) > than


def stamps(running: Running) -> list[float]:
    """Return when the captures of all profiles so far were taken [s after the job's start]."""
    return [(stamp_to_ns(profile.header.stamp) - running.start_ns) * 1e-9
            for profile in running.listener.profiles]


@pytest.mark.accuracy
def test_the_print_is_measured_as_it_is(running: Running) -> None:
    listener, rig = running.listener, running.rig
    listener.wait(lambda: stamps(running) and stamps(running)[-1] > rig.job.duration,
                  running.nodes)
    taken = stamps(running)
    seen = rig.seen_by_camera(taken[-1])
    compared = compare(profile_from_message(listener.profiles[-1]), seen)
    assert compared.s.min() < 1e-3
    assert compared.s.max() > rig.job.length - 1e-3
    expect_the_truth(compared, pixel_size(seen))
    # It was also measured while it was printed.
    assert sum(1.0 < t < rig.job.end_of_path for t in taken) >= 2
    flow_rate = max(listener.heard['deposition_path'][-1].flow_rate)
    assert flow_rate == pytest.approx(float(rig.job.flow_rate(2.0)), rel=0.01)


def test_its_recording_is_measured_without_further_files(running: Running) -> None:
    """The recording contains poses of this robot, calibration and parameters.

    It is measured while it is still written.
    """
    recording, = running.prints.glob('*/recording')
    out = running.prints / 'results'
    ended = run('measure', recording, '--out', out)
    assert ended.returncode == 0, ended.stderr
    # The file has no end yet, and the topics of the newest capture may not all be there.
    expected = re.compile('torn, read up to|of one stamp')
    assert all(map(expected.search, ended.stderr.splitlines())), ended.stderr
    table = np.genfromtxt(out / 'profile.csv', delimiter=',', names=True, dtype=None,
                          encoding='utf-8')
    found: Any = SimpleNamespace(
        points=np.stack([table[f'{axis}_mm'] for axis in 'xyz'], axis=1) * MILLIMETRE_M,
        thickness=table['thickness_mm'] * MILLIMETRE_M,
        status=np.array([Status[name] for name in table['status']]))
    compared = compare(found, running.rig.seen_by_camera(stamps(running)[-1]))
    assert compared.s.max() > running.rig.job.length - 1e-3
    expect_the_truth(compared, pixel_size(running.rig.job))


def test_a_camera_that_was_unplugged_measures_again(running: Running) -> None:
    listener = running.listener
    running.plug.unlink()
    listener.wait(lambda: any('zivid: expected' in text
                              for text in listener.complaints('camera_driver')), running.nodes)
    count = len(listener.profiles)
    running.plug.touch()
    listener.wait(lambda: len(listener.profiles) > count, running.nodes)


def test_an_extruder_that_was_unplugged_is_heard_again(running: Running) -> None:
    listener = running.listener
    running.wire.unplug()
    listener.wait(lambda: any('expected the extruder, found' in text
                              for text in listener.complaints('extruder_bridge')), running.nodes)
    listener.wait(lambda: any('extrusion_state: expected messages' in text
                              for text in listener.complaints('path_recorder')), running.nodes)
    running.wire.plug()
    states = count_taken(listener, 'extrusion states')
    listener.wait(lambda: more_taken(listener, 'extrusion states', states + 20), running.nodes)


def test_a_robot_that_was_away_is_followed_again(running: Running) -> None:
    """Meanwhile nothing is measured by a camera in the hand; beside the robot it goes on."""
    def missed() -> bool:
        return any(f'{source}: expected messages' in text
                   for text in listener.complaints('path_recorder')
                   for source in ('joint_states', 'lbr_state'))

    listener = running.listener
    robot = running.nodes.pid('arm')
    os.kill(robot, signal.SIGSTOP)
    try:
        if running.rig.on_base:
            count = len(listener.profiles)
            listener.wait(lambda: len(listener.profiles) > count and missed(), running.nodes)
        else:
            listener.wait(lambda: missed() and any(
                'expected poses around the capture' in text
                for text in listener.complaints('thickness')), running.nodes)
    finally:
        os.kill(robot, signal.SIGCONT)
    count = len(listener.profiles)
    listener.wait(lambda: len(listener.profiles) > count, running.nodes)


def supervised(running: Running, name: str) -> dict[str, str]:
    """Return what `bpc live` last said of one of its nodes on /diagnostics."""
    found = [status for message in running.listener.heard['/diagnostics']
             for status in message.status if status.name == f'supervisor: {name}']
    return {value.key: value.value for value in found[-1].values} if found else {}


@pytest.mark.parametrize('name', ['thickness', 'path_recorder'])
def test_a_node_that_was_killed_goes_on_with_the_same_print(running: Running,
                                                            name: str) -> None:
    listener = running.listener
    listener.wait(lambda: supervised(running, name), running.nodes)
    before, known = supervised(running, name), listener.profiles[-1]
    os.kill(int(before['pid']), signal.SIGKILL)
    listener.wait(lambda: supervised(running, name)['deaths'] != before['deaths']
                  and supervised(running, name)['pid'] != before['pid'], running.nodes)
    assert 'ended with status -9' in supervised(running, name)['last death']
    # The robot moves its tip little or not at all now: nothing of the print is lost.
    killed_ns = time.time_ns()
    listener.wait(lambda: stamp_to_ns(listener.profiles[-1].header.stamp) > killed_ns,
                  running.nodes)
    profile = listener.profiles[-1]
    assert profile.print_id == known.print_id
    # Only later points tell whether the nozzle was lifting at the last point.
    settled = known.arc_length[:-1]
    assert profile.arc_length[:len(settled)] == settled
