"""What picture and cloud tell together, of beads whose widths are set by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from perception_builders import sections_of
import pytest

from bpc_perception.core.measurement.cross_section.by_cloud.cloud_beads import (
    BeadModel,
    CloudBeads,
    Lines,
    MOST_LEANS,
)
from bpc_perception.core.measurement.cross_section.edges.edges import Edges
from bpc_perception.core.measurement.cross_section.second_opinion import (
    ask_cloud,
    lines_in_picture,
    Told,
    told_by_both,
)
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.profile import Cause, Status

Array = NDArray[np.float64]
MM = 1e-3
COUNT, PIXEL = 300, 0.2 * MM
OFFSET = np.arange(-20, 21) * PIXEL / 2
SECTIONS = sections_of(np.zeros((COUNT, len(OFFSET))), OFFSET, PIXEL, PIXEL)
SIGMA = 0.02 * MM
ODD = slice(100, 110)


def told(width: Array | float, sigma: float = SIGMA, common: float = 0.01 * MM) -> Told:
    half = np.broadcast_to(width, COUNT) / 2
    return Told(half, half, np.full(COUNT, sigma), np.full(COUNT, common))


def beads(width: Array | float) -> CloudBeads:
    half = np.broadcast_to(width, COUNT) / 2
    return CloudBeads(half, half, np.full(COUNT, SIGMA), np.ones(COUNT))


def verdicts(cause: Cause = Cause.NONE, where: slice = ODD) -> Verdicts:
    found = Verdicts.all_of(COUNT, Status.MEASURED)
    chosen = np.zeros(COUNT, bool)
    chosen[where] = cause != Cause.NONE
    return found.where(chosen, Status.LOW_CONFIDENCE, cause)


def ask(picture: Told, width: Array | float, seen: Verdicts,
        of_use: bool = True) -> tuple[Told, Verdicts]:
    return told_by_both(picture, told(width), beads(width), seen, SECTIONS, 0.15,
                        picture_of_use=of_use)


def with_odd(width: float, odd: float) -> Array:
    values = np.full(COUNT, width)
    values[ODD] = odd
    return values


def test_both_count_as_far_as_they_are_sure() -> None:
    found, seen = ask(told(1.50 * MM, sigma=0.04 * MM), 1.55 * MM, verdicts())
    np.testing.assert_allclose(found.width, 1.54 * MM)
    np.testing.assert_allclose(found.sigma, 0.04 * MM / 5**0.5)
    assert (seen.status == Status.MEASURED).all()


@pytest.mark.parametrize('cause', [Cause.GLARE, Cause.LOW_CONTRAST, Cause.NO_EDGE,
                                   Cause.FAINT_EDGES])
def test_where_the_picture_has_no_edge_the_cloud_tells_alone(cause: Cause) -> None:
    found, seen = ask(told(with_odd(1.5 * MM, np.nan)), 1.5 * MM, verdicts(cause))
    np.testing.assert_allclose(found.width, 1.5 * MM)
    assert (seen.status == Status.MEASURED).all()
    assert (seen.cause == Cause.NONE).all()


@pytest.mark.parametrize('cause', [Cause.OVEREXPOSED, Cause.INK_ENDS, Cause.PARTLY_INK])
def test_what_the_cloud_cannot_make_good_stays_unknown(cause: Cause) -> None:
    _, seen = ask(told(with_odd(1.5 * MM, np.nan)), 1.5 * MM, verdicts(cause))
    assert (seen.cause[ODD] == cause).all()


def test_widths_that_contradict_each_other_are_refused() -> None:
    _, seen = ask(told(with_odd(1.5 * MM, 2.1 * MM)), 1.5 * MM, verdicts())
    assert (seen.status[ODD] == Status.LOW_CONFIDENCE).all()
    assert (seen.cause[ODD] == Cause.UNSURE_FEET).all()
    assert (np.delete(seen.status, np.r_[ODD]) == Status.MEASURED).all()


def test_a_picture_of_no_use_is_not_asked() -> None:
    found, seen = ask(told(with_odd(1.1 * MM, np.nan)), 1.5 * MM, verdicts(Cause.PARTLY_INK),
                      of_use=False)
    np.testing.assert_allclose(found.width, 1.5 * MM)
    assert (seen.status == Status.MEASURED).all()


def test_where_the_cloud_shows_no_even_bead_the_picture_tells_alone() -> None:
    found, seen = ask(told(1.5 * MM), with_odd(1.5 * MM, 2.2 * MM), verdicts())
    np.testing.assert_allclose(found.width, 1.5 * MM)
    assert (seen.status == Status.MEASURED).all()
    _, seen = ask(told(with_odd(1.5 * MM, np.nan)), with_odd(1.5 * MM, 2.2 * MM),
                  verdicts(Cause.GLARE))
    assert (seen.cause[ODD] == Cause.GLARE).all()


def test_where_the_cloud_is_not_sure_enough_nothing_is_told() -> None:
    seen = verdicts(Cause.GLARE)
    cloud = replace(told(1.5 * MM), sigma=np.full(COUNT, 0.3 * MM))
    _, found = told_by_both(told(1.5 * MM), cloud, beads(1.5 * MM), seen, SECTIONS, 0.15,
                            picture_of_use=True)
    assert (found.cause[ODD] == Cause.GLARE).all()


def edges(distance: Array | float) -> Edges:
    no = np.zeros(COUNT, bool)
    return Edges(np.broadcast_to(distance, COUNT).astype(float), np.full(COUNT, SIGMA), no, no, no)


def test_a_picture_that_tells_less_than_half_or_is_uneven_is_of_no_use() -> None:
    usual = edges(0.75 * MM)
    lines = lines_in_picture(SECTIONS, usual, usual, verdicts())
    assert lines is not None
    np.testing.assert_allclose(lines.half, 0.75 * MM)
    most = verdicts(Cause.LOW_CONTRAST, slice(0, 200))
    assert lines_in_picture(SECTIONS, usual, usual, most) is None
    # What lies outside of the image says nothing of the picture.
    outside = verdicts().where(np.arange(COUNT) < 200, Status.NO_DATA, Cause.OUTSIDE_IMAGE)
    assert lines_in_picture(SECTIONS, usual, usual, outside) is not None
    rng = np.random.default_rng(1)
    wild = edges(0.75 * MM * rng.uniform(0.7, 1.3, COUNT))
    assert lines_in_picture(SECTIONS, wild, wild, verdicts()) is None


def test_where_the_cloud_shows_nothing_the_picture_is_of_use() -> None:
    bare = sections_of(np.full((COUNT, len(OFFSET)), np.nan), OFFSET, PIXEL, PIXEL)
    lines = Lines(np.zeros(COUNT), np.full(COUNT, 0.5 * MM))
    model = BeadModel(np.tile((0.6, 2.0, 1.0, 0.0), (MOST_LEANS, 1)), sigma=0.02)
    found, _, of_use = ask_cloud(bare, np.zeros(COUNT), lines, model)
    assert np.isnan(found.width).all()
    assert of_use
