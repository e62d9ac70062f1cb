"""All numbers of a print together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from printed_shapes import lattice, Line, MM, printed
import pytest

from bpc_perception.core.printability.assess import assess, Conditions
from bpc_perception.core.printability.metric import Metric
from bpc_perception.core.profile import Status, ThicknessProfile


def of_print(profile: ThicknessProfile, conditions: Conditions) -> dict[str, Metric]:
    return {metric.name: metric for metric in assess(profile, conditions).metrics
            if metric.of == 'print'}


def wanted(profile: ThicknessProfile, width: float = 1.0) -> Conditions:
    return Conditions(target=np.full(len(profile), width * MM))


def test_means_over_pores() -> None:
    profile = printed(lattice(width=1.2))
    found = of_print(profile, wanted(profile))
    assert found['pore_area'].value == pytest.approx(2.8**2 * MM**2, rel=1e-3)
    assert found['pore_printability'].value == pytest.approx(1, abs=1e-3)
    assert found['mesh_printability'].value == pytest.approx(100 * 2.8**2 / 9, abs=0.2)
    assert found['pore_size_accuracy'].value == pytest.approx(100 * 2.8 / 3, abs=0.1)
    assert found['pore_area'].spread < 1e-3 * MM**2
    assert [found[name].samples for name in ('pore_area', 'mesh_printability')] == [4, 4]


def test_without_a_target_strands_are_meant_to_be_as_wide_as_the_nozzle() -> None:
    found = of_print(printed(lattice()), Conditions(nozzle=0.8 * MM))
    assert found['mesh_printability'].value == pytest.approx(100 * 9 / 3.2**2, abs=0.1)
    assert found['filament_to_nozzle_ratio'].value == pytest.approx(1.25)
    assert found['width_accuracy'].note == 'no target is set'


def test_without_both_nothing_is_compared() -> None:
    found = of_print(printed(lattice()), Conditions())
    for name in ('mesh_printability', 'pore_size_accuracy'):
        assert np.isnan(found[name].value)
        assert found[name].note == 'neither a target nor the inner diameter of the nozzle is known'
    assert np.isfinite(found['pore_printability'].value)


def test_pores_that_joined_are_not_in_the_means() -> None:
    lines = lattice()
    lines[1] = replace(lines[1], statuses={(1.2, 4.8): Status.GAP})
    profile = printed(lines)
    area = of_print(profile, wanted(profile))['pore_area']
    assert area.value == pytest.approx(9 * MM**2, rel=1e-3)
    assert (area.samples, area.note) == (2, '1 more joined with others')


def test_a_closed_pore_counts_as_nothing_that_is_left() -> None:
    profile = printed(lattice(pitch_x=2, pitch_y=2, width=2.1))
    found = of_print(profile, wanted(profile))
    assert found['mesh_printability'].value == 0
    assert np.isnan(found['pore_printability'].value)


@pytest.mark.parametrize(('lines', 'reason'), [
    ([Line([(0, 0), (20, 0)])], 'the strands enclose none'),
    ([Line([(0, 0), (20, 0)], statuses={(0, 20): Status.NO_DATA})], 'no width is measured')])
def test_a_print_without_pores(lines: list[Line], reason: str) -> None:
    found = of_print(printed(lines), Conditions())
    assert found['pore_area'].note == reason
    assert all(np.isfinite(metric.value) or metric.note for metric in found.values())


def test_a_bed_that_is_not_flat() -> None:
    profile = printed(lattice(count=4))
    x = profile.points[:, 0]
    bent = np.outer(8 * (x - x.mean()) ** 2 / 2 / 0.02, (0, 0, 1))
    found = of_print(replace(profile, points=profile.points + bent), Conditions())
    assert 'the bed is not flat' in found['pore_area'].note


def test_the_same_print_from_below() -> None:
    """Left is left wherever the base frame's z axis points, if the side points tell it."""
    profile = printed([Line([(0, 0), (10, 0)], left=0.6, right=0.4), Line([(0, 3), (10, 3)])])
    side = np.array((0.0, 1.0, 0.0))
    profile = replace(profile, left_points=profile.points + profile.left[:, None] * side,
                      right_points=profile.points - profile.right[:, None] * side)
    flipped = np.array((1.0, -1.0, -1.0))
    below = replace(profile, **{name: getattr(profile, name) * flipped for name in (
        'points', 'left_points', 'right_points')})
    for print_ in (profile, below):
        flat = assess(print_, Conditions()).flat
        left, _ = flat.sides()
        np.testing.assert_allclose(flat.in_base(left), print_.left_points, atol=1e-9)
