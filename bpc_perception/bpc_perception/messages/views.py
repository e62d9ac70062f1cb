"""Make messages of results for RViz, Foxglove, PlotJuggler and rqt: markers, overlay, scalars.

As for all messages, lengths are in metres and positions in the robot base frame.
"""

from __future__ import annotations

from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import Image
from std_msgs.msg import ColorRGBA, Float64, Header
from visualization_msgs.msg import Marker, MarkerArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.display.layers import layers_of, NEWEST
from bpc_perception.display.legend import (
    deviation_colours,
    LEFT_COLOUR,
    rgb,
    RIGHT_COLOUR,
    STATUS_COLOURS,
    TARGET_COLOUR,
)
from bpc_perception.display.overlay import draw_overlay
from bpc_perception.display.wording import advice_in_words, label
from bpc_perception.messages.array_fields import set_data
from bpc_perception.messages.stamps import ns_to_stamp

MOST_SAMPLES = 1000  # in markers: each point is an object, which takes time
DOT_SIZE_M, TEXT_HEIGHT_M = 6e-4, 4e-3


def overlay_message(result: Result, layer: int = NEWEST) -> Image:
    """Draw the measurement over the camera's image, as rgb8."""
    picture = draw_overlay(result, layer)
    height, width = picture.shape[:2]
    header = Header(stamp=ns_to_stamp(result.capture.stamp_ns), frame_id=result.capture.frame_id)
    message = Image(header=header, height=height, width=width, encoding='rgb8', step=3 * width)
    set_data(message, picture)
    return message


def width_message(result: Result) -> Float64:
    """Return the thickness over the window of the advice [m]; NaN = not known."""
    assert result.advice is not None
    return Float64(data=float(result.advice.measured_thickness))


def deviation_message(result: Result) -> Float64:
    """Return the deviation of that thickness from its target, as a share; NaN = not known."""
    assert result.advice is not None
    target = result.advice.target_thickness
    off = result.advice.measured_thickness / target - 1 if target > 0 else np.nan
    return Float64(data=float(off))


def markers_message(result: Result, frame_id: str) -> MarkerArray:
    """Make markers of the filament: a ribbon, its sides, samples without thickness, the advice.

    The ribbon is coloured by its deviation from the target, or from the median without a target.
    The first marker deletes those of the profile before; all stay until then.
    """
    profile, advice = result.profile, result.advice
    assert profile is not None
    assert advice is not None
    header = Header(stamp=Time(), frame_id=frame_id)  # stamp 0: viewers take the newest transform
    shown = np.arange(0, len(profile), -(-len(profile) // MOST_SAMPLES) or 1)
    target = advice.target_thickness
    usual = target if target > 0 else profile.summary.thickness_median
    markers = [Marker(action=Marker.DELETEALL)]
    layers = layers_of(profile)
    for layer, own in layers:
        # Viewers show and hide namespaces.
        name = f', layer {layer}' if len(layers) > 1 else ''
        markers += _layer_markers(profile, shown[own[shown]], usual, name)
    if len(profile):
        markers.append(_marker('advice', Marker.TEXT_VIEW_FACING, TARGET_COLOUR, z=TEXT_HEIGHT_M,
                               text=advice_in_words(advice),
                               pose=_upright(profile.points[-1] + (0, 0, 2 * TEXT_HEIGHT_M))))
    for marker in markers:
        marker.header = header
    return MarkerArray(markers=markers)


def _layer_markers(profile: ThicknessProfile, shown: NDArray[np.intp], usual: float,
                   name: str) -> list[Marker]:
    """Draw the samples of an index (K,); a name is added to the namespaces."""
    markers = _ribbon(profile, shown, usual, name)
    measured = profile.status[shown] == Status.MEASURED
    for side, points, colour in (('left side', profile.left_points, LEFT_COLOUR),
                                 ('right side', profile.right_points, RIGHT_COLOUR)):
        markers += _dots(side + name, points[shown][measured], colour)
    for status in Status:
        if status != Status.MEASURED:
            markers += _dots(label(status) + name,
                             profile.points[shown][profile.status[shown] == status],
                             STATUS_COLOURS[status])
    return markers


def no_view(kind: Any, frame_id: str) -> Any:
    """Return a message of one of these types without a print: no markers, NaN, a black pixel."""
    header = Header(frame_id=frame_id)
    if kind is MarkerArray:
        return MarkerArray(markers=[Marker(header=header, action=Marker.DELETEALL)])
    if kind is Image:
        return Image(height=1, width=1, encoding='rgb8', step=3, data=bytes(3))
    return Float64(data=float('nan'))


def _ribbon(profile: ThicknessProfile, shown: NDArray[np.intp], usual: float,
            name: str) -> list[Marker]:
    """Draw two triangles from each sample to the next if both are measured."""
    colours = deviation_colours(profile.thickness[shown] / usual - 1)
    left, right = profile.left_points[shown], profile.right_points[shown]
    measured = profile.status[shown] == Status.MEASURED
    stroke = profile.stroke[shown]
    starts = np.flatnonzero(measured[:-1] & measured[1:] & (stroke[:-1] == stroke[1:]))
    if not len(starts):
        return []
    corners = np.stack((left[starts], right[starts], left[starts + 1],
                        right[starts], right[starts + 1], left[starts + 1]), axis=1)
    sample = np.stack((starts, starts, starts + 1, starts, starts + 1, starts + 1), axis=1)
    palette = [_colour(tuple(colour)) for colour in colours.tolist()]
    return [_marker(f'thickness{name}', Marker.TRIANGLE_LIST, TARGET_COLOUR, x=1.0, y=1.0, z=1.0,
                    points=[_point(point) for point in corners.reshape(-1, 3)],
                    colors=[palette[index] for index in sample.ravel().tolist()])]


def _dots(name: str, points: Array, colour: str) -> list[Marker]:
    if not len(points):
        return []
    return [_marker(name, Marker.SPHERE_LIST, colour, x=DOT_SIZE_M, y=DOT_SIZE_M,
                    z=DOT_SIZE_M, points=[_point(point) for point in points])]


def _marker(namespace: str, kind: int, colour: str, x: float = 0.0, y: float = 0.0,
            z: float = 0.0, **more: object) -> Marker:
    """Make a marker that stays; x, y, z are its scale [m]."""
    marker = Marker(ns=namespace, type=kind, action=Marker.ADD, color=_colour(rgb(colour)),
                    **{'pose': _upright(np.zeros(3)), **more})
    marker.scale.x, marker.scale.y, marker.scale.z = x, y, z
    return marker


def _upright(place: Array) -> Pose:
    return Pose(position=_point(place), orientation=Quaternion(w=1.0))


def _point(place: Array) -> Point:
    x, y, z = place.tolist()
    return Point(x=x, y=y, z=z)


def _colour(values: tuple[int, ...]) -> ColorRGBA:
    red, green, blue = (value / 255 for value in values)
    return ColorRGBA(r=red, g=green, b=blue, a=1.0)
