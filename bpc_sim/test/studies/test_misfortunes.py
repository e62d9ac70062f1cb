"""Prints whose messages were spoiled: advice never asks for more than the truth allows."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.recording.bag import BagMessage
from bpc_sim.studies.misfortunes.misfortunes import MISFORTUNES
from bpc_sim.studies.misfortunes.small_print import random_print
from bpc_sim.studies.misfortunes.study import NONE, rows, TOLERANCE, Trial, try_print

pytestmark = pytest.mark.ros
# Found by the search. Before it: thick beads at the start, of which the delivery was not known
# yet, were to become thicker (13, 79); pieces of path without a direction (141), rates beyond all
# measure (153) and sections without contrast (160) made numbers that are none; a single wrong pose
# within reach was believed (1247, 2331, 2580); so was the way over a hole that cut a corner, with
# all the ink of meanwhile (2292), and a step after poses that were repeated a moment (1055); of
# poses that come again among others some fit by chance (4634, 5629); the speed at the last poses
# was taken from a glitch (3123, 4120), or over a clock that was set back a little (5722, 6682). Of
# poses that come again, with new stamps or in another order, some are on the way; the nozzle
# seems to dart, and the speed in force with it (321, 1812, 6527, 50543, 55161), or it is not known
# for long (6158); so it was where a clock is set by half a tenth of a second (444, 50681). A pose
# of a known stamp after doubtful ones divided by zero (54134). What something hides of ink was
# taken for lacking (4969, 50622);
# of what seems to be missing, a part is not known for sure (59717). What lay on one side of the
# ink from the start looked like its edge, and only the newest ink was whole (63678). A path of
# another scale lay over ink here and there (69326).
FOUND = (13, 79, 141, 153, 160, 321, 444, 1055, 1247, 1812, 2292, 2331, 2580, 3123, 4120, 4634,
         4969, 5629, 5722, 6158, 6527, 6682, 50543, 50622, 50681, 54134, 55161, 59717, 63678,
         69326)


@pytest.mark.parametrize('number', FOUND)
def test_what_the_search_found_does_not_come_back(number: int) -> None:
    assert try_print(number).excess <= TOLERANCE


def test_without_misfortune_a_small_print_is_measured_and_advised_on() -> None:
    """Otherwise a search would find nothing, whatever was wrong."""
    trial = try_print(28)
    assert trial.misfortunes == (NONE,)
    assert trial.results > 5
    assert trial.valid > 5


@pytest.fixture(scope='module')
def messages() -> list[BagMessage]:
    """All messages of a print."""
    return random_print(np.random.default_rng(1)).messages()


@pytest.mark.parametrize('name', list(MISFORTUNES))
def test_a_misfortune_changes_messages_but_never_those_it_was_given(
        name: str, messages: list[BagMessage]) -> None:
    before = [repr((entry.topic, entry.log_ns, getattr(entry.message, 'header', None)))
              for entry in messages]
    spoiled = MISFORTUNES[name](messages, np.random.default_rng(2))
    assert before == [repr((entry.topic, entry.log_ns, getattr(entry.message, 'header', None)))
                      for entry in messages]
    assert len(spoiled) != len(messages) or any(
        one is not other for one, other in zip(spoiled, messages, strict=True))


def test_the_table_has_a_row_for_each_misfortune_and_one_of_all() -> None:
    table = rows([[Trial(13, (NONE,), 5, 4, 0.05)]])
    assert [row['misfortune'] for row in table] == [NONE, *MISFORTUNES, 'all']
    assert table[-1]['prints'] == 1
