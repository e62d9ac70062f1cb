"""Messages of two publishers are told apart by their numbers."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from bpc_perception.core.watch.one_source import MEMORY_S, OneSource

Stream = Iterable[tuple[float, int, str]]  # time [s], number, publisher


def sent(publisher: str, first: int, start: float, pause: float, count: int) -> Stream:
    return [(start + pause * each, first + each, publisher) for each in range(count)]


def taken(*streams: Stream) -> list[tuple[float, int, str]]:
    source = OneSource()
    return [message for message in sorted(each for stream in streams for each in stream)
            if source.takes(message[1], message[0])]


@pytest.mark.parametrize('pause', [0.001, 0.02, 2.0, 12.0])
def test_one_publisher_is_heard_from_its_first_message_on(pause: float) -> None:
    alone = sent('a', 500, 0.0, pause, 200)
    assert taken(alone) == alone


def test_what_gets_lost_is_no_other_publisher() -> None:
    whole = list(sent('a', 1, 0.0, 0.01, 3000))
    lossy = [message for message in whole[:500] + whole[900:] if message[1] % 7]
    assert taken(lossy) == lossy


@pytest.mark.parametrize('pause', [0.001, 0.02, 2.0])
def test_a_publisher_that_is_started_again_is_heard_at_once(pause: float) -> None:
    first = sent('a', 1, 0.0, pause, 100)
    again = sent('b', 1, first[-1][0] + max(1.0, 3.1 * pause), pause, 100)
    assert taken(first, again) == first + again


@pytest.mark.parametrize('first', [1, 100, 300, 5000])  # of the second publisher
@pytest.mark.parametrize(('pause', 'other_pause'), [
    (0.001, 0.001), (0.001, 0.01), (0.01, 0.02), (2.0, 2.0), (2.0, 12.0), (12.0, 2.0)])
def test_of_two_at_a_time_neither_is_heard_soon_after_the_second_began(
        first: int, pause: float, other_pause: float) -> None:
    one = sent('a', 1, 0.0, pause, round(300 / pause) if pause > 1 else 3_000)
    begins = 100.5 * pause
    two = sent('b', first, begins, other_pause, len(one))
    end = min(one[-1][0], two[-1][0])
    both = [message for message in taken(one, two) if begins <= message[0] <= end]
    assert sum(message[2] == 'b' for message in both) <= 2
    late = [message for message in both if message[0] > begins + 3 * max(pause, other_pause)]
    assert late == []


def test_who_is_left_is_heard_again() -> None:
    one = sent('a', 1, 0.0, 0.01, 12_000)
    two = sent('b', 1, 50.0, 0.01, 100)  # for a second
    heard = [message for message in taken(one, two) if message[0] > 51.0]
    assert {message[2] for message in heard} == {'a'}
    assert heard[0][0] == pytest.approx(51.0 + MEMORY_S, abs=0.1)
