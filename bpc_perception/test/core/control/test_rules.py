"""Where prints are not by chance: by hand, and how often and how soon, by probability."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.special import ndtr

from bpc_perception.core.control.individuals import control_limits, ControlLimits
from bpc_perception.core.control.rules import Alarm, find_alarms, Rule

KNOWN = ControlLimits(0.0, 1.0, 100)
NAN = np.nan


def alarms(*values: float) -> list[Alarm]:
    return find_alarms(np.array(values), KNOWN)


def test_a_print_beyond_a_limit_is_marked_and_one_on_it_is_not() -> None:
    assert alarms(0.1, 3.01, -0.1, 3.0, -3.0, -4.0, -3.5) == [
        Alarm(Rule.ABOVE, 1, 2), Alarm(Rule.BELOW, 5, 7)]


@pytest.mark.parametrize(('values', 'found'), [
    ((-1,) + 8 * (0.1,) + (-1,), []),
    ((-1,) + 9 * (0.1,) + (-1,), [Alarm(Rule.HIGH_SIDE, 1, 10)]),
    ((1,) + 11 * (-0.1,), [Alarm(Rule.LOW_SIDE, 1, 12)]),
    (8 * (0.1,) + (0.0,) + 8 * (0.1,), []),
    (4 * (0.1,) + (NAN,) + 5 * (0.1,), [Alarm(Rule.HIGH_SIDE, 0, 10)]),
    ((NAN, NAN), []), ((), [])])
def test_nine_in_a_row_on_one_side_are_marked(values: Sequence[float],
                                              found: list[Alarm]) -> None:
    assert alarms(*values) == found


def test_without_limits_there_are_no_alarms() -> None:
    values = np.array((0.0,) * 5 + (100.0,))
    assert find_alarms(values, control_limits(values)) == []


def run_length(shift: float, drift: float = 0.0) -> float:
    """Mean number of prints up to an alarm, by the chain of the runs, for as long as one may last.

    A state is the length of the run, 1 to 8, on either side. From each a print leads to the next,
    to a run of one on the other side, or to an alarm. The mean is the sum, over all prints, of the
    chance that no alarm came before.

    Args:
        shift: of the mean [sigma].
        drift: of the mean from each print to the next [sigma].
    """
    states = np.zeros(17)  # 0: none yet; 1 to 8: so many above; 9 to 16: below
    states[0], total = 1.0, 0.0
    for number in range(1, 8000):
        total += states.sum()
        mean = shift + drift * number
        above, below = ndtr(3 - mean) - ndtr(-mean), ndtr(-mean) - ndtr(-3 - mean)
        after = np.zeros(17)
        after[2:9], after[10:17] = above * states[1:8], below * states[9:16]
        after[1] = above * (states[0] + states[9:].sum())
        after[9] = below * (states[0] + states[1:9].sum())
        states = after
    return total


def first_alarm(values: np.ndarray) -> int:
    """Number of prints up to the first alarm."""
    needed = {Rule.ABOVE: 1, Rule.BELOW: 1, Rule.HIGH_SIDE: 9, Rule.LOW_SIDE: 9}
    return min(each.start + needed[each.rule] for each in find_alarms(values, KNOWN))


@pytest.mark.parametrize('shift', [0.0, 0.5, 1.0, 2.0])
def test_alarms_come_as_often_as_they_should(shift: float) -> None:
    """Without a shift by chance, every 217 prints; with one of 1 sigma after 17."""
    rng = np.random.default_rng(7)
    counts = [first_alarm(rng.normal(shift, 1.0, 4000)) for _ in range(600)]
    error = np.std(counts) / np.sqrt(len(counts))
    assert np.mean(counts) == pytest.approx(run_length(shift), abs=4 * error)


def test_the_run_lengths_that_the_documentation_states() -> None:
    assert [round(run_length(shift)) for shift in (0.0, 1.0, 2.0)] == [217, 17, 5]
    assert [round(run_length(0.0, drift)) for drift in (0.1, 0.2, 0.5)] == [15, 10, 6]


def test_a_planted_drift_is_found_and_sound_series_are_left_alone() -> None:
    """Limits from 20 prints, then 0.1 sigma more each print: found within 25 in 95 of 100."""
    rng = np.random.default_rng(8)
    sound, found = 0, 0
    for values in rng.normal(size=(1000, 45)):
        limits = control_limits(values, 20)
        sound += bool(find_alarms(values[:20], limits))
        drifting = values + 0.1 * np.maximum(np.arange(45) - 19, 0)
        found += any(alarm.end > 20 for alarm in find_alarms(drifting, limits))
    assert sound < 80
    assert found > 950
