"""Recordings played over topics: the result is that without topics; looping; recording again."""

from __future__ import annotations

from itertools import pairwise
import json
from pathlib import Path
import signal
import time

import pytest
from rosbags.rosbag2 import Reader

from bpc_interfaces.msg import ThicknessProfile
from bpc_perception.messages import topics
from bpc_system_tests.parts.command_line import (
    OUTPUTS,
    PATIENCE_S,
    run,
    running,
    SAMPLE,
    SAMPLE_OUTPUTS,
    succeed,
)
from bpc_system_tests.parts.process_tree import alive, descendants
from bpc_system_tests.parts.ros_graph import listening, own_domain

pytestmark = [pytest.mark.system, pytest.mark.ros]

REPLAY_RATE = 6  # times real time: 600 poses a second
CAPTURES = 3  # in the short bag


@pytest.fixture(scope='module', params=['composed', 'separate', 'by parts'])
def replayed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The outputs of a replay of the sample bag."""
    folder = tmp_path_factory.mktemp('replay')
    options: list[str | Path] = ['--separate'] if request.param == 'separate' else []
    if request.param == 'by parts':  # all profiles but the first
        parameters = (SAMPLE / 'params.yaml').read_text().replace(
            'thickness:\n  ros__parameters:\n',
            'thickness:\n  ros__parameters:\n    longest_whole_profile: 0\n')
        (folder / 'params.yaml').write_text(parameters)
        options = ['--params', folder / 'params.yaml']
    with own_domain():
        succeed('replay', SAMPLE, '--rate', REPLAY_RATE, '--out', folder / 'out', *options)
    return folder / 'out'


def test_replay_leaves_what_measure_does(replayed: Path, measured_sample: Path) -> None:
    assert {file.name for file in replayed.iterdir()} == SAMPLE_OUTPUTS
    profile = (replayed / 'profile.csv').read_bytes()
    assert profile == (measured_sample / 'profile.csv').read_bytes()
    # The summaries differ only in the time that measuring took, and in how profiles were sent.
    summaries = [json.loads((folder / 'summary.json').read_text())
                 for folder in (replayed, measured_sample)]
    for summary in summaries:
        del summary['settings']['longest_whole_profile'], summary['fingerprint']
        for capture in (summary, *summary['captures']):
            assert capture.pop('processing_time_s') > 0
    assert summaries[0] == summaries[1]


def test_profile_grows_capture_by_capture(replayed: Path) -> None:
    captures = json.loads((replayed / 'summary.json').read_text())['captures']
    assert [capture['capture'] for capture in captures] == [0, 1, 2, 3, 4]
    samples = [capture['samples'] for capture in captures]
    assert samples == sorted(set(samples))
    assert samples[-1] == len((replayed / 'profile.csv').read_text().splitlines()) - 1


def whole_rounds(profiles: list[ThicknessProfile]) -> list[list[ThicknessProfile]]:
    """Return the profiles of each round, without rounds in which a capture was skipped."""
    starts = [index for index, profile in enumerate(profiles) if profile.capture == 0]
    rounds = [profiles[start:end] for start, end in pairwise([*starts, len(profiles)])]
    return [each for each in rounds if len(each) == CAPTURES]


def test_loop_forgets_and_measures_again(short_bag: Path, tmp_path: Path,
                                         ros_domain: int) -> None:
    out = tmp_path / 'out'
    with listening(ros_domain) as listener, running(
            'replay', short_bag, '--loop', '--rate', 2, '--out', out) as replay:
        def two_rounds() -> bool:
            assert replay.poll() is None, replay.communicate()
            return len(whole_rounds(listener.profiles)) >= 2

        listener.wait(two_rounds)
        interrupted = time.monotonic()
        replay.send_signal(signal.SIGINT)
        printed, complaints = replay.communicate(timeout=PATIENCE_S)
    assert time.monotonic() - interrupted < 10  # with all its nodes, on a busy machine
    assert (replay.returncode, complaints) == (0, ''), complaints
    assert {file.name for file in out.iterdir()} == OUTPUTS
    assert str(out / 'report.html') in printed

    first, second = whole_rounds(listener.profiles)[:2]
    for one, other in zip(first, second, strict=True):
        assert other.header == one.header
        assert other.capture == one.capture
        assert other.status == one.status
        assert other.thickness.tobytes() == one.thickness.tobytes()


def test_interrupted_replay_reports_what_was_played(tmp_path: Path, ros_domain: int) -> None:
    out = tmp_path / 'out'
    with listening(ros_domain) as listener, running(
            'replay', SAMPLE, '--rate', REPLAY_RATE, '--out', out) as replay:
        listener.wait(lambda: len(listener.advice) == 2)
        replay.send_signal(signal.SIGINT)
        _, complaints = replay.communicate(timeout=PATIENCE_S)
    assert (replay.returncode, complaints) == (0, '')
    captures = json.loads((out / 'summary.json').read_text())['captures']
    # The replay may have one capture less or more by then; none that was not played.
    assert [capture['capture'] for capture in captures] in ([0], [0, 1], [0, 1, 2])


@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGKILL])
def test_terminated_replay_ends_its_nodes(short_bag: Path, tmp_path: Path, ros_domain: int,
                                          number: signal.Signals) -> None:
    with listening(ros_domain) as listener, running(
            'replay', short_bag, '--loop', '--out', tmp_path / 'out') as replay:
        listener.wait(lambda: 'bag_player' in listener.node.get_node_names())
        nodes = descendants([replay.pid])
        assert len(nodes) == 3  # recorder, camera driver with thickness node, player
        replay.send_signal(number)
        replay.communicate(timeout=PATIENCE_S)
        # Names in the graph prove nothing: the name of a node that has ended may stay.
        listener.wait(lambda: not any(alive(pid) for pid in nodes))
        listener.wait(lambda: listener.node.count_publishers('/diagnostics') == 0)


@pytest.fixture(scope='module')
def recorded(short_bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the replay of the short bag, and two recordings of it.

    One recorder was ended by Ctrl-C, the other was killed and could not close its file.
    """
    folder = tmp_path_factory.mktemp('recorded')
    with (own_domain() as domain, listening(domain) as listener,
          running('record', '--out', folder / 'ended') as ended,
          running('record', '--out', folder / 'killed') as killed):
        listener.wait(lambda: all(listener.node.count_subscribers(name) == 2
                                  for name in topics.PRINT | topics.CAMERA))
        succeed('replay', short_bag, '--out', folder / 'replayed')
        assert ended.poll() is None, ended.communicate()
        assert killed.poll() is None, killed.communicate()
        killed.kill()
        ended.send_signal(signal.SIGINT)
        ended.communicate(timeout=PATIENCE_S)
        assert ended.returncode == 0
    return folder


