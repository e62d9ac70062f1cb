"""A profile by parts: what changed, and the whole made of it, in whatever order it comes."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise, permutations

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.growing_profile import (
    change_between,
    GrowingProfile,
    MOST_WAITING,
    ProfileChange,
)
from bpc_perception.core.profile import Status, ThicknessProfile

NAN = np.nan


def print_of(stamp_ns: int, widths: list[float], print_id: str = 'print') -> ThicknessProfile:
    status = [Status.NO_DATA if np.isnan(width) else Status.MEASURED for width in widths]
    return replace(profile_of(widths, status), stamp_ns=stamp_ns, print_id=print_id,
                   capture=stamp_ns)


# A sample was not seen and then is; one is seen better; one is lost; two are new each time.
PROFILES = [print_of(1, [2.0, NAN, 3.0]), print_of(2, [2.0, 2.5, 3.0, 4.0, NAN]),
            print_of(3, [2.0, 2.5, 3.5, 4.0, NAN, 5.0, 6.0]),
            print_of(4, [2.0, 2.5, 3.5, NAN, NAN, 5.0, 6.0, 7.0, 8.0])]
CHANGES = [change for pair in pairwise(PROFILES) if (change := change_between(*pair))]


def assert_equal(found: ThicknessProfile, wanted: ThicknessProfile) -> None:
    for field in fields(ThicknessProfile):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(wanted, field.name),
                                      field.name)


def test_a_change_has_the_samples_that_differ_or_are_new() -> None:
    assert [change.index.tolist() for change in CHANGES] == [
        [1, 3, 4], [2, 5, 6], [3, 7, 8]]
    assert [change.base_ns for change in CHANGES] == [1, 2, 3]
    np.testing.assert_array_equal(CHANGES[0].part.thickness, [2.5, 4.0, NAN])
    assert CHANGES[0].part.capture == 2


def test_what_stays_not_known_is_no_change() -> None:
    change = change_between(PROFILES[0], replace(PROFILES[0], stamp_ns=2))
    assert change is not None
    assert change.index.size == 0


def test_of_another_print_or_a_shorter_one_there_is_no_change() -> None:
    assert change_between(PROFILES[0], print_of(2, [2.0, 2.0, 3.0], 'other')) is None
    assert change_between(PROFILES[1], print_of(3, [2.0])) is None


def test_all_changes_make_the_whole() -> None:
    known = GrowingProfile()
    news = known.set_whole(PROFILES[0])
    for change in CHANGES:
        news += known.add_change(change)
    for found, wanted in zip(news, PROFILES, strict=True):
        assert_equal(found, wanted)
    assert not known.incomplete


@pytest.mark.parametrize('order', list(permutations(range(4))))
def test_the_newest_is_known_in_whatever_order_parts_come(order: tuple[int, ...]) -> None:
    known, news = GrowingProfile(), []
    for number in order:
        news += (known.set_whole(PROFILES[0]) if number == 0
                 else known.add_change(CHANGES[number - 1]))
    assert [profile.stamp_ns for profile in news] == [1, 2, 3, 4]
    assert_equal(news[-1], PROFILES[-1])


def test_where_a_part_is_lost_nothing_is_told_until_the_whole_comes() -> None:
    known = GrowingProfile()
    known.set_whole(PROFILES[0])
    assert known.add_change(CHANGES[1]) == []
    assert known.incomplete
    news = known.set_whole(PROFILES[2])
    assert [profile.stamp_ns for profile in news] == [3]
    assert not known.incomplete
    assert_equal(known.add_change(CHANGES[2])[0], PROFILES[3])


def test_a_whole_that_is_known_already_is_no_news() -> None:
    known = GrowingProfile()
    known.set_whole(PROFILES[2])
    assert known.set_whole(PROFILES[2]) == known.set_whole(PROFILES[1]) == []
    assert known.profile is PROFILES[2]


def test_after_a_print_was_cleared_nothing_of_it_waits() -> None:
    known = GrowingProfile()
    known.add_change(CHANGES[2])
    none = ThicknessProfile.none(10)
    assert known.set_whole(none) == [none]
    assert not known.incomplete
    again = print_of(1, [1.0])  # the clock was set back
    assert known.set_whole(again) == [again]


@pytest.mark.parametrize('index', [[1, 3, 5], [1, 4, 5], [7, 8, 9]])
def test_a_change_that_leaves_a_place_empty_is_not_made(index: list[int]) -> None:
    known = GrowingProfile()
    known.set_whole(PROFILES[0])
    change = CHANGES[0]
    assert known.add_change(ProfileChange(change.base_ns, np.array(index), change.part)) == []
    assert known.profile is PROFILES[0]


def test_changes_of_an_unknown_profile_fill_no_memory() -> None:
    known = GrowingProfile()
    for stamp_ns in range(10, 10 + 5 * MOST_WAITING):
        known.add_change(replace(CHANGES[0], base_ns=stamp_ns))
    assert len(known._waiting) == MOST_WAITING


def test_changes_of_another_print_do_not_wait_for_ever() -> None:
    known = GrowingProfile()
    known.add_change(replace(CHANGES[0], part=replace(CHANGES[0].part, print_id='other')))
    known.set_whole(PROFILES[0])
    assert not known.incomplete
