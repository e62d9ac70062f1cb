"""Convert verdicts on prints from and to messages."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np
from std_msgs.msg import Header

from bpc_interfaces.msg import PrintVerdict as PrintVerdictMsg
from bpc_perception.core.inspection.defects import Defect, DefectKind
from bpc_perception.core.inspection.verdict import PartVerdict, PrintVerdict, Verdict
from bpc_perception.messages.array_fields import axes_fields, check_lengths
from bpc_perception.messages.stamps import ConversionError, ns_to_stamp, stamp_to_ns

STROKE = 'stroke_number', 'stroke_layer', 'stroke_verdict', 'stroke_seen'
LAYER = 'layer_number', 'layer_verdict', 'layer_seen'
AXES = 'x', 'y', 'z'
DEFECT = ('kind', 'stroke', 'layer', 'start', 'end', 'worst', 'limit', 'samples')


def verdict_to_message(verdict: PrintVerdict, frame_id: str) -> PrintVerdictMsg:
    """Convert a verdict in a frame to a message."""
    strokes, layers = verdict.strokes, verdict.layers
    places = np.array([each.middle for each in verdict.defects]).reshape(-1, 3)
    return PrintVerdictMsg(
        header=Header(stamp=ns_to_stamp(verdict.stamp_ns), frame_id=frame_id),
        print_id=verdict.print_id, ended=verdict.ended, verdict=int(verdict.verdict),
        enough=verdict.enough, laying=verdict.laying,
        judged=array('B', sorted(verdict.judged)),
        stroke_number=[each.number for each in strokes],
        stroke_layer=[each.layer for each in strokes],
        stroke_verdict=array('B', [each.verdict for each in strokes]),
        stroke_seen=[each.seen for each in strokes],
        layer_number=[each.number for each in layers],
        layer_verdict=array('B', [each.verdict for each in layers]),
        layer_seen=[each.seen for each in layers],
        defect_kind=array('B', [each.kind for each in verdict.defects]),
        **axes_fields('defect_', places),
        **{f'defect_{name}': [getattr(each, name) for each in verdict.defects]
           for name in DEFECT[1:]})


def verdict_from_message(message: PrintVerdictMsg) -> PrintVerdict:
    """Convert a verdict from its message. Raises ConversionError for impossible values."""
    for names in STROKE, LAYER, [f'defect_{name}' for name in (*DEFECT, *AXES)]:
        check_lengths('print_verdict', message, names)
    try:
        return PrintVerdict(
            stamp_ns=stamp_to_ns(message.header.stamp), print_id=message.print_id,
            ended=bool(message.ended), verdict=Verdict(message.verdict),
            enough=message.enough, laying=bool(message.laying),
            judged=frozenset(map(DefectKind, message.judged)),
            strokes=tuple(PartVerdict(number, layer, Verdict(verdict), seen)
                          for number, layer, verdict, seen in _rows(message, STROKE)),
            layers=tuple(PartVerdict(number, number, Verdict(verdict), seen)
                         for number, verdict, seen in _rows(message, LAYER)),
            defects=tuple(_defect(*row) for row in _rows(
                message, [f'defect_{name}' for name in (*DEFECT, *AXES)])))
    except ValueError as error:  # of an enumeration
        raise ConversionError(f'print_verdict: expected verdicts and defects that are known, '
                              f'found: {error}; is its sender of another version?') from None


def _defect(kind: int, stroke: int, layer: int, start: float, end: float, worst: float,
            limit: float, samples: int, *middle: Any) -> Defect:
    x, y, z = middle
    return Defect(DefectKind(kind), stroke, layer, start, end, worst, limit, samples, (x, y, z))


def _rows(message: PrintVerdictMsg, names: Any) -> zip[tuple[Any, ...]]:
    return zip(*(list(getattr(message, name)) for name in names), strict=True)
