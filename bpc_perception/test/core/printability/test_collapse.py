"""Strands that span supports and sag as a parabola does."""

from __future__ import annotations

import numpy as np
from printed_shapes import lattice, MM, printed
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.printability.collapse import (
    collapse_factor,
    collapse_metrics,
    find_spans,
)
from bpc_perception.core.printability.flat_print import lay_flat
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.profile import Status, ThicknessProfile

SUPPORT = 0.4  # [mm]


def test_a_parabola_by_formula() -> None:
    along = np.linspace(0, 3e-3, 301)
    part = along / 3e-3
    sag = 4 * 0.1e-3 * part * (1 - part)
    # Two thirds of the middle's 0.1 mm, of 0.4 mm.
    assert collapse_factor(sag, along, 0.4e-3) == pytest.approx(100 * 2 / 3 / 4, rel=1e-3)
    assert collapse_factor(np.zeros(301), along, 0.4e-3) == 0
    assert collapse_factor(np.full(301, 0.4e-3), along, 0.4e-3) == pytest.approx(100)


def tops_of(sag: float) -> Array:
    """Points (M, 3) of a lattice of 4 mm whose upper strands lie flat on the lower and sag."""
    x, y = np.meshgrid(np.arange(-2, 10, 0.05), np.arange(-2, 10, 0.05), indexing='ij')
    part = ((y % 4) - 0.5) / 3  # of the way between supports of 1 mm
    hanging = np.where((part > 0) & (part < 1), 4 * sag * part * (1 - part), 0.0)
    over = (np.abs((x + 2) % 4 - 2) < 0.5)
    z = np.where(over, 2 * SUPPORT - hanging, 0.0)
    return np.stack((x, y, z), axis=-1).reshape(-1, 3) * MM


def collapses(profile: ThicknessProfile, cloud: Array | None) -> list[Metric]:
    flat = lay_flat(profile)
    return collapse_metrics(flat, profile.height[flat.index], cloud)


@pytest.mark.parametrize('sag', [0.0, 0.1, 0.3])
def test_a_sagging_lattice(sag: float) -> None:
    found = collapses(printed(lattice(height=0.4)), tops_of(sag))
    assert len(found) == 6  # three strands over two pores each
    for metric in found:
        assert metric.value == pytest.approx(100 * 2 / 3 * sag / SUPPORT, rel=0.04, abs=1)
        assert metric.samples > 25


def test_spans_lie_between_supports() -> None:
    flat = lay_flat(printed(lattice()))
    spans = find_spans(flat, flat.layer == 1)
    assert [span.stroke for span in spans] == [4, 4, 5, 5, 6, 6]
    y = flat.points[spans[0].free][:, 1]
    assert np.ptp(y) == pytest.approx(3 * MM, abs=0.2 * MM)


def test_a_result_without_a_cloud_does_not_tell_it() -> None:
    metric, = collapses(printed(lattice()), None)
    assert np.isnan(metric.value)
    assert 'recording' in metric.note


def test_a_single_layer_spans_nothing() -> None:
    metric, = collapses(printed(lattice()[:3]), tops_of(0))
    assert metric.note == 'no strand lies on others'


def test_what_the_cloud_does_not_show_is_not_told() -> None:
    cloud = tops_of(0.1)
    metrics = collapses(printed(lattice()), cloud[cloud[:, 1] < 4 * MM])
    assert [np.isfinite(metric.value) for metric in metrics] == [True, False] * 3
    assert 'does not show' in metrics[1].note


def test_a_gap_is_no_sag() -> None:
    lines = lattice(statuses={(2.0, 4.0): Status.GAP})
    metrics = collapses(printed(lines), tops_of(0.1))
    assert [np.isfinite(metric.value) for metric in metrics] == [False, True] * 3
    assert 'gaps' in metrics[0].note


def test_supports_without_a_height_do_not_tell_it() -> None:
    metrics = collapses(printed(lattice(height=np.nan)), tops_of(0.1))
    assert all(np.isfinite(metric.value) for metric in metrics)  # that of the upper is not needed
    profile = printed(lattice())
    flat = lay_flat(profile)
    metrics = collapse_metrics(flat, np.full(len(flat.stroke), np.nan), tops_of(0.1))
    assert all('height of the strands below' in metric.note for metric in metrics)
