"""Convert plans of repair from and to messages."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from std_msgs.msg import Header

from bpc_interfaces.msg import RepairPlan as RepairPlanMsg
from bpc_perception.core.arrays import Array
from bpc_perception.core.repair.plan import (
    Fill,
    FillKind,
    LayerRepair,
    LayerState,
    NextLayer,
    NotFilled,
    Obstacle,
    RepairPlan,
    Unfilled,
)
from bpc_perception.messages.array_fields import (
    axes_fields,
    check_lengths,
    floats_field,
    points_of,
)
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

STATE = tuple(each.name for each in fields(LayerState)[2:])
LAYER = ('layer_number', 'layer_finished', 'layer_next', *(f'layer_{name}' for name in STATE))
STRETCH = 'kind', 'stroke', 'layer', 'start', 'end'
FILL = *(f'fill_{name}' for name in (*STRETCH, 'speed')), 'fill_points'
POINT = 'point_arc_length', 'point_x', 'point_y', 'point_z', 'point_area', 'point_flow'
UNFILLED = tuple(f'unfilled_{name}' for name in (*STRETCH, 'x', 'y', 'z', 'reason'))


def repair_to_message(plan: RepairPlan, frame_id: str) -> RepairPlanMsg:
    """Convert a plan in a frame to a message."""
    layers = plan.layers
    fills = [each for layer in layers for each in layer.fills]
    unfilled = [each for layer in layers for each in layer.unfilled]
    obstacles = [(layer.number, each) for layer in layers for each in layer.state.obstacles]
    return RepairPlanMsg(
        header=Header(stamp=ns_to_stamp(plan.stamp_ns), frame_id=frame_id),
        print_id=plan.print_id, laying=plan.laying,
        layer_number=[each.number for each in layers],
        layer_finished=[each.finished for each in layers],
        layer_next=array('B', [each.state.next_layer for each in layers]),
        **{f'layer_{name}': [getattr(each.state, name) for each in layers] for name in STATE},
        obstacle_layer=[layer for layer, _ in obstacles],
        obstacle=array('B', [each for _, each in obstacles]),
        **_stretches('fill', fills), fill_speed=[each.speed for each in fills],
        fill_volume=[each.volume for each in fills],
        fill_points=[len(each.points) for each in fills],
        point_arc_length=_joined([each.arc_length for each in fills]),
        **axes_fields('point_', np.concatenate([np.empty((0, 3)),
                                                *(each.points for each in fills)])),
        point_area=_joined([each.area for each in fills]),
        point_flow=_joined([each.flow for each in fills]),
        **_stretches('unfilled', unfilled),
        unfilled_reason=array('B', [each.reason for each in unfilled]),
        **axes_fields('unfilled_', np.array([each.middle for each in unfilled]).reshape(-1, 3)))


def repair_from_message(message: RepairPlanMsg) -> RepairPlan:
    """Convert a plan from its message. Raises ConversionError for impossible values."""
    for names in LAYER, ('obstacle_layer', 'obstacle'), FILL, POINT, UNFILLED:
        check_lengths('repair_plan', message, names)
    count = sum(message.fill_points)
    if count != len(message.point_x):
        raise ConversionError(f'repair_plan: expected {count} points of its strokes, found '
                              f'{len(message.point_x)}; look at what publishes it')
    try:
        fills, unfilled = _fills(message), _unfilled(message)
        obstacles = [(layer, Obstacle(each)) for layer, each in zip(
            message.obstacle_layer, message.obstacle, strict=True)]
        layers = tuple(
            LayerRepair(number, bool(finished), LayerState(
                NextLayer(answer), tuple(each for layer, each in obstacles if layer == number),
                *state), tuple(each for each in fills if each.layer == number),
                tuple(each for each in unfilled if each.layer == number))
            for number, finished, answer, *state in _rows(message, LAYER))
    except ValueError as error:  # of an enumeration
        raise ConversionError(f'repair_plan: expected kinds and reasons that are known, found: '
                              f'{error}; is its sender of another version?') from None
    return RepairPlan(stamp_to_ns(message.header.stamp), message.print_id, bool(message.laying),
                      layers)


def _fills(message: RepairPlanMsg) -> list[Fill]:
    points, arc, area = (points_of(message, 'point_'), np.array(message.point_arc_length),
                         np.array(message.point_area))
    ends = np.cumsum(message.fill_points, dtype=np.intp).tolist()
    return [Fill(FillKind(kind), stroke, layer, start, end, arc[last - count:last],
                 points[last - count:last], area[last - count:last], speed)
            for (kind, stroke, layer, start, end, speed, count), last in zip(
                _rows(message, FILL), ends, strict=True)]


def _unfilled(message: RepairPlanMsg) -> list[Unfilled]:
    return [Unfilled(FillKind(kind), stroke, layer, start, end, (x, y, z), NotFilled(reason))
            for kind, stroke, layer, start, end, x, y, z, reason in _rows(message, UNFILLED)]


def _stretches(prefix: str, found: Sequence[Fill] | Sequence[Unfilled]) -> dict[str, Any]:
    columns: dict[str, Any] = {f'{prefix}_{name}': [getattr(each, name) for each in found]
                               for name in STRETCH[1:]}
    return {f'{prefix}_kind': array('B', [each.kind for each in found]), **columns}


def _joined(arrays: Sequence[Array]) -> array[float]:
    return floats_field(np.concatenate([np.empty(0), *arrays]))


def _rows(message: RepairPlanMsg, names: Sequence[str]) -> zip[tuple[Any, ...]]:
    return zip(*(list(getattr(message, name)) for name in names), strict=True)
