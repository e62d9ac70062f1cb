"""Numbers of strands whose edges are known from geometry."""

from __future__ import annotations

import numpy as np
from printed_shapes import Line, MM, printed
import pytest
from scipy.integrate import quad

from bpc_perception.core.printability.flat_print import lay_flat
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.printability.strands import strand_metrics
from bpc_perception.core.profile import Status


def numbers(line: Line, nozzle: float = np.nan, target: float | None = None,
            sigma: float = 0.01) -> dict[str, Metric]:
    """Metrics of a stroke by name; nozzle and target in mm."""
    flat = lay_flat(printed([line], sigma))
    wanted = None if target is None else np.full(len(flat.stroke), target * MM)
    found = strand_metrics(flat, flat.stroke == 1, 'stroke 1', nozzle * MM, wanted)
    return {metric.name: metric for metric in found}


STRAIGHT = [(0.0, 0.0), (40.0, 0.0)]


def test_a_perfect_strand() -> None:
    found = numbers(Line(STRAIGHT), nozzle=0.8, target=1.25)
    assert found['width'].value == pytest.approx(1 * MM)
    assert found['filament_to_nozzle_ratio'].value == pytest.approx(1.25)
    assert found['width_accuracy'].value == pytest.approx(80)
    assert found['stability'].value == pytest.approx(1)
    assert found['uniformity'].value == pytest.approx(1)
    assert found['continuity'].value == 1
    assert found['width'].samples == 401
    # Between what is alike all along and what is independent.
    assert 0.005 * MM < found['width'].sigma < 0.01 * MM
    assert found['filament_to_nozzle_ratio'].sigma == pytest.approx(found['width'].sigma / 0.8e-3)


def test_what_is_not_given_is_not_told() -> None:
    found = numbers(Line(STRAIGHT))
    assert np.isnan(found['filament_to_nozzle_ratio'].value)
    assert 'nozzle is not given' in found['filament_to_nozzle_ratio'].note
    assert found['width_accuracy'].note == 'no target is set'


@pytest.mark.parametrize(('amplitude', 'wave'), [(0.1, 4.0), (0.2, 4.0), (0.2, 2.0)])
def test_sinusoidal_edges(amplitude: float, wave: float) -> None:
    def edge(s: np.ndarray) -> np.ndarray:
        return 0.6 + amplitude * np.sin(2 * np.pi * s / wave)

    found = numbers(Line(STRAIGHT, edge, edge))
    steep = 2 * np.pi * amplitude / wave
    longer = quad(lambda x: np.sqrt(1 + (steep * np.cos(x)) ** 2), 0, 2 * np.pi)[0] / (2 * np.pi)
    assert found['uniformity'].value == pytest.approx(longer, abs=2e-3)
    # The width goes to and fro by twice the amplitude, about 1.2 mm.
    assert found['stability'].value == pytest.approx(
        1 - 2 * amplitude / np.sqrt(2) / 1.2, abs=2e-3)


def test_a_bend_of_the_path_is_not_uneven() -> None:
    angle = np.linspace(0, np.pi, 400)
    arc = list(zip(5 * np.cos(angle), 5 * np.sin(angle), strict=True))
    assert numbers(Line(arc))['uniformity'].value == pytest.approx(1, abs=1e-6)


def test_gaps_for_continuity() -> None:
    # Half a sample more on either side has no ink.
    found = numbers(Line(STRAIGHT, statuses={(10.0, 14.0): Status.GAP}))['continuity']
    assert found.value == pytest.approx(1 - 4.1 / 40, abs=1e-3)
    assert abs(found.value - 0.9) < 3 * found.sigma
    assert found.note == ''


def test_what_is_not_seen_widens_continuity() -> None:
    found = numbers(Line(STRAIGHT, statuses={
        (10.0, 14.0): Status.GAP, (20.0, 25.0): Status.OCCLUDED}))['continuity']
    assert found.value == pytest.approx((34.8 - 4.1) / 34.8, abs=2e-3)
    assert found.sigma > 5 / 40 / np.sqrt(12)
    assert found.note == '12.7% of the length are not seen'


def test_too_little_that_is_seen_tells_nothing() -> None:
    found = numbers(Line(STRAIGHT, statuses={(10.0, 35.0): Status.NO_DATA}))
    assert all(np.isnan(metric.value) and metric.note for metric in found.values())
    assert found['continuity'].note == 'less than half of the length is seen'
    assert '37% of the ink are measured' in found['width'].note


def test_a_stroke_without_ink() -> None:
    found = numbers(Line(STRAIGHT, statuses={(0.0, 40.0): Status.GAP}))
    assert found['continuity'].value == 0
    assert found['width'].note == 'no ink is seen'


def test_a_number_needs_a_reason_if_it_is_not_known() -> None:
    with pytest.raises(ValueError, match='expected a number or a reason'):
        Metric('width', 'print', np.nan, np.nan, 0)
    with pytest.raises(ValueError, match='expected one with a definition'):
        Metric('beauty', 'print', 1.0, 0.0, 1)
