"""Convert what is known of a print beside its design from and to messages."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import astuple
from typing import Any

from geometry_msgs.msg import Point, Pose, Quaternion
import numpy as np
from scipy.spatial.transform import Rotation
from std_msgs.msg import Header

from bpc_interfaces.msg import DesignComparison as DesignComparisonMsg
from bpc_perception.core.arrays import Array
from bpc_perception.core.design.comparison import DesignFindings
from bpc_perception.core.design.deviation import Spread
from bpc_perception.core.design.layer_fidelity import LayerFidelity
from bpc_perception.core.design.presence import Missing, Presence
from bpc_perception.core.design.registration import Registration
from bpc_perception.messages.array_fields import axes_fields, check_lengths, floats_field
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp

SPREAD = 'samples', 'mean', 'rms', 'most', 'most_of_95'
LAYER = 'layer_number', 'layer_fidelity', 'layer_known', 'layer_designed'
MISSING = tuple(f'missing_{name}' for name in (
    'stroke', 'layer', 'presence', 'start', 'end', 'pieces', 'x', 'y', 'z'))


def design_to_message(found: DesignFindings, print_id: str, stamp_ns: int,
                      frame_id: str) -> DesignComparisonMsg:
    """Convert what a capture shows of a print in a frame to a message."""
    layers, missing, place = found.layers, found.missing, found.registration
    return DesignComparisonMsg(
        header=Header(stamp=ns_to_stamp(stamp_ns), frame_id=frame_id), print_id=print_id,
        file=found.name, refusal=place.refusal, pose=_pose_message(place.T_base_design),
        residual=place.residual, explained=place.explained, scale=place.scale,
        **{f'{what}_{name}': value for what, spread in (
            ('nozzle', found.nozzle), ('deposit', found.bead), ('width', found.width))
           for name, value in zip(SPREAD, astuple(spread), strict=True)},
        layer_number=[each.layer for each in layers],
        layer_fidelity=[each.fidelity for each in layers],
        layer_known=[each.known for each in layers],
        layer_designed=[each.designed for each in layers],
        **_spreads_fields('to_print', [each.to_print for each in layers]),
        **_spreads_fields('to_design', [each.to_design for each in layers]),
        missing_stroke=[each.stroke + 1 for each in missing],
        missing_layer=[each.layer for each in missing],
        missing_presence=array('B', [each.presence for each in missing]),
        missing_start=[each.start for each in missing],
        missing_end=[each.end for each in missing],
        missing_pieces=[each.count for each in missing],
        **axes_fields('missing_', np.array([each.middle for each in missing]).reshape(-1, 3)),
        surplus_start=floats_field(found.surplus[:, 0]),
        surplus_end=floats_field(found.surplus[:, 1]))


def no_design(stamp_ns: int, frame_id: str) -> DesignComparisonMsg:
    """Return the message that from this time on [ns] there is no print."""
    nothing = Spread.of(np.empty(0))
    place = Registration(np.full((4, 4), np.nan), refusal='no print')
    return design_to_message(DesignFindings(
        '', place, nothing, nothing, nothing, (), (), np.empty((0, 2))), '', stamp_ns, frame_id)


def design_from_message(message: DesignComparisonMsg) -> DesignFindings:
    """Convert a message. Raises ConversionError for impossible values."""
    spreads = [[f'{what}_{name}' for name in SPREAD] for what in ('to_print', 'to_design')]
    for names in ([*LAYER, *spreads[0], *spreads[1]], MISSING,
                  ['surplus_start', 'surplus_end']):
        check_lengths('design_comparison', message, names)
    try:
        missing = tuple(
            Missing(stroke - 1, layer, Presence(presence), start, end, count, (x, y, z))
            for stroke, layer, presence, start, end, count, x, y, z in _rows(message, MISSING))
    except ValueError as error:  # of an enumeration
        raise ConversionError(f'design_comparison: expected reasons that are known, found: {error}'
                              '; is its sender of another version?') from None
    to_print, to_design = ([Spread(*row) for row in _rows(message, names)] for names in spreads)
    nozzle, bead, width = (Spread(*(getattr(message, f'{what}_{name}') for name in SPREAD))
                           for what in ('nozzle', 'deposit', 'width'))
    return DesignFindings(
        message.file,
        Registration(_pose(message.pose, message.refusal), message.residual, message.explained,
                     message.scale, message.refusal),
        nozzle, bead, width,
        tuple(LayerFidelity(number, fidelity, known, designed, there, back)
              for (number, fidelity, known, designed), there, back in zip(
                  _rows(message, LAYER), to_print, to_design, strict=True)),
        missing, np.stack((message.surplus_start, message.surplus_end), axis=1))


def _spreads_fields(prefix: str, spreads: Sequence[Spread]) -> dict[str, list[Any]]:
    rows = [astuple(spread) for spread in spreads]
    return {f'{prefix}_{name}': [row[index] for row in rows] for index, name in enumerate(SPREAD)}


def _pose_message(T_base_design: Array) -> Pose:
    if np.isnan(T_base_design).any():
        nothing = float('nan')
        return Pose(position=Point(x=nothing, y=nothing, z=nothing))
    position = dict(zip('xyz', T_base_design[:3, 3].tolist(), strict=True))
    turn = Rotation.from_matrix(T_base_design[:3, :3]).as_quat().tolist()
    return Pose(position=Point(**position),
                orientation=Quaternion(**dict(zip('xyzw', turn, strict=True))))


def _pose(pose: Pose, refusal: str) -> Array:
    if refusal:
        return np.full((4, 4), np.nan)
    turn = [getattr(pose.orientation, axis) for axis in 'xyzw']
    if not np.isfinite(turn).all() or not any(turn):
        raise ConversionError(f'design_comparison: expected a turn as quaternion, found {turn}'
                              '; is its sender bpc?')
    T_base_design = np.eye(4)
    T_base_design[:3, :3] = Rotation.from_quat(turn).as_matrix()
    T_base_design[:3, 3] = [getattr(pose.position, axis) for axis in 'xyz']
    return T_base_design


def _rows(message: DesignComparisonMsg, names: Sequence[str]) -> zip[tuple[Any, ...]]:
    return zip(*(list(getattr(message, name)) for name in names), strict=True)
