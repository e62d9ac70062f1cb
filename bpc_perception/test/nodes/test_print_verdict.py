"""The verdict on a print, published with each profile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from node_builders import BASE, BEAD_WIDTH_M, STAMP_NS, thickness_bench
from perception_builders import pixel_path, SECOND
import pytest
from rclpy.parameter import Parameter

from bpc_interfaces.msg import PrintVerdict as PrintVerdictMsg
from bpc_perception.core.inspection.defects import DefectKind
from bpc_perception.core.inspection.verdict import Verdict
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.results.verdict import verdict_from_message

pytestmark = pytest.mark.ros


def test_it_fails_at_once_and_passes_at_the_end(graph: Any, tmp_path: Path) -> None:
    bench = thickness_bench(graph, tmp_path, advice__target_thickness=BEAD_WIDTH_M)
    heard = bench.listen(topics.VERDICT, PrintVerdictMsg, topics.RESULT_QOS)

    def next_verdict(finished: bool) -> Any:
        path = path_to_message(pixel_path((40, 55), (120, 55), 81, finished=finished), BASE)
        bench.send(topics.PATH, path)
        bench.until(lambda: bench.node._session._path is not None
                    and bench.node._session._path.finished == finished)
        count = len(heard)
        bench.send_capture(STAMP_NS + count * SECOND)
        bench.until(lambda: len(heard) > count)
        return verdict_from_message(heard[-1])

    going_on = next_verdict(finished=False)
    assert (going_on.verdict, going_on.ended) == (Verdict.NOT_ENOUGH_SEEN, False)
    assert DefectKind.THIN in going_on.judged
    bench.node.set_parameters([Parameter('advice.target_thickness', value=1.5 * BEAD_WIDTH_M)])
    thin = next_verdict(finished=False)
    assert thin.verdict == Verdict.FAIL
    assert {each.kind for each in thin.defects} == {DefectKind.THIN}
    bench.node.set_parameters([Parameter('tolerance.width', value=0.5)])
    ended = next_verdict(finished=True)
    assert (ended.verdict, ended.ended, ended.defects) == (Verdict.PASS, True, ())
    assert [each.stroke for each in thin.defects] == [1] * len(thin.defects)
    bench.node._clear()
    bench.until(lambda: not heard[-1].print_id)
