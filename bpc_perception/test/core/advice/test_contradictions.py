"""Widths that contradict themselves are no reason for more ink."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.advice.contradictions import Contradictions
from bpc_perception.core.profile import Status, ThicknessProfile

MM = 1e-3
ALL = (0.0, 1.0)
NEWEST = (60 * MM, 1.0)


def print_of(widths: list[float], left: list[float] | None = None) -> ThicknessProfile:
    """Samples 1 mm apart of these widths [mm], whose left edges are where told [mm]."""
    width = np.array(widths) * MM
    profile = profile_of(width.tolist())
    far = width / 2 if left is None else np.array(left) * MM
    return replace(profile, left=far, right=width - far)


def test_a_print_that_is_as_it_was_does_not_contradict_itself() -> None:
    contradictions = Contradictions()
    assert not contradictions.found(print_of([2.0] * 50), ALL)
    assert not contradictions.found(print_of([1.95] * 50 + [2.1] * 20), ALL)


def test_ink_does_not_become_narrower() -> None:
    contradictions = Contradictions()
    assert not contradictions.found(print_of([2.0] * 60), ALL)
    assert contradictions.found(print_of([2.0] * 40 + [1.6] * 20), ALL)
    assert contradictions.found(print_of([2.0] * 40 + [1.6] * 20), ALL)  # it stays in doubt


def test_ink_that_spreads_is_believed() -> None:
    contradictions = Contradictions()
    assert not contradictions.found(print_of([2.0] * 60), ALL)
    assert not contradictions.found(print_of([2.4] * 60), ALL)


@pytest.mark.parametrize(('left', 'hidden'), [(0.7, False), (1.0, True), (0.4, True)])
def test_less_ink_narrows_a_bead_from_both_sides(left: float, hidden: bool) -> None:
    """A bead of 1.4 after one of 2 mm: symmetrical, or with one edge where it was."""
    profile = print_of([2.0] * 60 + [1.4] * 30, [1.0] * 60 + [left] * 30)
    assert Contradictions().found(profile, NEWEST) is hidden


@pytest.mark.parametrize(('left', 'hidden'), [(0.7, False), (0.4, True)])
def test_ink_that_is_cut_off_from_the_start_is_no_less_ink(left: float, hidden: bool) -> None:
    profile = print_of([1.4] * 50 + [2.0] * 30, [left] * 50 + [1.0] * 30)
    assert Contradictions().found(profile, ALL) is hidden


def test_what_was_not_measured_says_nothing() -> None:
    contradictions = Contradictions()
    profile = print_of([2.0] * 60)
    assert not contradictions.found(profile, ALL)
    blind = replace(profile, status=np.full(60, Status.LOW_CONFIDENCE, np.uint8),
                    thickness=np.full(60, 1.0 * MM))
    assert not contradictions.found(blind, ALL)
