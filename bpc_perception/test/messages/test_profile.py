"""Profiles from and to messages, field by field, and which messages are refused."""

from __future__ import annotations

from dataclasses import replace
import math

from message_builders import assert_same, NAN
import numpy as np
from perception_builders import profile_of
import pytest

from bpc_interfaces.msg import ThicknessProfile as ThicknessProfileMsg
from bpc_perception.core.growing_profile import change_between
from bpc_perception.core.profile import Cause, Status
from bpc_perception.messages.profile import (
    change_from_message,
    change_to_message,
    profile_from_message,
    profile_to_message,
)
from bpc_perception.messages.stamps import ConversionError

pytestmark = pytest.mark.ros
PROFILE = replace(
    profile_of([1e-3, 0, NAN, 3e-3, NAN, NAN], [Status.MEASURED, Status.GAP, Status.NO_DATA,
                                               Status.MEASURED, Status.OCCLUDED,
                                               Status.LOW_CONFIDENCE],
               extruding=[True, False, True, True, False, True]),
    extruder_known=np.array((True, False, True, True, False, True)),
    stroke=np.array((1, 1, 1, 2, 2, 2), np.intp),
    left=np.arange(6.0), right=-np.arange(6.0), sigma=np.arange(6.0) / 7,
    points=np.arange(18.0).reshape(6, 3), left_points=np.arange(18.0).reshape(6, 3) + 100,
    right_points=np.arange(18.0).reshape(6, 3) + 200)


def test_a_profile_survives_there_and_back() -> None:
    message = profile_to_message(PROFILE, 'base')
    assert message.header.frame_id == 'base'
    assert_same(profile_from_message(message), PROFILE)


def test_an_empty_profile_survives_there_and_back() -> None:
    profile = profile_of([])
    message = profile_to_message(profile, 'base')
    assert np.isnan(message.coverage)
    found = profile_from_message(message)
    assert len(found) == 0
    assert found.points.shape == (0, 3)


def test_a_profile_message_carries_the_summary() -> None:
    message = profile_to_message(PROFILE, 'base')
    assert message.thickness_mean == pytest.approx(2e-3)
    assert message.thickness_std == pytest.approx(1e-3)
    assert message.thickness_q1 == pytest.approx(1.5e-3)
    assert message.thickness_median == pytest.approx(2e-3)
    assert message.thickness_q3 == pytest.approx(2.5e-3)
    assert message.coverage == 0.5
    assert message.gap_count == 1
    assert message.gap_length == pytest.approx(1e-3)
    assert message.processing_time == 0.25


def test_a_profile_message_carries_its_strokes_and_travel() -> None:
    travel = replace(
        PROFILE, stroke=np.array((1, 0, 0, 0, 2, 2), np.intp), status=np.array((
            Status.MEASURED, Status.BARE, Status.OOZE, Status.BARE, Status.GAP, Status.MEASURED),
            np.uint8), time=np.arange(6.0), thickness=np.array((1e-3, NAN, NAN, NAN, 0, 3e-3)))
    message = profile_to_message(travel, 'base')
    assert list(message.stroke) == [1, 0, 0, 0, 2, 2]
    assert list(message.stroke_number) == [1, 2]
    np.testing.assert_allclose(message.stroke_start, (0, 4e-3))
    np.testing.assert_allclose(message.stroke_end, (0, 5e-3))
    np.testing.assert_allclose(message.ink_start, (0, 4.5e-3))
    np.testing.assert_allclose(message.ink_end, (0, 5e-3))
    assert message.ooze_count == 1
    assert message.ooze_length == pytest.approx(1e-3)
    assert message.bare_length == pytest.approx(1e-3)  # of travel, 2 mm from end to end
    assert message.coverage == 1
    assert_same(profile_from_message(message), travel)


def test_a_profile_of_an_older_recording_is_one_stroke() -> None:
    message = profile_to_message(PROFILE, 'base')
    message.extruder_known, message.stroke = [], []
    for name in STROKE_ARRAYS:
        setattr(message, name, [])
    assert_same(profile_from_message(message), replace(
        PROFILE, extruder_known=np.ones(6, bool), stroke=np.ones(6, np.intp)))


STROKE_ARRAYS = ('stroke_number', 'stroke_start', 'stroke_end', 'ink_start', 'ink_end')
ARRAYS = [name for name, kind in ThicknessProfileMsg.get_fields_and_field_types().items()
          if kind.startswith('sequence')]


@pytest.mark.parametrize('name', ARRAYS)
def test_a_profile_with_arrays_of_different_lengths_is_refused(name: str) -> None:
    message = profile_to_message(PROFILE, 'base')
    setattr(message, name, getattr(message, name)[:-1])
    length = 1 if name in STROKE_ARRAYS else 5
    with pytest.raises(ConversionError, match=rf"expected arrays .*'{name}': {length}"):
        profile_from_message(message)


@pytest.mark.parametrize(('name', 'value'), [
    ('status', max(Status) + 1), ('status', 255), ('cause', max(Cause) + 1),
    ('thickness', math.nan), ('thickness', math.inf),
    ('thickness', 0.0), ('thickness', -1e-3)])
def test_a_profile_of_impossible_samples_is_refused(name: str, value: float) -> None:
    message = profile_to_message(PROFILE, 'base')
    assert message.status[0] == Status.MEASURED
    getattr(message, name)[0] = value
    with pytest.raises(ConversionError, match=rf'expected .*{name}.* found {value}'):
        profile_from_message(message)


@pytest.mark.parametrize('status', list(Status))
def test_status_numbers_are_those_of_the_message(status: Status) -> None:
    assert getattr(ThicknessProfileMsg, status.name) == status


@pytest.mark.parametrize('cause', list(Cause))
def test_cause_numbers_are_those_of_the_message(cause: Cause) -> None:
    assert getattr(ThicknessProfileMsg, f'CAUSE_{cause.name}') == cause


def test_a_change_survives_there_and_back_with_the_summary_of_the_whole() -> None:
    after = replace(PROFILE, stamp_ns=PROFILE.stamp_ns + 1,
                    thickness=np.where(PROFILE.status == Status.MEASURED, 2e-3,
                                       PROFILE.thickness))
    change = change_between(PROFILE, after)
    assert change is not None
    message = change_to_message(change, after, 'base')
    assert message.profile.thickness_mean == pytest.approx(2e-3)
    assert message.profile.coverage == profile_to_message(after, 'base').coverage
    assert list(message.profile.stroke_number) == [1, 2]
    found = change_from_message(message)
    assert (found.base_ns, found.index.tolist()) == (PROFILE.stamp_ns, [0, 3])
    assert_same(found.part, change.part)


@pytest.mark.parametrize('index', [[0], [3, 0], [3, 3], [0, 3, 4]])
def test_a_change_without_a_place_for_each_sample_is_refused(index: list[int]) -> None:
    change = change_between(PROFILE, replace(
        PROFILE, thickness=np.where(PROFILE.status == Status.MEASURED, 2e-3, PROFILE.thickness)))
    assert change is not None
    message = change_to_message(change, PROFILE, 'base')
    message.index = index
    with pytest.raises(ConversionError, match='an increasing place for each sample'):
        change_from_message(message)
