"""A print beside its design, published with each profile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from node_builders import BASE, BEAD_WIDTH_M, STAMP_NS, thickness_bench
import numpy as np
from perception_builders import pixel_path, SECOND
import pytest

from bpc_interfaces.msg import DesignComparison, PrintVerdict, RateAdvice
from bpc_perception.core.design.design import DesignError
from bpc_perception.core.design.presence import Presence
from bpc_perception.core.inspection.defects import DefectKind
from bpc_perception.core.inspection.verdict import Verdict
from bpc_perception.messages import topics
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.results.design import design_from_message
from bpc_perception.messages.results.verdict import verdict_from_message

pytestmark = pytest.mark.ros
ENDS = (40, 55), (120, 55)
BESIDE = np.array((0, 5, 0))  # [mm]


def written(folder: Path, width_mm: float) -> Path:
    """Write a design: the line that is printed, and one beside it that is to come."""
    start, end = pixel_path(*ENDS).points[[0, -1]] * 1e3
    file = folder / 'two_lines.csv'
    rows = [(*start, 1), (*end, 1), (*(end + BESIDE), 2), (*(start + BESIDE), 2)]
    file.write_text('\n'.join(['x_mm,y_mm,z_mm,stroke,width_mm', *(
        f'{x},{y},{z},{stroke},{width_mm}' for x, y, z, stroke in rows)]))
    return file


def test_each_capture_tells_how_far_the_print_is_from_its_design(graph: Any,
                                                                 tmp_path: Path) -> None:
    file = written(tmp_path, 1e3 * BEAD_WIDTH_M)
    bench = thickness_bench(graph, tmp_path, design__file=str(file), design__place='0,0,0,0')
    designs = bench.listen(topics.DESIGN, DesignComparison, topics.RESULT_QOS)
    verdicts = bench.listen(topics.VERDICT, PrintVerdict, topics.RESULT_QOS)
    advice = bench.listen(topics.ADVICE, RateAdvice, topics.RESULT_QOS)
    for finished in (False, True):
        count = len(designs)
        bench.send(topics.PATH, path_to_message(
            pixel_path(*ENDS, 81, finished=finished), BASE))
        bench.until(lambda finished=finished: bench.node._session._path is not None
                    and bench.node._session._path.finished == finished)
        bench.send_capture(STAMP_NS + count * SECOND)
        bench.until(lambda count=count: min(map(len, (designs, verdicts, advice))) > count)
    going_on, ended = map(design_from_message, designs)
    assert (designs[0].file, designs[0].print_id) == (str(file), verdicts[0].print_id)
    assert [(each.stroke, each.presence) for each in going_on.missing] == [
        (1, Presence.YET_TO_COME)]
    assert going_on.nozzle.most < 1e-5
    assert going_on.bead.most_of_95 < 0.2 * BEAD_WIDTH_M
    assert advice[0].target_thickness == pytest.approx(BEAD_WIDTH_M)
    first, last = map(verdict_from_message, verdicts)
    assert (first.verdict, last.verdict) == (Verdict.NOT_ENOUGH_SEEN, Verdict.FAIL)
    assert [(each.kind, each.stroke) for each in last.defects] == [(DefectKind.SKIPPED, 2)]
    np.testing.assert_allclose(last.defects[0].middle, pixel_path(*ENDS).points[[0, -1]].mean(
        axis=0) + 1e-3 * BESIDE, atol=3e-4)
    assert {each.presence for each in ended.missing} == {Presence.SKIPPED}
    bench.node._clear()
    bench.until(lambda: not designs[-1].print_id)


def test_the_widths_of_the_design_are_what_is_judged(graph: Any, tmp_path: Path) -> None:
    file = written(tmp_path, 1.5e3 * BEAD_WIDTH_M)
    bench = thickness_bench(graph, tmp_path, design__file=str(file), design__place='0,0,0,0')
    verdicts = bench.listen(topics.VERDICT, PrintVerdict, topics.RESULT_QOS)
    bench.send(topics.PATH, path_to_message(pixel_path(*ENDS, 81, finished=False), BASE))
    bench.send_capture(STAMP_NS)
    bench.until(lambda: verdicts)
    assert {each.kind for each in verdict_from_message(verdicts[0]).defects} == {DefectKind.THIN}


def test_a_design_that_cannot_be_read_is_said_at_the_start(graph: Any, tmp_path: Path) -> None:
    file = tmp_path / 'empty.gcode'
    file.write_text('G28\n')
    with pytest.raises(DesignError, match=r'empty\.gcode: expected moves with E'):
        thickness_bench(graph, tmp_path, design__file=str(file))