def measure(bag: Path, short_bag: Path) -> bytes:
    """Measure a recording of the short bag, and return the profile.csv."""
    out = bag.parent / f'{bag.name}-measured'
    ended = run('measure', bag, '--handeye', short_bag / 'hand_eye.calib',
                '--params', short_bag / 'params.yaml', '--out', out)
    assert ended.returncode == 0, ended.stderr
    assert 'expected' not in ended.stderr
    return (out / 'profile.csv').read_bytes()


def test_recorded_replay_gives_the_same_profile(recorded: Path, short_bag: Path) -> None:
    bag = recorded / 'ended'
    assert measure(bag, short_bag) == (recorded / 'replayed' / 'profile.csv').read_bytes()
    with Reader(bag) as reader:
        counts = {each.topic: each.msgcount for each in reader.connections}
    with Reader(short_bag) as reader:
        played = {each.topic: each.msgcount for each in reader.connections}
    assert all(counts[f'/{name}'] == CAPTURES for name in topics.CAMERA)
    # A recorder may miss the first messages, before the print.
    assert all(0.85 * count < counts[topic] <= count for topic, count in played.items())
    assert counts[f'/{topics.PROFILE}'] == counts[f'/{topics.ADVICE}'] == CAPTURES
    assert counts[f'/{topics.PATH}'] > 5
    assert counts['/diagnostics'] > 5


def test_killed_recorder_leaves_what_it_heard(recorded: Path, short_bag: Path) -> None:
    bag = recorded / 'killed'
    assert not (bag / 'metadata.yaml').exists()
    # The print had ended more than a second before the kill: nothing of it is missing.
    assert measure(bag, short_bag) == (recorded / 'replayed' / 'profile.csv').read_bytes()
