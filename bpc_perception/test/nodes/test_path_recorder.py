"""The path recorder in process: poses and extruder states in, the path out, never a crash."""

from __future__ import annotations

from dataclasses import replace
import os
from pathlib import Path
import time
from typing import Any

import numpy as np
from perception_builders import pixel_path, START_NS
import pytest

from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.path.growing_path import GrowingPath

pytest.importorskip('rclpy')
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from node_builders import BASE, extrusion, flange_pose, print_line, recorder_bench
from rclpy.node import Node

from bpc_interfaces.msg import DepositionPathUpdate
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_from_message, path_to_nav
from bpc_perception.messages.stamps import stamp_to_ns
from bpc_perception.nodes.parts.path_follower import PathFollower
from bpc_perception.recording.bag import Bag
from bpc_perception.recording.path_journal import PathJournal
from bpc_perception.runtime.isolated_graph import Graph
from bpc_perception.runtime.run import EventsExecutor

pytestmark = pytest.mark.ros
REFUSED = f'refused: {topics.POSE}'


def test_poses_and_extruder_states_become_the_path_of_the_nozzle(graph: Any) -> None:
    message = print_line(recorder_bench(graph))[-1]
    assert message.header.frame_id == BASE
    assert stamp_to_ns(message.header.stamp) == START_NS
    path = path_from_message(message)
    assert len(path) > 100
    np.testing.assert_allclose(path.points[:, 0], 0.01 * path.time, atol=1e-9)
    np.testing.assert_allclose(path.points[:, 1:], 0, atol=1e-12)
    assert path.extruding.all()
    np.testing.assert_allclose(path.flow_rate, 5e-8)


def test_a_late_subscriber_still_gets_the_path(graph: Any) -> None:
    bench = recorder_bench(graph)
    known = print_line(bench)[-1]
    late: list[Any] = []
    graph.make(Node, 'late').create_subscription(
        topics.RESULTS[topics.PATH], topics.PATH, late.append, topics.PATH_QOS)
    bench.until(lambda: late)
    assert late[-1] == known


def test_updates_make_up_the_path(graph: Any) -> None:
    bench = recorder_bench(graph)
    updates = bench.listen(topics.PATH_UPDATE, DepositionPathUpdate, topics.UPDATE_QOS)
    whole = path_from_message(print_line(bench)[-1])
    growing = GrowingPath(whole.print_id, whole.start_ns)
    bench.until(lambda: updates[-1].path.complete_until == whole.complete_until)
    assert updates[0].first == 0
    assert max(len(update.path.x) for update in updates) < len(whole)
    assert all(growing.extend(update.first, path_from_message(update.path))
               for update in updates)
    np.testing.assert_array_equal(growing.path().points, whole.points)


def test_viewers_get_the_path_too(graph: Any) -> None:
    bench = recorder_bench(graph)
    viewed = bench.listen(topics.NAV_PATH, topics.RESULTS[topics.NAV_PATH], topics.PATH_QOS)
    message = print_line(bench)[-1]
    bench.until(lambda: viewed and len(viewed[-1].poses) == len(message.x))
    assert viewed[-1] == path_to_nav(path_from_message(message), BASE)


def test_start_and_stop_by_service(graph: Any) -> None:
    bench = recorder_bench(graph, path__auto=False, watch__maximum_lead=60.0)
    paths = bench.listen(topics.PATH, topics.RESULTS[topics.PATH], topics.PATH_QOS)
    assert not bench.call('path_recorder/stop').success
    started = bench.call('path_recorder/start')
    assert started.success
    bench.until(lambda: paths)
    start_ns = stamp_to_ns(paths[-1].header.stamp)
    assert paths[-1].print_id == started.message
    bench.send(topics.POSE, *(flange_pose(t, start_ns=start_ns) for t in np.arange(0, 3, 0.05)))
    bench.until(lambda: len(paths[-1].x) > 50)
    assert not paths[-1].finished
    assert bench.call('path_recorder/stop').success
    bench.send(topics.POSE, *(flange_pose(t, start_ns=start_ns)
                              for t in np.arange(30, 31, 0.05)))
    bench.until(lambda: paths[-1].finished)
    assert paths[-1].print_id == started.message


