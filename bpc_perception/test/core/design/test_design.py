"""Designs, their checks and their pieces."""

from __future__ import annotations

from design_builders import lattice, MM, stroke_of
import numpy as np
from perception_builders import pose
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.design import Design, DesignError, DesignStroke
from bpc_perception.core.design.pieces import Pieces

TWO = np.array(((0.0, 0, 0), (MM, 0, 0)))


@pytest.mark.parametrize(('points', 'widths', 'layer', 'message'), [
    (TWO[:1], np.empty(0), 0, 'expected two points of three coordinates or more'),
    (TWO[:, :2], np.ones(1), 0, 'expected two points of three coordinates or more'),
    (TWO, np.ones(2), 0, 'expected a width for each piece'),
    (TWO * np.nan, np.full(1, MM), 0, 'expected coordinates within 10 m'),
    (TWO * 1e5, np.full(1, MM), 0, 'expected coordinates within 10 m'),
    (TWO * 0, np.full(1, MM), 0, 'expected points that differ'),
    (TWO, np.zeros(1), 0, 'expected widths from 0.02 to 100 mm'),
    (TWO, np.full(1, MM), -1, 'expected numbers of layer, tool and line from 0')])
def test_what_is_no_stroke_is_refused(points: Array, widths: Array, layer: int,
                                      message: str) -> None:
    with pytest.raises(DesignError, match=f'line 7: {message}.*; correct the design'):
        DesignStroke(points, widths, layer, line=7)


def test_a_design_has_a_stroke() -> None:
    with pytest.raises(DesignError, match='expected a design with strokes, found none; lay ink'):
        Design(())


def test_lengths_and_layers_add_up() -> None:
    design = lattice(lines=5, size=20, layers=2)
    assert design.layers == 2
    assert design.length == pytest.approx(2 * 10 * 20 * MM)
    moved = design.moved_by(pose((1, 2, 3), (90, 0, 0)))
    np.testing.assert_allclose(moved.strokes[0].points[1], (1, 2 + 20 * MM, 3 + 0.2 * MM))


def test_pieces_are_as_long_as_the_design_and_in_its_order() -> None:
    design = Design((stroke_of(((0, 0, 0), (1, 0, 0), (1, 0.5, 0)), width=0.4),
                     stroke_of(((5, 0, 0), (5, 0, 1)), layer=2)))
    pieces = Pieces.of(design)
    assert len(pieces) == 5 + 3 + 5
    assert 2 * pieces.half.sum() == pytest.approx(2.5 * MM)
    assert pieces.stroke.tolist() == [0] * 8 + [1] * 5
    assert pieces.layer.tolist() == [0] * 8 + [2] * 5
    assert np.flatnonzero(pieces.opens).tolist() == [0, 8]
    assert np.flatnonzero(pieces.closes).tolist() == [7, 12]
    assert pieces.arc_length[7] == pytest.approx(1.5 * MM - 0.5 * MM / 6)
    assert pieces.ink[8] == pytest.approx(1.6 * MM)
    assert pieces.width[0] == pytest.approx(0.4 * MM)
    assert np.isnan(pieces.width[-1])


def test_where_strokes_cross_the_one_that_runs_the_same_way_is_meant() -> None:
    pieces = Pieces.of(Design((stroke_of(((-5, 0, 0), (5, 0, 0))),
                               stroke_of(((0, -5, 0), (0, 5, 0))))))
    near = pieces.nearest(np.array(((0.1, 0.2, 0), (0.1, 0.2, 0), (np.nan, 0, 0))) * MM,
                          np.array(((1.0, 0, 0), (0, 1, 0), (1, 0, 0))))
    assert pieces.stroke[near[:2]].tolist() == [0, 1]
    assert near[2] == -1
    offset, _ = pieces.offsets(np.array(((0.1, 0.2, 0), (0.1, 0.2, 0))) * MM, near[:2])
    np.testing.assert_allclose(offset / MM, ((0, 0.2, 0), (0.1, 0, 0)), atol=1e-9)
