"""Views for people: colours, overlay and markers, of a band whose place is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
import re

import numpy as np
from perception_builders import band_image, capture_of, DOWN, PIXEL, pixel_path, SECOND, START_NS
import pytest
from rclpy.serialization import serialize_message
from visualization_msgs.msg import Marker
import yaml

from bpc_perception.core.config import AdviceConfig, ThicknessConfig
from bpc_perception.core.profile import Status
from bpc_perception.core.result import Result
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.session import Session
from bpc_perception.display.layers import NEWEST
from bpc_perception.display.legend import (
    deviation_colours,
    LEFT_COLOUR,
    ON_TARGET_COLOUR,
    rgb,
    RIGHT_COLOUR,
    STATUS_COLOURS,
    TARGET_COLOUR,
    TOO_THICK_COLOUR,
)
from bpc_perception.display.overlay import draw_overlay
from bpc_perception.messages import topics
from bpc_perception.messages.views import (
    deviation_message,
    markers_message,
    overlay_message,
    width_message,
)

WIDTH_TRUE = 11 * PIXEL  # rows 50 to 60
SCALE = 6  # from 160 pixels to 900 or more
BASE = 'lbr_link_0'


def measured(target: float = WIDTH_TRUE, end: float = 120) -> Result:
    """Measure the band along a path from column 40 to ``end``, beyond 100, one sample a pixel."""
    session = Session(ThicknessConfig(advice=AdviceConfig(target_thickness=target)),
                      HandEye(True, DOWN))
    session.set_path(pixel_path((40, 55), (end, 55), round(end) - 39))
    session.add_capture(capture_of(band_image(), START_NS + 100 * SECOND))
    result, = session.results(finish=True)
    assert result.profile is not None, result.refusal
    return result


def marker(result: Result, namespace: str) -> Marker:
    found, = (each for each in markers_message(result, BASE).markers if each.ns == namespace)
    return found


def test_deviation_goes_from_thin_over_right_to_thick() -> None:
    thin, right, half, thick, unknown = deviation_colours(np.array((-0.3, 0, 0.1, 0.2, np.nan)))
    assert tuple(right) == rgb(ON_TARGET_COLOUR)
    assert tuple(thick) == rgb(TOO_THICK_COLOUR)
    assert tuple(unknown) == rgb(STATUS_COLOURS[Status.NO_DATA])
    middle = (np.array(rgb(TOO_THICK_COLOUR)) + rgb(ON_TARGET_COLOUR)) / 2
    np.testing.assert_allclose(half, middle, atol=1)
    assert thin[2] > thin[0]  # blue


def test_side_points_are_drawn_on_the_edges() -> None:
    picture = draw_overlay(measured())
    assert picture.shape == (120 * SCALE, 160 * SCALE, 3)
    for edge, colour in ((49.5, LEFT_COLOUR), (60.5, RIGHT_COLOUR)):
        row, column = (round((place + 0.5) * SCALE - 0.5) for place in (edge, 80))
        assert tuple(picture[row, column]) == rgb(colour)
    # Between them is the image itself.
    np.testing.assert_array_equal(picture[55 * SCALE, 80 * SCALE], band_image()[55, 80])


def test_a_gap_is_drawn_along_the_path() -> None:
    picture = draw_overlay(measured(end=150))  # the band ends at column 130
    row, column = (round((place + 0.5) * SCALE - 0.5) for place in (55, 140))
    assert tuple(picture[row, column]) == rgb(STATUS_COLOURS[Status.GAP])


def test_of_a_print_in_layers_one_is_drawn_the_newest_unless_told_otherwise() -> None:
    result = measured()
    profile = result.profile
    assert profile is not None
    half = len(profile) // 2
    layered = replace(result, profile=replace(
        profile, layer=np.where(np.arange(len(profile)) < half, 0, 1)))
    left = [round((np.interp(place, (0, len(profile) - 1), (40, 120)) + 0.5) * SCALE - 0.5)
            for place in (half / 2, 1.5 * half)]
    row = round((49.5 + 0.5) * SCALE - 0.5)
    drawn = [[tuple(draw_overlay(layered, layer)[row, column]) == rgb(LEFT_COLOUR)
              for column in left] for layer in (NEWEST, 0, 1)]
    assert drawn == [[False, True], [True, False], [False, True]]


def test_the_scale_bar_is_as_long_as_it_says() -> None:
    picture = draw_overlay(measured())
    bar = (picture[-12] == rgb(TARGET_COLOUR)).all(axis=1)
    assert bar.sum() * PIXEL / SCALE == pytest.approx(5e-3, abs=4 * PIXEL / SCALE)


def test_nothing_is_drawn_of_what_was_refused() -> None:
    with pytest.raises(ValueError, match='overlay: expected a measured capture, found: no path'):
        draw_overlay(Result(capture_of(band_image()), refusal='no path'))


def test_overlay_message_is_the_picture() -> None:
    result = measured()
    message = overlay_message(result)
    assert (message.encoding, message.width, message.height) == ('rgb8', 960, 720)
    assert message.header.frame_id == result.capture.frame_id
    assert bytes(message.data) == draw_overlay(result).tobytes()
    assert len(serialize_message(message)) > 960 * 720 * 3


def test_markers_are_in_the_base_frame_and_replace_those_before() -> None:
    message = markers_message(measured(), BASE)
    assert message.markers[0].action == Marker.DELETEALL
    assert {each.header.frame_id for each in message.markers} == {BASE}
    names = [(each.ns, each.id) for each in message.markers]
    assert len(set(names)) == len(names)
    assert serialize_message(message)


@pytest.mark.parametrize(('target', 'colour'), [
    (WIDTH_TRUE, ON_TARGET_COLOUR), (0.8 * WIDTH_TRUE, TOO_THICK_COLOUR)])
def test_the_ribbon_lies_between_the_side_points(target: float, colour: str) -> None:
    result = measured(target)
    assert result.profile is not None
    ribbon = marker(result, 'thickness')
    known = int((result.profile.status == Status.MEASURED).sum())
    assert len(ribbon.points) == len(ribbon.colors) == 6 * (known - 1)
    y = np.array([point.y for point in ribbon.points])
    assert np.ptp(y) == pytest.approx(WIDTH_TRUE, abs=0.2 * PIXEL)
    colours = np.array([(each.r, each.g, each.b) for each in ribbon.colors]) * 255
    np.testing.assert_allclose(np.median(colours, axis=0), rgb(colour), atol=25)


def test_where_nothing_is_measured_there_is_no_ribbon() -> None:
    result = measured()
    assert result.profile is not None
    lost = replace(result.profile, status=np.full(len(result.profile), Status.OCCLUDED, np.uint8))
    message = markers_message(replace(result, profile=lost), BASE)
    assert 'thickness' not in {each.ns for each in message.markers}
    assert 'occluded' in {each.ns for each in message.markers}


def test_scalars_are_those_of_the_advice() -> None:
    result = measured(WIDTH_TRUE / 1.1)
    assert width_message(result).data == pytest.approx(WIDTH_TRUE, abs=0.2 * PIXEL)
    assert deviation_message(result).data == pytest.approx(0.1, abs=0.02)
    assert np.isnan(deviation_message(measured(0.0)).data)


@pytest.mark.parametrize('file', ['rviz/bpc.rviz', 'foxglove/bpc.json'])
def test_layouts_look_at_topics_that_exist(file: str) -> None:
    text = (Path(__file__).parents[2] / file).read_text(encoding='utf-8')
    assert yaml.safe_load(text)  # JSON is YAML as well
    named = set(re.findall(r'"?/((?:thickness|deposition_path|points|rate)[\w/]*)', text))
    known = {*topics.CAMERA, *topics.RESULTS, *topics.VIEWS}
    assert topics.MARKERS in named
    assert named <= known


def test_each_layer_has_namespaces_of_its_own() -> None:
    """Viewers show and hide namespaces."""
    result = measured()
    flat = {marker.ns for marker in markers_message(result, 'base').markers}
    assert not any('layer' in name for name in flat)
    profile = result.profile
    assert profile is not None
    layer = np.arange(len(profile)) * 2 // len(profile)
    layered = markers_message(replace(result, profile=replace(profile, layer=layer)), 'base')
    names = {marker.ns for marker in layered.markers}
    assert {'thickness, layer 0', 'thickness, layer 1'} <= names