def test_a_print_is_saved_and_cleared(graph: Any, tmp_path: Path) -> None:
    bench = recorder_bench(graph, output_folder=str(tmp_path))
    nothing = bench.call('path_recorder/save')
    assert (nothing.success, nothing.message) == (
        False, 'expected a print, found none started; push ink out, or start one')
    message = print_line(bench)[-1]
    saved = bench.call('path_recorder/save')
    assert saved.success
    assert Path(saved.message).parent == tmp_path
    (_, _, stored), = Bag(saved.message).messages({'/deposition_path'})
    assert stored == message
    again = bench.call('path_recorder/save')
    assert not again.success
    assert 'expected a new bag' in again.message
    assert bench.call('path_recorder/clear').success
    assert not bench.call('path_recorder/save').success


def test_after_a_print_was_cleared_its_path_stands_no_longer(graph: Any) -> None:
    bench = recorder_bench(graph)
    viewed = bench.listen(topics.NAV_PATH, topics.RESULTS[topics.NAV_PATH], topics.PATH_QOS)
    updates = bench.listen(topics.PATH_UPDATE, DepositionPathUpdate, topics.UPDATE_QOS)
    paths = print_line(bench)
    bench.until(lambda: viewed)
    assert bench.call('path_recorder/clear').success
    bench.until(lambda: not paths[-1].print_id and not updates[-1].path.print_id)
    for message in (paths[-1], updates[-1].path):
        assert (message.print_id, message.finished, len(message.x)) == ('', True, 0)
    bench.until(lambda: not viewed[-1].poses)
    late: list[Any] = []
    graph.make(Node, 'late').create_subscription(
        topics.RESULTS[topics.PATH], topics.PATH, late.append, topics.PATH_QOS)
    bench.until(lambda: late)
    assert late == [paths[-1]]


def test_unusable_poses_and_states_are_counted(graph: Any) -> None:
    bench = recorder_bench(graph, watch__warn_after=0.0)  # the inputs stop at once
    wrong_frame, not_a_number, good = flange_pose(0.2), flange_pose(0.3), flange_pose(0.4)
    wrong_frame.header.frame_id = 'world'
    not_a_number.pose.position.y = np.nan
    bench.send(topics.POSE, flange_pose(0.1), wrong_frame, not_a_number, flange_pose(0.1), good)
    bench.send(topics.EXTRUSION, extrusion(0.2, False), extrusion(0.1, False))
    bench.until(lambda: bench.diagnosed('refused: extrusion_state') == '1'
                and bench.diagnosed('poses') == '2')
    assert bench.diagnosed('refused: pose') == '3'
    assert bench.diagnosed('extrusion states') == '1'
    assert 'expected' in bench.diagnosed('last refusal')
    assert DiagnosticStatus.WARN in [status.level for status in bench.statuses]
    # It is no warning any more when it is over, but stays counted.
    bench.until(lambda: bench.statuses[-1].level == DiagnosticStatus.OK)
    assert bench.diagnosed('refused: pose') == '3'


def test_an_extruder_by_a_clock_behind_is_refused(graph: Any) -> None:
    bench = recorder_bench(graph, watch__warn_after=0.0)

    def refused() -> bool:
        now_ns = bench.peer.get_clock().now().nanoseconds
        bench.send(topics.POSE, flange_pose(0.0, start_ns=now_ns))
        bench.send(topics.EXTRUSION, extrusion(-0.5, start_ns=now_ns))
        return bool(bench.diagnosed('refused: extrusion_state'))

    bench.until(refused)
    assert '0.5 s behind; let chrony or PTP set the clocks' in bench.diagnosed('last refusal')


