"""Designs in the G-code of slicers and bioprinters; each sample says what it is written after."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.design.design import Design, DesignError, DesignStroke
from bpc_perception.files.design.read import read_design

SAMPLES = Path(__file__).parent / 'samples'
MM = 1e-3


def sample(name: str, **keywords: tuple[str, ...]) -> Design:
    return read_design(SAMPLES / name, **keywords)


def through(stroke: DesignStroke, *points: tuple[float, ...]) -> None:
    """Expect a stroke through points [mm]."""
    np.testing.assert_allclose(stroke.points / MM, points, atol=1e-9)


def test_prusa_slicer() -> None:
    design = sample('prusa.gcode')
    intro, first, second = design.strokes
    through(intro, (60, -3, 0.2), (100, -3, 0.2))
    through(first, (10, 10, 0.2), (20, 10, 0.2), (20, 20, 0.2), (10, 20, 0.2))
    through(second, (11, 11, 0.4), (19, 19, 0.4))
    assert np.isnan(intro.widths).all()
    assert first.widths == pytest.approx((0.42 * MM, 0.42 * MM, 0.45 * MM))
    assert second.widths == pytest.approx((0.4 * MM,))
    assert [stroke.layer for stroke in design.strokes] == [0, 0, 1]
    assert [stroke.line for stroke in design.strokes] == [15, 30, 46]
    assert design.notes == ('line 14: ink is left out up to where x is told',)
    assert design.layers == 2
    assert design.length == pytest.approx((40 + 30 + 8 * 2**0.5) * MM)


def test_cura() -> None:
    wall, fill, skin = sample('cura.gcode').strokes
    through(wall, (15, -38, 1.3), (38, -15, 1.3), (38, 15, 1.3))
    through(fill, (10, 0, 1.3), (-10, 0, 1.3))
    through(skin, (-10, 0, 2.3), (10, 0, 2.3))
    assert wall.widths == pytest.approx((0.7 * MM,) * 2)
    assert fill.widths == pytest.approx((0.8 * MM,))  # as line_width
    assert skin.widths == pytest.approx((0.8 * MM,))
    assert [stroke.layer for stroke in (wall, fill, skin)] == [0, 0, 1]


def test_slic3r_tells_how_e_makes_a_width() -> None:
    first, second, third = sample('slic3r.gcode').strokes
    # 0.62848 mm of 1.75 mm are 1.51168 mm^3: 10 mm of 0.35 (w - 0.35 (1 - pi / 4)) mm^2.
    assert first.widths == pytest.approx((0.507 * MM,), abs=1e-6)
    assert second.widths == pytest.approx(np.full(len(second.widths), 0.5 * MM), rel=2e-3)
    assert len(second.widths) > 10  # with chords of an arc
    assert np.isnan(third.widths).all()


def test_a_syringe_on_marlin() -> None:
    one, two, three = sample('syringe.gcode').strokes
    through(one, (10, 10, 0.25), (45, 10, 0.25))
    through(two, (55, 10, 0.25), (90, 10, 0.25))
    through(three, (10, 15, 0.5), (45, 15, 0.5))
    assert [stroke.layer for stroke in (one, two, three)] == [0, 0, 1]
    assert [stroke.tool for stroke in (one, two, three)] == [0, 0, 1]
    assert np.isnan(one.widths).all()


def test_an_inkredible_has_valves() -> None:
    one, two = sample('inkredible.gcode').strokes
    through(one, (0, 0, 0.2), (10, 0, 0.2), (10, 10, 0.2))
    through(two, (0, 10, 0.2), (0, 0, 0.2))
    assert (one.tool, two.tool) == (0, 1)


def test_a_bio_x_opens_its_valve_by_e_or_m750() -> None:
    one, two = sample('bio_x.gcode').strokes
    through(one, (-10, 10, 0.4), (-10, -10, 0.4))
    through(two, (0, -10, 0.4), (0, 10, 0.4), (5, 10, 0.4))
    assert (one.tool, two.tool) == (1, 1)


def test_pressure_by_a_pin_has_to_be_named() -> None:
    with pytest.raises(DesignError, match=r'pressure\.gcode: expected moves with E.*found M42, '
                                          'which have other uses too; name the commands'):
        sample('pressure.gcode')
    one, two = sample('pressure.gcode', ink_on=('M42 P32 S255',),
                      ink_off=('M42 P32 S0',)).strokes
    through(one, (28, 102, 2.2), (29, 102, 2.2), (29, 103, 2.2))
    through(two, (46, 120, 2.2), (40, 120, 2.2))


def test_arcs_in_inches_with_line_numbers_as_on_a_cnc_machine() -> None:
    half, turn, semicircle, long_way = sample('arcs.nc').strokes
    assert np.hypot(*half.points.T[:2]) == pytest.approx(25.4 * MM, abs=1e-8)
    assert half.points[-1] / MM == pytest.approx((-25.4, 0, 2.54))
    assert half.length == pytest.approx(np.pi * 25.4 * MM, rel=1e-3)
    middle = turn.points[len(turn.points) // 2] / MM
    assert middle[0] == pytest.approx(0, abs=0.1)
    assert middle[2] == pytest.approx((2.54 + 5.08) / 2, abs=0.05)
    assert turn.points[1, 1] < 0  # clockwise, seen from above
    assert turn.length == pytest.approx(np.hypot(10 * np.pi, 2.54) * MM, rel=1e-3)
    assert semicircle.points[:, 1].max() == pytest.approx(5 * MM, abs=0.01 * MM)
    assert long_way.points[:, 0].min() == pytest.approx(-(3 + (9 - 6.25)**0.5) * MM,
                                                        abs=0.01 * MM)
    assert [stroke.line for stroke in (half, turn)] == [6, 10]
