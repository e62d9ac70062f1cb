"""Verdicts from and to messages, and which messages are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bpc_interfaces.msg import PrintVerdict as PrintVerdictMsg
from bpc_perception.core.inspection.defects import Defect, DefectKind
from bpc_perception.core.inspection.verdict import PartVerdict, PrintVerdict, Verdict
from bpc_perception.messages.results.verdict import verdict_from_message, verdict_to_message
from bpc_perception.messages.stamps import ConversionError

pytestmark = pytest.mark.ros
VERDICT = PrintVerdict(
    5, 'print', True, False, Verdict.FAIL,
    (PartVerdict(1, 0, Verdict.FAIL, 0.9), PartVerdict(2, 1, Verdict.PASS, 1.0)),
    (PartVerdict(0, 0, Verdict.FAIL, 0.9), PartVerdict(1, 1, Verdict.PASS, 1.0)),
    (Defect(DefectKind.THIN, 1, 0, 2e-3, 6e-3, 1.5e-3, 1.7e-3, 5, (4e-3, 0.0, 0.0)),
     Defect(DefectKind.OOZE, 0, 1, 8e-3, 12e-3, 4e-3, 2e-3, 20, (10e-3, 0.0, 0.0))),
    frozenset((DefectKind.THIN, DefectKind.OOZE)), 0.8)


@pytest.mark.parametrize('verdict', [VERDICT, PrintVerdict.none(5)], ids=['print', 'none'])
def test_a_verdict_survives_there_and_back(verdict: PrintVerdict) -> None:
    assert verdict_from_message(verdict_to_message(verdict, 'base')) == verdict


def test_a_message_tells_where_defects_are() -> None:
    message = verdict_to_message(VERDICT, 'base')
    assert message.header.frame_id == 'base'
    np.testing.assert_allclose(message.defect_x, (4e-3, 10e-3))
    np.testing.assert_allclose((message.defect_y, message.defect_z), 0.0)


@pytest.mark.parametrize(('field', 'value', 'found'), [
    ('verdict', 9, '9 is not a valid Verdict'), ('defect_kind', [0, 99], '99 is not a valid'),
    ('judged', [42], '42 is not a valid'), ('stroke_seen', [1.0], 'arrays of one length'),
    ('layer_verdict', [1], 'arrays of one length'),
    ('defect_limit', [], 'arrays of one length')])
def test_impossible_verdicts_are_refused(field: str, value: Any, found: str) -> None:
    message: PrintVerdictMsg = verdict_to_message(VERDICT, 'base')
    setattr(message, field, value)
    with pytest.raises(ConversionError, match=found):
        verdict_from_message(message)