@pytest.mark.parametrize('fast', [False, True])  # as run() chooses the executor
def test_of_two_robots_on_one_topic_none_is_followed(ros_domain: int, fast: bool) -> None:
    kind = EventsExecutor if fast and EventsExecutor is not None else None
    graph = Graph(ros_domain, kind)
    try:
        bench = recorder_bench(graph, watch__warn_after=0.0)
        other = graph.make(Node, 'other').create_publisher(
            PoseStamped, topics.POSE, topics.POSE_QOS)
        bench.until(other.get_subscription_count)
        bench.send(topics.POSE, flange_pose(0.1), flange_pose(0.2))
        bench.until(lambda: bench.diagnosed('poses') == '2')
        for count in (1, 3, 5):  # less than a millimetre beside each other
            other.publish(flange_pose(0.2 + count / 100))
            bench.until(lambda count=count: bench.diagnosed(REFUSED) == str(count))
            bench.send(topics.POSE, flange_pose(0.205 + count / 100))
            bench.until(lambda count=count: bench.diagnosed(REFUSED) == str(count + 1))
        assert bench.diagnosed('poses') == '2'
        assert bench.diagnosed('last refusal') == (
            f'{topics.POSE}: expected messages of one publisher, found those of two; end one of '
            'them')
    finally:
        graph.close()


def test_an_extruder_in_error_is_warned_of(graph: Any) -> None:
    bench = recorder_bench(graph, watch__warn_after=0.0)
    state = extrusion(0.1)
    state.error_status = 1 << 6
    bench.send(topics.EXTRUSION, state)
    bench.until(lambda: bench.diagnosed('last warning').endswith(
        'found error_status 64; clear it at the extruder'))
    assert bench.diagnosed('extrusion states') == '1'
    assert DiagnosticStatus.WARN in [status.level for status in bench.statuses]


def test_poses_that_jump_are_counted(graph: Any) -> None:
    bench = recorder_bench(graph, watch__warn_after=0.0)
    bench.send(topics.POSE, flange_pose(0.1), flange_pose(0.11, speed=10.0), flange_pose(0.12))
    bench.until(lambda: bench.diagnosed('poses') == '2')
    assert bench.diagnosed('refused: pose') == '1'
    assert 'found a jump; let one robot alone' in bench.diagnosed('last refusal')


def test_a_recorder_started_again_goes_on_with_its_print(graph: Any, tmp_path: Path) -> None:
    """Followers of the path have the same points as the recorder, before and after."""
    first = recorder_bench(graph, state_folder=str(tmp_path))
    followed: list[Any] = []
    PathFollower(first.peer, BASE, followed.append, followed.append)
    before = path_from_message(print_line(first)[-1])
    first.timer.cancel()
    graph.executor.remove_node(first.node)
    # As after a kill: the node is silent, and the file stays as it was.
    first.node.destroy_node()
    graph._nodes.remove(first.node)
    again = recorder_bench(graph, state_folder=str(tmp_path))
    paths = again.listen(topics.PATH, topics.RESULTS[topics.PATH], topics.PATH_QOS)
    again.until(lambda: paths)
    assert path_from_message(paths[-1]).print_id == before.print_id
    again.until(lambda: 'is resumed' in again.diagnosed('last warning'))
    again.send(topics.EXTRUSION, *(extrusion(t) for t in np.arange(6, 9, 0.1)))
    again.send(topics.POSE, *(flange_pose(t) for t in np.arange(6, 9, 0.05)))
    again.until(lambda: paths[-1].complete_until > 8.5
                and followed[-1].complete_until == paths[-1].complete_until)
    after = path_from_message(paths[-1])
    assert (after.print_id, after.start_ns) == (before.print_id, before.start_ns)
    np.testing.assert_array_equal(after.points[:len(before)], before.points)
    np.testing.assert_array_equal(followed[-1].points, after.points)
    gap = np.flatnonzero(np.diff(after.time) > 1.0)
    assert len(gap) == 1
    assert after.time[gap[0]] < 3.0 < 5.9 < after.time[gap[0] + 1]


