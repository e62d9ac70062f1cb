"""Whether the next layer can be laid, by beads of known height."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from repair_builders import (
    bead,
    COUNT,
    HEIGHT_M,
    plan,
    SPACING_M,
    TIP_M,
    WIDTH_M,
    with_gap,
    with_status,
)

from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.config import ToleranceConfig
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import LayerState, NextLayer, Obstacle


def state(profile: ThicknessProfile, **others: Any) -> LayerState:
    """How the next layer finds the only one."""
    layer, = plan(profile, **others).layers
    return layer.state


def with_heights(first: int, end: int, height: float) -> ThicknessProfile:
    """A bead with another height on some samples [m]."""
    heights = bead().height.copy()
    heights[first:end] = height
    return bead(height=heights)


def test_a_sound_layer_carries_the_next() -> None:
    found = state(bead())
    assert (found.next_layer, found.obstacles) == (NextLayer.YES, ())
    assert (found.seen, found.longest_gap, found.longest_unseen) == (1.0, 0.0, 0.0)
    assert (found.height, found.highest, found.lowest) == (HEIGHT_M, HEIGHT_M, HEIGHT_M)


def test_a_gap_that_is_longer_than_a_bead_spans_forbids_it() -> None:
    found = state(with_gap(100, 120))
    assert (found.next_layer, found.obstacles) == (NextLayer.NO, (Obstacle.GAP,))
    assert found.longest_gap == pytest.approx(20 * SPACING_M)
    assert state(with_gap(100, 109)).next_layer == NextLayer.YES
    assert state(with_gap(100, 120), bridged_length=0.005).next_layer == NextLayer.YES


def test_ink_that_the_nozzle_would_touch_forbids_it() -> None:
    limit = HEIGHT_M + 0.75 * TIP_M + 2e-5  # two sigmas
    found = state(with_heights(100, 106, limit + 1e-6))
    assert (found.next_layer, found.obstacles) == (NextLayer.NO, (Obstacle.HIGH,))
    assert found.highest == pytest.approx(limit + 1e-6)
    assert state(with_heights(100, 106, limit - 1e-6)).next_layer == NextLayer.YES
    assert state(with_heights(100, 104, limit + 1e-6)).next_layer == NextLayer.YES  # too few
    assert state(with_heights(100, 106, limit + 1e-6), highest=1.0).next_layer == NextLayer.YES


def test_where_the_nozzle_seems_lower_than_the_ink_it_is_taken_to_be_as_high() -> None:
    line = with_heights(100, 106, 1.7 * HEIGHT_M)
    side = np.array((0.0, WIDTH_M / 2, 0.0))
    sunk = replace(line, left_points=line.points + side, right_points=line.points - side)
    assert state(sunk).next_layer == NextLayer.YES


def test_ink_that_is_too_low_over_longer_than_a_bead_spans_forbids_it() -> None:
    found = state(with_heights(100, 112, 0.4 * HEIGHT_M))
    assert (found.next_layer, found.obstacles) == (NextLayer.NO, (Obstacle.LOW,))
    assert state(with_heights(100, 109, 0.4 * HEIGHT_M)).next_layer == NextLayer.YES
    assert state(with_heights(100, 112, 0.48 * HEIGHT_M)).next_layer == NextLayer.YES  # in doubt
    assert state(with_heights(100, 112, 0.4 * HEIGHT_M), lowest=0.0).next_layer == NextLayer.YES


def test_the_height_wanted_counts_where_it_is_told() -> None:
    wanted = ToleranceConfig(target_height=2.5 * HEIGHT_M)
    assert state(bead(), tolerance=wanted).obstacles == (Obstacle.LOW,)


def test_without_heights_it_is_not_known() -> None:
    found = state(bead(height=np.full(COUNT, np.nan)))
    assert (found.next_layer, found.obstacles) == (
        NextLayer.NOT_KNOWN, (Obstacle.HEIGHT_NOT_KNOWN,))
    assert np.isnan((found.height, found.highest, found.lowest)).all()


@pytest.mark.parametrize('status', [Status.NO_DATA, Status.OCCLUDED, Status.LOW_CONFIDENCE])
def test_what_is_hidden_for_longer_than_a_bead_spans_may_be_a_gap(status: Status) -> None:
    found = state(with_status(bead(), status, (100, 112)))
    assert (found.next_layer, found.obstacles) == (
        NextLayer.NOT_KNOWN, (Obstacle.NOT_ENOUGH_SEEN,))
    assert found.longest_unseen == pytest.approx(12 * SPACING_M)
    assert state(with_status(bead(), status, (100, 109))).next_layer == NextLayer.YES


def test_too_little_in_all_is_not_enough() -> None:
    spots = tuple((at, at + 3) for at in range(5, 195, 10))
    assert state(with_status(bead(), Status.NO_DATA, *spots)).obstacles == (
        Obstacle.NOT_ENOUGH_SEEN,)
    assert state(with_status(bead(), Status.JUNCTION, *spots)).next_layer == NextLayer.YES


def test_what_is_seen_to_be_wrong_counts_though_not_all_is_seen() -> None:
    found = state(with_status(with_gap(100, 120), Status.OCCLUDED, (150, 190)))
    assert found.next_layer == NextLayer.NO
    assert found.obstacles == (Obstacle.GAP, Obstacle.NOT_ENOUGH_SEEN)


def test_contradictory_data_tell_nothing() -> None:
    found = state(with_gap(100, 120), reason=Reason.PATH_OFFSET)
    assert (found.next_layer, found.obstacles) == (
        NextLayer.NOT_KNOWN, (Obstacle.CONTRADICTION,))
