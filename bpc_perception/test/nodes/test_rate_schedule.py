"""What a print taught is published for the next, and kept for who subscribes late."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from node_builders import BASE, BEAD_WIDTH_M, STAMP_NS, thickness_bench
from perception_builders import pixel_path, SECOND
import pytest

from bpc_interfaces.msg import RateSchedule
from bpc_perception.core.learning.layer_schedule import ScheduleReason
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.results.schedule import schedule_from_message

pytestmark = pytest.mark.ros
ENDS = (32, 55), (128, 55)
TARGET_M = 1.15 * BEAD_WIDTH_M


def send(bench: Any, stamp_ns: int, finished: bool) -> None:
    """Send a path and a capture of it."""
    bench.send(topics.PATH, path_to_message(pixel_path(
        *ENDS, 97, finished=finished, speed=0.004), BASE))
    bench.until(lambda: bench.node._session._path is not None
                and bench.node._session._path.finished == finished)
    count = len(bench.received[topics.PROFILE])
    bench.send_capture(stamp_ns)
    bench.until(lambda: len(bench.received[topics.PROFILE]) > count)


def test_what_is_kept_is_told_before_the_next_print_and_for_this_ink_alone(
        graph: Any, tmp_path: Path) -> None:
    kept = {'advice__target_thickness': TARGET_M, 'learning__file': str(tmp_path / 'way.yaml'),
            'learning__nozzle': '22G'}
    bench = thickness_bench(graph, tmp_path, learning__ink='seven', **kept)
    send(bench, STAMP_NS, finished=False)
    send(bench, STAMP_NS + SECOND, finished=True)
    bench.until(lambda: (tmp_path / 'way.yaml').is_file())
    again = thickness_bench(graph, tmp_path, learning__ink='seven', **kept)
    told = again.node._session.schedule
    assert (told.valid, told.print_id, told.based_on) == (True, '', (('print', 0),))
    other = thickness_bench(graph, tmp_path, learning__ink='eight', **kept)
    assert not other.node._session.schedule.valid
    other.until(lambda: any("expected ink 'eight', found 'seven'" in each.message
                            for each in other.statuses))


def test_a_print_that_is_over_gives_a_schedule_for_the_next(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, advice__target_thickness=TARGET_M)
    schedules = bench.listen(topics.SCHEDULE, RateSchedule, topics.SCHEDULE_QOS)
    for number in range(3):
        send(bench, STAMP_NS + number * SECOND, finished=False)
    bench.until(lambda: schedules)
    bench.node._clear()  # nothing is taught yet
    bench.until(lambda: len(schedules) == 3)
    # At the start, when the layer begins, and as it is cleared; not with each capture.
    assert [(each.valid, each.reason) for each in schedules] == [
        (False, ScheduleReason.NOTHING_LEARNED)] * 3
    send(bench, STAMP_NS + 4 * SECOND, finished=False)
    send(bench, STAMP_NS + 5 * SECOND, finished=True)
    bench.until(lambda: schedules[-1].valid)
    told = schedule_from_message(schedules[-1])
    assert (told.valid, told.print_id, told.based_on) == (True, '', (('print', 0),))
    assert schedules[-1].header.frame_id == BASE
    assert told.schedule is not None
    # The area is as the square of the width.
    assert told.schedule.at(0.009) == pytest.approx((TARGET_M / BEAD_WIDTH_M)**2, rel=0.08)
    assert told.points[0] == pytest.approx(pixel_path(*ENDS).points[0], abs=5e-4)
    late: list[RateSchedule] = []
    bench.peer.create_subscription(RateSchedule, topics.SCHEDULE, late.append,
                                   topics.SCHEDULE_QOS)
    bench.until(lambda: late)
    assert late[0].valid