@pytest.mark.parametrize(('resume', 'goes_on'), [('crashed', False), ('newest', True)])
def test_a_print_that_was_ended_on_purpose_is_gone_on_with_on_request_only(
        graph: Any, tmp_path: Path, resume: str, goes_on: bool) -> None:
    first = recorder_bench(graph, state_folder=str(tmp_path))
    before = path_from_message(print_line(first)[-1])
    first.timer.cancel()
    graph.executor.remove_node(first.node)
    first.node.end_print()
    first.node.destroy_node()
    graph._nodes.remove(first.node)
    again = recorder_bench(graph, state_folder=str(tmp_path), resume=resume)
    paths = again.listen(topics.PATH, topics.RESULTS[topics.PATH], topics.PATH_QOS)
    again.send(topics.EXTRUSION, *(extrusion(t) for t in np.arange(6, 9, 0.1)))
    again.send(topics.POSE, *(flange_pose(t) for t in np.arange(6, 9, 0.05)))
    again.until(lambda: paths and len(paths[-1].x) > 100)
    assert (path_from_message(paths[-1]).print_id == before.print_id) == goes_on


def test_a_folder_that_cannot_be_written_to_costs_no_print(graph: Any, tmp_path: Path) -> None:
    (tmp_path / 'file').touch()
    bench = recorder_bench(graph, state_folder=str(tmp_path / 'file'))
    assert len(print_line(bench)[-1].x) > 100
    assert bench.diagnosed('refused: state_folder') == '1'


def test_a_second_recorder_does_not_write_into_the_print_of_the_first(graph: Any,
                                                                     tmp_path: Path) -> None:
    first = recorder_bench(graph, state_folder=str(tmp_path))
    with pytest.raises(ValueError, match=f'{tmp_path}: expected to be the only one to keep a '
                                         f'running print there, found process {os.getpid()} '):
        recorder_bench(graph, state_folder=str(tmp_path))
    assert len(print_line(first)[-1].x) > 100
    assert first.diagnosed('last refusal') == ''


def test_a_print_left_off_with_another_nozzle_is_not_gone_on_with(graph: Any,
                                                                  tmp_path: Path) -> None:
    config = RecorderConfig(nozzle_offset=(0.0, 0.0, 0.1))
    path = GrowingPath('left_off', START_NS)
    path.extend(0, replace(pixel_path((0, 0), (9, 0)), print_id='left_off', finished=False))
    journal = PathJournal(tmp_path, config)
    journal.take(path, time.time_ns())
    journal.close()
    bench = recorder_bench(graph, state_folder=str(tmp_path))
    bench.until(lambda: 'nozzle_offset' in bench.diagnosed('last warning'))
    assert path_from_message(print_line(bench)[-1]).print_id != 'left_off'


def test_a_journal_that_cannot_be_used_costs_neither_print_nor_service(graph: Any,
                                                                       tmp_path: Path) -> None:
    (tmp_path / 'running_print.mcap' / 'folder.mcap').mkdir(parents=True)  # no file
    bench = recorder_bench(graph, state_folder=str(tmp_path))
    bench.until(lambda: bench.diagnosed('refused: journal') == '1')  # it cannot be read
    assert len(print_line(bench)[-1].x) > 100
    bench.until(lambda: bench.diagnosed('refused: journal') == '2')  # nor written
    assert bench.call('path_recorder/clear').success
    bench.until(lambda: bench.diagnosed('refused: journal') == '3')  # nor removed


def test_a_full_disk_costs_no_print(graph: Any, tmp_path: Path) -> None:
    (tmp_path / 'running_print.tmp').symlink_to('/dev/full')
    bench = recorder_bench(graph, state_folder=str(tmp_path))
    assert len(print_line(bench)[-1].x) > 100
    bench.until(lambda: bench.diagnosed('refused: journal') == '1')
    assert 'No space left on device' in bench.diagnosed('last refusal')
