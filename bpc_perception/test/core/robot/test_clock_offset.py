"""A device's clock against ours, with delays known by construction."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.robot.clock_offset import ClockOffset

MS = 10**6
OFFSET = 5_000_000_000_000  # ours less the device's [ns]


def test_jitter_is_taken_out() -> None:
    rng = np.random.default_rng(4)
    clock, wrong = ClockOffset(), []
    for index in range(1000):
        device = index * 10 * MS
        delay = 2 * MS + round(rng.exponential(5) * MS)
        mapped = clock.map(device, device + OFFSET + delay)
        wrong.append(mapped - (device + OFFSET))
    # All delay but the least is removed, and nothing is mapped to before it happened.
    assert max(wrong[100:]) < 2.2 * MS
    assert min(wrong) >= 2 * MS
    assert clock.offset_ns is not None
    assert abs(clock.offset_ns - OFFSET - 2 * MS) < 0.2 * MS


def test_a_message_that_comes_quicker_is_not_put_before_those_before() -> None:
    clock = ClockOffset()
    delays = (20, 18, 3, 2, 9, 1, 1, 1)
    mapped = [clock.map(5 * index * MS, 5 * index * MS + OFFSET + delay * MS)
              for index, delay in enumerate(delays)]
    assert all(np.diff(mapped) > 0)
    assert mapped[-1] == 5 * 7 * MS + OFFSET + 1 * MS


def test_drift_is_followed() -> None:
    clock = ClockOffset()
    for index in range(6001):  # a minute at 100 microseconds a second, the device too slow
        device = index * 10 * MS
        ours = device + OFFSET + index * 1000
        mapped = clock.map(device, ours)
    assert abs(mapped - ours) <= 20 * 100_000  # what two stretches drift


def test_a_device_that_starts_anew_is_taken_anew() -> None:
    clock = ClockOffset()
    assert clock.offset_ns is None
    assert clock.map(1000 * MS, OFFSET) == OFFSET
    assert clock.map(0, OFFSET + 3000 * MS) == OFFSET + 3000 * MS
    assert clock.map(10 * MS, OFFSET + 3010 * MS) == OFFSET + 3010 * MS


def test_delay_that_grows_is_delay() -> None:
    """A busy computer sends each pose a little later than the one before."""
    clock = ClockOffset()
    for index in range(300):
        device = index * 10 * MS
        assert clock.map(device, device + OFFSET + index * 10 * MS) == device + OFFSET
    assert clock.map(3000 * MS, OFFSET + 3001 * MS) == OFFSET + 3000 * MS


def test_what_was_held_up_for_long_is_not_dated() -> None:
    """Whether it was held up, or the clock was set, is known only later."""
    clock = ClockOffset()
    clock.map(0, OFFSET)
    held_up = [clock.map(index * 10 * MS, OFFSET + 1499 * MS + index) for index in range(1, 150)]
    assert held_up[:49] == [None] * 49
    assert held_up[49:] == [OFFSET + index * 10 * MS for index in range(50, 150)]


def test_a_clock_that_was_set_back_during_silence_is_believed_in_time() -> None:
    clock = ClockOffset()
    clock.map(0, OFFSET)
    device = np.arange(1000, 5000, 10) * MS
    mapped = [clock.map(int(ns), int(ns) + OFFSET + 3000 * MS) for ns in device]
    assert mapped[:201] == [None] * 201
    assert mapped[201:] == [int(ns) + OFFSET + 3000 * MS for ns in device[201:]]
