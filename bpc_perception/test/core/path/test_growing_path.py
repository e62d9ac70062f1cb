"""A path that grows: what was given out stays, parts fit together, memory is bounded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import path_through, START_NS
import pytest

from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath

WHOLE = path_through(np.column_stack((np.arange(1, 5000) * 1e-3, np.zeros((4999, 2)))))


def part(first: int, last: int) -> DepositionPath:
    points = np.arange(len(WHOLE))
    return replace(WHOLE.where((points >= first) & (points < last)),
                   complete_until=float(WHOLE.time[last - 1]), finished=last == len(WHOLE))


def assert_same(found: DepositionPath, wanted: DepositionPath) -> None:
    for name in ('time', 'arc_length', 'points', 'plunger_velocity', 'flow_rate', 'extruding',
                 'extruder_known'):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))
    assert (found.complete_until, found.finished) == (wanted.complete_until, wanted.finished)


def test_parts_make_up_the_whole_and_what_was_given_out_stays() -> None:
    growing = GrowingPath(WHOLE.print_id, START_NS)
    ends = [1, 2, 500, 1024, 1025, 3000, 4999]
    given = []
    for first, last in zip([0, *ends[:-1]], ends, strict=True):
        assert growing.extend(first, part(first, last))
        given.append(growing.path())
    for end, path in zip(ends, given, strict=True):
        assert_same(path, part(0, end))
    assert_same(growing.path(first=3000), part(3000, 4999))
    assert growing.last().tolist() == [WHOLE.time[-1], WHOLE.arc_length[-1], 4.999, 0, 0]


def test_overlapping_and_late_parts_add_nothing_twice() -> None:
    growing = GrowingPath(WHOLE.print_id, START_NS)
    for first, last in ((0, 100), (50, 150), (20, 30), (0, 150)):
        assert growing.extend(first, part(first, last))
    assert_same(growing.path(), part(0, 150))


@pytest.mark.parametrize('stranger', [
    part(101, 200), replace(part(100, 200), print_id='other'),
    replace(part(100, 200), start_ns=START_NS + 1)], ids=['beyond', 'print', 'start'])
def test_a_part_that_does_not_fit_is_not_taken(stranger: DepositionPath) -> None:
    growing = GrowingPath(WHOLE.print_id, START_NS)
    growing.extend(0, part(0, 100))
    first = 101 if len(stranger) == 99 else 100
    assert not growing.extend(first, stranger)
    assert_same(growing.path(), part(0, 100))


def test_of_a_very_long_path_the_newest_points_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(GrowingPath, 'MAXIMUM_POINTS', 2000)
    growing = GrowingPath(WHOLE.print_id, START_NS)
    for first in range(0, 4990, 10):
        assert growing.extend(first, part(first, first + 10))
        path = growing.path()
        assert len(path) <= 2000
        assert_same(path, part(first + 10 - len(path), first + 10))
        assert len(path) >= min(first + 10, 1000)
        assert_same(growing.path(first), part(first, first + 10))
    assert len(growing) == 4990
