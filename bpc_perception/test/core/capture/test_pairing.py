"""Parts of one stamp find each other in any order."""

from __future__ import annotations

from itertools import permutations

import pytest

from bpc_perception.core.capture.pairing import StampPairer

KINDS = ('image', 'info', 'cloud')


def pairer() -> StampPairer[str]:
    return StampPairer(KINDS)


@pytest.mark.parametrize('order', list(permutations(KINDS)))
def test_the_last_part_completes_the_set(order: tuple[str, ...]) -> None:
    made = pairer()
    assert made.add(order[0], 7, 'a') is None
    assert made.add(order[1], 7, 'b') is None
    assert made.add(order[2], 7, 'c') == {order[0]: 'a', order[1]: 'b', order[2]: 'c'}


def test_sets_of_different_stamps_do_not_mix() -> None:
    made = pairer()
    for kind in KINDS[:2]:
        for stamp in (7, 8):
            assert made.add(kind, stamp, f'{kind} {stamp}') is None
    assert made.add('cloud', 8, 'cloud 8') == {kind: f'{kind} 8' for kind in KINDS}
    assert made.add('cloud', 7, 'cloud 7') == {kind: f'{kind} 7' for kind in KINDS}


def test_a_repeated_part_completes_nothing() -> None:
    made = pairer()
    assert [made.add('image', 7, 'a') for _ in range(3)] == [None] * 3


def test_a_complete_set_is_forgotten() -> None:
    made = pairer()
    for kind in KINDS:
        made.add(kind, 7, 'a')
    assert made.add('image', 7, 'b') is None
    assert made.expired(1) == [('info', 'cloud')]


def test_old_sets_are_given_up_with_what_they_lack() -> None:
    made = pairer()
    made.add('image', 7, 'a', received_ns=100)
    made.add('cloud', 8, 'a', received_ns=200)
    made.add('cloud', 7, 'a', received_ns=250)  # the age is that of the first part
    assert made.expired(100) == []
    assert made.expired(201) == [('info',), ('image', 'info')]
    assert made.expired(999) == []


def test_of_many_incomplete_sets_only_the_newest_are_kept() -> None:
    made = pairer()
    for stamp in range(10):
        made.add('image', stamp, 'a')
    assert made.expired(0) == [('info', 'cloud')] * 6
    made.add('info', 5, 'a')
    assert made.add('cloud', 5, 'a') is None
    made.add('info', 9, 'a')
    assert made.add('cloud', 9, 'a') is not None


def test_sets_whose_large_parts_gave_way_to_newer_ones_are_counted() -> None:
    made = pairer()
    for stamp in (5, 6, 7, 9):
        made.add('info', stamp, 'a')
    made.add('image', 6, 'a')
    assert made.overtaken(8, 'info') == 2
    assert made.expired(1) == [('cloud',), ('image', 'cloud')]


def test_clear_forgets_parts() -> None:
    made = pairer()
    made.add('image', 7, 'a')
    made.clear()
    assert made.expired(10**18) == []
    made.add('info', 7, 'a')
    assert made.add('cloud', 7, 'a') is None


def test_a_capture_whose_cloud_never_came_is_counted_once() -> None:
    torn: StampPairer[None] = StampPairer(('info', 'image', 'cloud'), 100)
    for topic in ('cloud', 'info', 'image'):
        torn.add(topic, 1, None, 0)
    torn.add('info', 2, None, 10)
    torn.add('image', 2, None, 11)
    torn.add('info', 3, None, 12)
    assert torn.expired(10) == []
    torn.add('image', 3, None, 31)
    torn.add('cloud', 3, None, 31)
    assert torn.expired(11) == [('cloud',)]
    torn.add('cloud', 2, None, 200)  # too late, and no capture of its own
    assert torn.expired(300) == [('info', 'image')]
    assert torn.expired(400) == []


def test_as_many_sets_are_incomplete_as_are_allowed() -> None:
    pairer: StampPairer[None] = StampPairer(('info', 'image'), 10)
    for stamp_ns in range(12):
        pairer.add('info', stamp_ns, None, 5)
    assert pairer.expired(0) == [('image',)] * 2
