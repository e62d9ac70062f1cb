"""What a part of a path holds, and what a path covers."""

from __future__ import annotations

import numpy as np
from perception_builders import along_x, at_ns, path_through
import pytest


def test_until_gives_what_was_passed_by_then() -> None:
    path = path_through(along_x(np.linspace(0, 1, 11)))
    assert len(path.until(at_ns(0.5))) == 6
    assert len(path.until(at_ns(0.55))) == 6
    assert len(path.until(at_ns(-0.1))) == 0
    part = path.until(at_ns(99))
    assert len(part) == len(part.points) == len(part.extruding) == len(part.flow_rate) == 11
    assert len(part.extruder_known) == 11


@pytest.mark.parametrize(('finished', 'time', 'covered'), [
    (False, 0.9, True), (False, 1.0, True), (False, 1.1, False), (True, 1.1, True)])
def test_a_path_covers_what_is_complete(finished: bool, time: float, covered: bool) -> None:
    path = path_through(along_x(np.linspace(0, 1, 11)), finished=finished)
    assert path.covers(at_ns(time)) == covered
