"""Stretches of time in which the flange stands still, placed by hand."""

from __future__ import annotations

import numpy as np
from perception_builders import pose, SECOND, START_NS
import pytest

from bpc_perception.core.calibration.rests import rests


def test_rests_are_found_between_movements() -> None:
    stamps = START_NS + np.arange(0, 8 * SECOND, SECOND // 100)
    time = (stamps - START_NS) / SECOND
    # Stands for 2 s, moves for 1 s, stands for 2 s, moves for 1 s, stands for 0.5 s, moves on.
    x = 0.1 * np.interp(time, (0, 2, 3, 5, 6, 6.5, 8), (0, 0, 1, 1, 2, 2, 3))
    x += 1e-5 * np.random.default_rng(3).standard_normal(len(x))
    poses = np.stack([pose((value, 0, 0.5)) for value in x])
    found = rests(stamps, poses)
    assert [rest.T_base_flange[0, 3] for rest in found] == pytest.approx([0.0, 0.1], abs=1e-4)
    assert (found[0].end_ns - START_NS) / SECOND == pytest.approx(2, abs=0.02)
    assert (found[1].start_ns - START_NS) / SECOND == pytest.approx(3, abs=0.02)
    assert len(rests(stamps, poses, 0.3)) == 3


def test_a_turn_on_the_spot_ends_a_rest() -> None:
    stamps = START_NS + np.arange(0, 4 * SECOND, SECOND // 100)
    angle = np.where(stamps < START_NS + 2 * SECOND, 0.0, 1.0)  # [degrees]
    found = rests(stamps, np.stack([pose(angles=(value, 0, 0)) for value in angle]))
    assert len(found) == 2
