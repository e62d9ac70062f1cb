"""Devices sample at a steady rate, even if the process that simulates them is held up."""

from bpc_sim.nodes.steady_rate import MAX_DELAY_NS, SteadyRate

MS = 1_000_000  # [ns]


def test_what_was_held_up_comes_late_but_none_is_left_out() -> None:
    rate = SteadyRate(500.0)
    assert list(rate.due(7 * MS)) == [7 * MS]
    assert list(rate.due(8 * MS)) == []
    assert list(rate.due(17 * MS)) == [9 * MS, 11 * MS, 13 * MS, 15 * MS, 17 * MS]
    assert list(rate.due(18 * MS)) == []


def test_a_long_pause_and_a_clock_that_is_set_begin_anew() -> None:
    rate = SteadyRate(500.0)
    assert list(rate.due(0)) == [0]
    late = 2 * MS + MAX_DELAY_NS + 1
    assert list(rate.due(late)) == [late]
    assert list(rate.due(MS)) == [MS]
