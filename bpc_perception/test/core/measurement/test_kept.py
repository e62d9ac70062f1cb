"""What was found of a sample stays, unless it is found better."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from perception_builders import path_through

from bpc_perception.core.measurement.kept import Kept
from bpc_perception.core.measurement.layered import away_from_above, with_covered
from bpc_perception.core.measurement.samples import Samples, unseen
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.profile import Status

MM = 1e-3
COUNT = 6
PATH = path_through(np.column_stack((np.arange(COUNT) * MM, np.zeros((COUNT, 2)))))


def samples(status: list[Status], sigma: list[float]) -> Samples:
    """Samples of which only status and sigma matter."""
    found = np.array(status, np.uint8)
    return replace(unseen(len(status)), verdicts=Verdicts(found, np.zeros_like(found)),
                   sigma=np.array(sigma))


def test_the_best_look_is_kept() -> None:
    kept = Kept.of(PATH, samples([Status.MEASURED] * 3 + [Status.NO_DATA] * 3,
                                 [0.1, 0.2, 0.3, np.nan, np.nan, np.nan]))
    new = samples([Status.MEASURED, Status.MEASURED, Status.OCCLUDED, Status.GAP,
                   Status.JUNCTION, Status.MEASURED], [0.15, 0.15, np.nan, np.nan, np.nan, 0.4])
    better = kept.with_better(np.arange(COUNT), new)
    np.testing.assert_array_equal(better.samples.status, [
        Status.MEASURED, Status.MEASURED, Status.MEASURED, Status.GAP, Status.JUNCTION,
        Status.MEASURED])
    np.testing.assert_array_equal(better.samples.sigma, [0.1, 0.15, 0.3, np.nan, np.nan, 0.4])
    np.testing.assert_array_equal(better.looks, [2, 2, 1, 1, 0, 1])


def test_new_path_knows_nothing_and_another_print_begins_anew() -> None:
    kept = Kept.of(PATH, samples([Status.MEASURED] * COUNT, [0.1] * COUNT))
    longer = path_through(np.column_stack((np.arange(COUNT + 2) * MM, np.zeros((COUNT + 2, 2)))))
    np.testing.assert_array_equal(kept.at(longer).samples.status,
                                  [Status.MEASURED] * COUNT + [Status.NO_DATA] * 2)
    other = path_through(PATH.points, print_id='other')
    assert set(kept.at(other).samples.status) == {Status.NO_DATA}


def test_ink_above_covers_what_is_near_below() -> None:
    along = np.arange(0, 10, 0.2) * MM
    places = np.concatenate((np.column_stack((along, 0 * along)),  # on the bed
                             np.column_stack((0 * along + 5 * MM, along - 5 * MM))))  # across it
    layer = np.repeat((0, 1), len(along))
    covered = away_from_above(places, layer, 2.6 * MM) < 1.3 * MM
    np.testing.assert_array_equal(covered[:len(along)], np.abs(along - 5 * MM) < 1.3 * MM)
    assert not covered[len(along):].any()
    shown = with_covered(samples([Status.MEASURED, Status.LOW_CONFIDENCE], [0.1, np.nan]),
                         np.array((True, True)))
    np.testing.assert_array_equal(shown.status, [Status.MEASURED, Status.OCCLUDED])


def test_what_is_hidden_now_is_known_from_before() -> None:
    kept = Kept.of(PATH, samples([Status.MEASURED, Status.GAP, Status.MEASURED, Status.NO_DATA,
                                  Status.MEASURED, Status.JUNCTION], [0.1] * COUNT))
    now = samples([Status.OCCLUDED, Status.NO_DATA, Status.LOW_CONFIDENCE, Status.OCCLUDED,
                   Status.MEASURED, Status.NO_DATA], [0.2] * COUNT)
    shown = kept.where_unseen(now)
    np.testing.assert_array_equal(shown.status, [
        Status.MEASURED, Status.GAP, Status.LOW_CONFIDENCE, Status.OCCLUDED, Status.MEASURED,
        Status.NO_DATA])
    np.testing.assert_array_equal(shown.sigma, [0.1, 0.1, 0.2, 0.2, 0.2, 0.2])
