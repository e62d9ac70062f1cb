"""What of a print of a design is refused before it begins."""

from __future__ import annotations

from pathlib import Path

import pytest

from bpc_sim.cli.parts.design_print import behaviour_of
from bpc_sim.cli.sim import bag_of_design


def test_what_the_ink_may_be() -> None:
    ink = behaviour_of(1.5, 0.0, 0.2, 7)
    assert (ink.spreading, ink.dead_time, ink.seed) == (1.5, 0.2, 7)
    assert ink.lag > 0
    for values, message in (((9.0, 0.1, 0.1), '--spreading: expected 0.2 to 5, found 9'),
                            ((1.0, -1.0, 0.1), '--lag: expected 0 to 20, found -1'),
                            ((1.0, 0.1, 9.0), '--dead-time: expected 0 to 5, found 9')):
        with pytest.raises(ValueError, match=message):
            behaviour_of(*values, 0)


def test_it_is_recorded_and_nothing_else() -> None:
    assert bag_of_design(None, False, Path('bag')) == Path('bag')
    with pytest.raises(ValueError, match='name the new bag with it'):
        bag_of_design(None, False, None)
    for scenario, closed_loop in (('line', False), (None, True)):
        with pytest.raises(ValueError, match='leave one out'):
            bag_of_design(scenario, closed_loop, Path('bag'))
