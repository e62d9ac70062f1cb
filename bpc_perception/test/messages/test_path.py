"""Paths from and to messages, field by field, and which messages are refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from message_builders import assert_same, NAN, refused, STAMP_NS
import numpy as np
from perception_builders import path_through
import pytest
from rclpy.serialization import serialize_message

from bpc_perception.messages.path import (
    path_from_message,
    path_to_message,
    path_to_nav,
    print_id_in,
)
from bpc_perception.messages.stamps import ConversionError, stamp_to_ns

pytestmark = pytest.mark.ros
PATH = replace(
    path_through(np.random.default_rng(0).normal(size=(7, 3)).cumsum(axis=0), start_ns=STAMP_NS,
                 extruding=[True, False] * 3 + [True], finished=False),
    flow_rate=np.array((1.0, NAN, 3, 4, 5, 6, 7)), plunger_velocity=np.arange(7.0),
    extruder_known=np.array([True] * 5 + [False, True]))


@pytest.mark.parametrize('path', [PATH, PATH.until(0), replace(PATH, finished=True)],
                         ids=['growing', 'empty', 'finished'])
def test_a_path_survives_there_and_back(path: Any) -> None:
    message = path_to_message(path, 'base')
    assert message.header.frame_id == 'base'
    assert_same(path_from_message(message), path)


def test_a_path_message_has_its_points_by_axis() -> None:
    message = path_to_message(PATH, 'base')
    assert [message.x[2], message.y[2], message.z[2]] == PATH.points[2].tolist()
    assert list(message.extruding) == [True, False] * 3 + [True]
    assert list(message.extruder_known) == [True] * 5 + [False, True]


@pytest.mark.parametrize(('rates', 'known'), [
    ((1.0, NAN, NAN, 4, 5, NAN, 7), [True, False, True, True, True, False, True]),
    ((NAN,) * 7, [True] * 7)], ids=['rates', 'on or off'])
def test_an_older_recording_tells_by_its_rates_what_is_known(rates: tuple[float, ...],
                                                             known: list[bool]) -> None:
    message = path_to_message(replace(
        PATH, flow_rate=np.array(rates), plunger_velocity=np.array(rates)), 'base')
    message.extruder_known = []
    assert path_from_message(message).extruder_known.tolist() == known


@pytest.mark.parametrize('name', ['time', 'arc_length', 'x', 'y', 'z', 'plunger_velocity',
                                  'flow_rate', 'extruding'])
def test_a_path_with_arrays_of_different_lengths_is_refused(name: str) -> None:
    message = path_to_message(PATH, 'base')
    setattr(message, name, getattr(message, name)[:-1])
    with pytest.raises(ConversionError,
                       match=rf"^deposition_path: expected arrays of one length.*'{name}': 6"):
        path_from_message(message)


@pytest.mark.parametrize(('name', 'value'), [
    ('x', NAN), ('z', np.inf), ('time', NAN), ('time', 0.0), ('arc_length', NAN),
    ('arc_length', -1.0)])
def test_a_path_of_impossible_points_is_refused(name: str, value: float) -> None:
    message = path_to_message(PATH, 'base')
    getattr(message, name)[3] = value
    with refused:
        path_from_message(message)


def test_a_path_for_viewers_has_places_and_times() -> None:
    message = path_to_nav(PATH, 'base')
    assert message.header.frame_id == 'base'
    assert len(message.poses) == 7
    position = message.poses[4].pose.position
    assert [position.x, position.y, position.z] == PATH.points[4].tolist()
    assert stamp_to_ns(message.poses[4].header.stamp) == pytest.approx(
        STAMP_NS + PATH.time[4] * 1e9, abs=1)


@pytest.mark.parametrize('frame', ['', 'b', 'base', 'lbr_link_0', 'a frame with a longer name'])
@pytest.mark.parametrize('print_id', ['', '20260711T122333.088Z', 'ink ü'])
def test_the_print_is_found_without_unpacking_the_path(frame: str, print_id: str) -> None:
    data = serialize_message(path_to_message(replace(PATH, print_id=print_id), frame))
    assert print_id_in(data) == print_id
