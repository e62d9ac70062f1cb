"""Parallel strands whose distance and width are known."""

from __future__ import annotations

import numpy as np
from printed_shapes import Line, MM, printed
import pytest

from bpc_perception.core.printability.flat_print import lay_flat
from bpc_perception.core.printability.fusion import fusion_metrics
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.profile import Status


def fusion(lines: list[Line], wanted: float = np.nan) -> dict[tuple[str, str], Metric]:
    """Metrics by what they are about and their name."""
    profile = printed(lines)
    flat = lay_flat(profile)
    return {(metric.of, metric.name): metric for metric in fusion_metrics(
        flat, profile.status[flat.index] == Status.JUNCTION, wanted * MM)}


def line(y: float, **others: object) -> Line:
    return Line([(0, y), (20, y)], **others)  # type: ignore[arg-type]


def test_strands_apart_are_not_fused() -> None:
    found = fusion([line(0), line(1.5), line(4)])
    assert found['strands 1 and 2', 'strand_distance'].value == pytest.approx(1.5 * MM)
    assert found['strands 2 and 3', 'strand_distance'].value == pytest.approx(2.5 * MM)
    for pair in ('strands 1 and 2', 'strands 2 and 3'):
        assert found[pair, 'fused_length'].value == 0
        assert found[pair, 'fusion'].value == 0
        assert found[pair, 'fusion'].sigma > 0
    assert ('strands 1 and 3', 'fusion') not in found  # 4 widths apart


def test_a_strand_between_parts_its_neighbours() -> None:
    assert {of for of, _ in fusion([line(0), line(1.2), line(2.4)])} == {
        'strands 1 and 2', 'strands 2 and 3'}


def bulging(s: np.ndarray) -> np.ndarray:
    """6 mm along which the edge reaches 0.8 mm out."""
    return np.where(np.abs(s - 10) <= 3, 0.8, 0.5)


def test_what_touches_is_fused() -> None:
    found = fusion([line(0, left=bulging), line(1.2)])
    length = found['strands 1 and 2', 'fused_length']
    assert length.value == pytest.approx(6 * MM, abs=3 * length.sigma)
    width = (14 * 1 + 6 * 1.3) / 20 / 2 + 1 / 2  # the mean of both
    assert found['strands 1 and 2', 'fusion'].value == pytest.approx(6 / width, rel=0.03)
    # On the other side it does not touch.
    apart = fusion([line(0, right=bulging), line(1.2)])
    assert apart['strands 1 and 2', 'fused_length'].value == 0


def test_where_strands_touch_no_width_is_measured() -> None:
    statuses = {(4.0, 9.0): Status.JUNCTION}
    found = fusion([line(0, statuses=statuses), line(1.0, statuses=statuses)])
    length = found['strands 1 and 2', 'fused_length']
    # Strands that are 1 mm wide and apart touch all along.
    assert length.value == pytest.approx(20 * MM, rel=0.01)
    found = fusion([line(0, statuses=statuses), line(1.1, statuses=statuses)])
    assert found['strands 1 and 2', 'fused_length'].value == pytest.approx(5.1 * MM, abs=1e-6)


def test_strands_that_touch_all_along() -> None:
    """The closest ones of a test print: none has a width."""
    statuses = {(0.0, 20.0): Status.JUNCTION}
    lines = [line(0, statuses=statuses), line(0.9, statuses=statuses)]
    found = fusion(lines, wanted=1.0)
    assert found['strands 1 and 2', 'fused_length'].value == pytest.approx(20 * MM, rel=0.01)
    assert np.isnan(found['strands 1 and 2', 'fusion'].value)
    assert 'touch all along' in found['strands 1 and 2', 'fusion'].note
    assert fusion(lines)['print', 'fusion'].note == 'no width is measured'


def test_a_junction_far_from_the_neighbour_is_of_something_else() -> None:
    found = fusion([line(0, statuses={(4.0, 9.0): Status.JUNCTION}), line(2)])
    length = found['strands 1 and 2', 'fused_length']
    assert length.value == 0
    assert length.note == '5.1 mm are not seen'


def test_what_is_not_seen_is_not_told() -> None:
    found = fusion([line(0, statuses={(4.0, 16.0): Status.OCCLUDED}), line(2)])
    assert np.isnan(found['strands 1 and 2', 'fusion'].value)
    assert 'less than half' in found['strands 1 and 2', 'fusion'].note
    assert found['strands 1 and 2', 'strand_distance'].value == pytest.approx(2 * MM)


def test_the_legs_of_a_meander_are_strands() -> None:
    corners = [(0, 0), (20, 0), (20, 2), (0, 2), (0, 4.5), (20, 4.5)]
    found = fusion([Line(corners)])
    distances = {of: metric.value / MM for (of, name), metric in found.items()
                 if name == 'strand_distance'}
    # Two corners near each other are one turn; farther apart the way between is a strand.
    assert distances == pytest.approx({'strands 1 and 2': 2, 'strands 2 and 4': 2.5}, abs=0.01)


def test_a_turn_is_not_fused() -> None:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 60)
    bend = [(0.0, -1.0), *zip(20 + np.cos(angle), np.sin(angle), strict=True), (0.0, 1.0)]
    found = fusion([Line(bend)])
    assert found['strands 1 and 2', 'fused_length'].value == 0
    assert found['strands 1 and 2', 'strand_distance'].value == pytest.approx(2 * MM, rel=0.01)


def test_strands_that_cross_or_lie_in_other_layers_are_no_neighbours() -> None:
    across = Line([(10, -5), (10, 5)])
    above = Line([(0, 1.5), (20, 1.5)], layer=1)
    found = fusion([line(0), across, above])
    assert {of for of, _ in found} == {'print'}
    assert all(np.isnan(metric.value) and metric.note for metric in found.values())
