"""What a live print leaves in its folder, whoever is killed meanwhile."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import json
import os
from pathlib import Path
import signal
import subprocess
import time
from typing import Any

import numpy as np
import pytest
from std_srvs.srv import Trigger

from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.recording.print_folder import print_folder
from bpc_perception.runtime.child_processes import Nodes
from bpc_sim.printer.print_job import PrintJob
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_sim.printer.settings import write_settings
from bpc_system_tests.parts.command_line import (
    command,
    OUTPUTS,
    PATIENCE_S,
    refusal,
    run,
    SAMPLE,
    succeed,
)
from bpc_system_tests.parts.process_tree import alive, descendants
from bpc_system_tests.parts.ros_graph import Listener, listening, own_domain

pytestmark = [pytest.mark.system, pytest.mark.ros]
SCENARIO, SPEED_M_PER_S, TARGET_M = 'spiral_gaps', 0.002, 2e-3  # longer than the tests take
CAMERA_RATE_HZ = 2.0


@dataclass
class LivePrints:
    """A printer, and ``bpc live`` beside it.

    Attributes:
        process: of ``bpc live``.
        prints: folder of the prints.
        listener, nodes: of the graph, and of the printer.
    """

    process: subprocess.Popen[str]
    prints: Path
    listener: Listener
    nodes: Nodes

    def pid(self, module: str) -> int:
        """Return the process of a node that `bpc live` has started."""
        found = [pid for pid in descendants([self.process.pid]) if f'nodes.{module}\0' in Path(
            f'/proc/{pid}/cmdline').read_text()]
        return found[0]

    def wait(self, condition: Any) -> None:
        self.listener.wait(condition, self.nodes)

    def folder(self) -> Path:
        """Return the folder of the newest print."""
        return print_folder(self.prints, self.listener.profiles[-1].print_id)

    def captures(self, folder: Path) -> int:
        """Return how many captures the summary in a folder lists; 0 = there is none."""
        summary = folder / 'summary.json'
        return len(json.loads(summary.read_text())['captures']) if summary.exists() else 0


def write_design(file: Path, job: PrintJob) -> Path:
    """Write where a job lays ink, in the robot base frame."""
    times = np.arange(job.dwell_before, job.duration - job.dwell_after, 0.1)
    on = job.extruding(times)
    stroke = np.where(on, np.cumsum(np.diff(on, prepend=False) & on), 0)
    rows = [f'{x},{y},{z},{number},{1e3 * TARGET_M}' for (x, y, z), number in zip(
        (1e3 * job.tip(times)).tolist(), stroke.tolist(), strict=True)]
    file.write_text('\n'.join(['x_mm,y_mm,z_mm,stroke,width_mm', *rows, '']))
    return file


@pytest.fixture(scope='module')
def live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LivePrints]:
    folder = tmp_path_factory.mktemp('saved')
    planned = SCENARIOS[SCENARIO](SPEED_M_PER_S)
    settings = write_settings(planned, TARGET_M, folder)
    design = write_design(folder / 'my design.csv', planned)
    with settings.parameters.open('a') as file:
        file.write('results_writer:\n  ros__parameters:\n    period: 1.0\n'
                   "/**/thickness:\n  ros__parameters:\n    design.place: '0,0,0,0'\n")
    prints = folder / 'my prints #1'
    job = {'scenario': SCENARIO, 'speed': SPEED_M_PER_S}
    with (own_domain() as domain, listening(domain) as listener,
          Nodes(settings.parameters) as nodes,
          subprocess.Popen(
              command('live', '--handeye', settings.hand_eye, '--params', settings.parameters,
                      '--out', prints, '--design', design),
              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
              # Nothing can be written but the print.
              env=os.environ | {'HOME': '/proc/nowhere', 'XDG_STATE_HOME': '/proc/nowhere',
                                'ROS_LOG_DIR': '/proc/nowhere'}) as process):
        try:
            names = {'thickness', 'path_recorder', 'bag_recorder', 'results_writer'}
            listener.wait(lambda: names <= set(listener.node.get_node_names()), nodes)
            job['start_time_ns'] = time.time_ns() + 10**9
            nodes.start('bpc_sim.nodes.robot', **job)
            nodes.start('bpc_sim.nodes.extruder', **job)
            nodes.start('bpc_perception.nodes.camera_driver', back_end='synthetic',
                        rate=CAMERA_RATE_HZ, **job)
            yield LivePrints(process, prints, listener, nodes)
        finally:
            process.kill()
            process.communicate(timeout=PATIENCE_S)


def test_its_results_are_there_while_it_grows(live: LivePrints) -> None:
    live.wait(lambda: live.listener.profiles and live.captures(live.folder()))
    assert {file.name for file in live.folder().iterdir()
            if not file.name.startswith('.')} == {*OUTPUTS, 'recording'}
    known = live.captures(live.folder())
    live.wait(lambda: live.captures(live.folder()) > known)
    assert (live.folder() / 'recording' / 'design.csv').exists()
    found = json.loads((live.folder() / 'summary.json').read_text())['design']
    assert found['nozzle_off']['most_mm'] < 0.1
    assert not [each for each in found['missing'] if each['presence'] == 'SKIPPED']


def test_nobody_begins_beside_it(live: LivePrints) -> None:
    said = refusal('live', '--handeye', SAMPLE / 'hand_eye.calib', '--params',
                   SAMPLE / 'params.yaml')
    assert said.startswith(f'bpc: ROS domain {os.environ["ROS_DOMAIN_ID"]}: expected no other '
                           f'suite in it, found process {live.process.pid} (bpc live --handeye')
    assert live.process.poll() is None


@pytest.mark.parametrize('module', ['results_writer', 'bag_recorder'])
def test_who_keeps_it_is_killed_and_it_is_kept_on(live: LivePrints, module: str) -> None:
    folder, profiles = live.folder(), len(live.listener.profiles)
    before = live.captures(folder)
    os.kill(live.pid(module), signal.SIGKILL)
    live.wait(lambda: module in live.listener.node.get_node_names())
    if module == 'bag_recorder':
        live.wait((folder / 'recording_2' / 'hand_eye.calib').exists)
    else:
        written = (folder / 'summary.json').stat().st_mtime_ns
        assert live.captures(folder) >= before
        live.wait(lambda: (folder / 'summary.json').stat().st_mtime_ns > written)
    assert len(live.listener.profiles) >= profiles
    assert live.process.poll() is None


def test_the_next_print_has_a_folder_of_its_own(live: LivePrints) -> None:
    first = live.folder()
    client = live.listener.node.create_client(Trigger, 'path_recorder/start')
    live.wait(client.service_is_ready)
    client.call_async(Trigger.Request())
    live.wait(lambda: live.folder() != first and live.captures(live.folder()))
    assert (live.folder() / 'recording' / 'hand_eye.calib').exists()
    # The first one is complete.
    assert (first / 'recording_2' / 'metadata.yaml').exists()
    assert live.captures(first)


def test_it_is_whole_after_live_was_killed(live: LivePrints) -> None:
    nodes = descendants([live.process.pid])
    folder, known = live.folder(), len(live.listener.advice)
    live.wait(lambda: len(live.listener.advice) > known)
    newest_ns = stamp_to_ns(live.listener.advice[-1].header.stamp)
    live.process.kill()
    live.process.wait()
    live.wait(lambda: not any(map(alive, nodes)))
    # What they keep they have completed.
    assert (folder / 'recording' / 'metadata.yaml').exists()
    captures = json.loads((folder / 'summary.json').read_text())['captures']
    assert captures[-1]['stamp_ns'] >= newest_ns
    folders = sorted(folder for folder in live.prints.iterdir() if folder.is_dir())
    assert len(folders) == 2
    for folder in folders:
        out = folder / 'again'
        ended = run('measure', folder, '--out', out)
        assert ended.returncode == 0, ended.stderr
        # Two recordings of one print are one.
        again, before = (json.loads((place / 'summary.json').read_text('utf-8'))
                         for place in (out, folder))
        assert again['print_id'] == before['print_id']
        assert live.captures(folder)
        assert {path.name for path in folder.iterdir()} >= OUTPUTS


@pytest.mark.usefixtures('ros_domain')
def test_a_simulated_print_leaves_what_its_recording_measures(tmp_path: Path) -> None:
    said = succeed('sim', '--scenario', 'line', '--speed', 25, '--rate', 1, '--json',
                   folder=tmp_path)
    folder, = (tmp_path / 'prints').iterdir()
    files = [json.loads(line)['path'] for line in said.splitlines()
             if json.loads(line)['event'] == 'file']
    assert files == [str(folder.relative_to(tmp_path) / name)
                     for name in sorted({*OUTPUTS, 'recording'})]
    succeed('measure', folder / 'recording', '--out', tmp_path / 'again')
    assert (tmp_path / 'again' / 'profile.csv').read_bytes() == (
        folder / 'profile.csv').read_bytes()


def test_a_file_where_the_prints_belong_is_refused(tmp_path: Path) -> None:
    file = tmp_path / 'prints'
    file.touch()
    ended = run('sim', '--out', file)
    assert ended.returncode == 2
    assert f'{file}: expected a folder for the prints' in ended.stderr
