"""Commands of G-code, one by one."""

from __future__ import annotations

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from bpc_perception.core.design.design import Design, DesignError, DesignStroke
from bpc_perception.files.design.read import design_from_g_code

MM = 1e-3


def strokes(text: str) -> list[list[list[float]]]:
    """Points [mm] of the strokes of a design."""
    return [np.round(stroke.points / MM, 9).tolist()
            for stroke in design_from_g_code(text).strokes]


def test_spaces_case_and_brackets_do_not_count() -> None:
    want = [[[0, 0, 0.5], [10, 5, 0.5]]]
    assert strokes('M83\nG0X0Y0Z.5\nG1X10Y5E.3') == want
    assert strokes('m83\ng00 x 0 y0(here)z.5\n g01 x10.y+5 e.3 ; there\n') == want
    assert strokes('M83\r\nG0 X0 Y0 Z.5\r\nN3 G1 X10 Y5 E.3\r\n') == want


def test_absolute_e_lays_ink_where_it_rises() -> None:
    text = 'M82\nG0 X0 Y0 Z0\nG1 X1 E1\nG1 X2 E1\nG1 X3 E2\nG92 E0\nG1 X4 E1\nG1 X5 E0\n'
    assert strokes(text) == [[[0, 0, 0], [1, 0, 0]], [[2, 0, 0], [3, 0, 0], [4, 0, 0]]]


def test_moves_may_be_relative() -> None:
    assert strokes('M83\nG0 X5 Y5 Z1\nG91\nM83\nG1 X1 E1\nG1 Y2 E1\nG90\nM83\nG1 X0 E1') == [
        [[5, 5, 1], [6, 5, 1], [6, 7, 1], [0, 7, 1]]]


def test_a_file_of_relative_moves_has_its_origin_where_it_begins() -> None:
    assert strokes('G91\nM83\nG1 X1\nG1 Y2 E1\n') == [[[1, 0, 0], [1, 2, 0]]]


def test_g92_names_the_place_and_nothing_moves() -> None:
    assert strokes('M83\nG0 X5 Y5 Z1\nG92 X0 Y0\nG1 X1 E1\nG1 Y1 E1') == [
        [[5, 5, 1], [6, 5, 1], [6, 6, 1]]]
    assert strokes('M83\nG92 X0 Y0 Z0\nG1 X1 E1') == [[[0, 0, 0], [1, 0, 0]]]


def test_homing_ends_the_stroke_and_the_place_is_not_known() -> None:
    text = 'M83\nG0 X0 Y0 Z0\nG1 X1 E1\nG28 X0\nG1 X5 E1\nG1 X6 E1'
    design = design_from_g_code(text)
    assert strokes(text) == [[[0, 0, 0], [1, 0, 0]], [[5, 0, 0], [6, 0, 0]]]
    assert design.notes == ('line 5: ink is left out up to where x is told',)


def test_ink_from_a_place_that_is_not_told_is_left_out() -> None:
    """Also where it is told to be where the counting happens to begin."""
    text = 'M83\nG0 Y1 Z1\nG1 X0 E1\nG1 X5 E1'
    assert strokes(text) == [[[0, 1, 1], [5, 1, 1]]]
    assert design_from_g_code(text).notes == ('line 3: ink is left out up to where x is told',)


def test_ink_at_one_place_is_no_stroke_and_does_not_end_one() -> None:
    assert strokes('M83\nG0 X0 Y0 Z0\nG1 E5\nG1 X1 E1\nG1 E-1\nG1 E1\nG1 X2 E1') == [
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]]]


def test_tools_divide_strokes() -> None:
    design = design_from_g_code('M83\nG0 X0 Y0 Z0\nG1 X1 E1\nT1\nG1 X2 E1')
    assert [stroke.tool for stroke in design.strokes] == [0, 1]


def test_layers_without_comments_are_heights() -> None:
    text = 'M83\n' + ''.join(f'G0 X0 Y{y} Z{z}\nG1 X9 E1\n'
                             for y, z in ((0, 0.3), (1, 0.305), (0, 0.6), (0, 0.9), (2, 0.6)))
    assert [stroke.layer for stroke in design_from_g_code(text).strokes] == [0, 0, 1, 2, 1]


@pytest.mark.parametrize(('comment', 'layers'), [
    ('; layer {0}, Z = 0.2', [0, 1]), (';LAYER:{0}', [0, 1]), ('; BEGIN_LAYER_OBJECT z=1', [0, 0]),
    (';LAYER_CHANGE', [0, 1]), ('; CHANGE_LAYER', [0, 1]), (';layer {0}', [0, 1]),
    (';LAYER:-{0}', [1, 0])])
def test_layers_are_told_in_comments(comment: str, layers: list[int]) -> None:
    text = 'M83\nG0 X0 Y0 Z1\n' + ''.join(
        f'{comment.format(number)}\nG0 Y{number}\nG1 X{number} E1\n' for number in (3, 4))
    assert [stroke.layer for stroke in design_from_g_code(text).strokes] == layers


def test_old_switches_count_where_there_is_no_e() -> None:
    assert strokes('G0 X0 Y0 Z0\nM101\nG1 X1\nM103\nG1 X2') == [[[0, 0, 0], [1, 0, 0]]]


def test_firmwares_that_agree_need_no_m82_or_m83() -> None:
    assert len(strokes('G0 X0 Y0 Z0\nG1 X1 E1\nG1 X2 E2\nG91\nG1 Z1 E-5\n')) == 1


@pytest.mark.parametrize('text', [
    'G0 X0 Y0 Z0\nG1 X1 E1\nG1 X2 E1', 'M83\nG90\nG0 X0 Y0 Z0\nG1 X1 E1\nG1 X2 E1'])
def test_where_firmwares_differ_the_file_has_to_say_what_e_is(text: str) -> None:
    with pytest.raises(DesignError, match=r'line \d: expected M82 or M83 after the last G90 .*'
                                          'found none: firmwares read G1X2E1 in two ways; add'):
        design_from_g_code(text)


HEAD = 'M83\nG0 X0 Y0 Z0\nG1 X1 E1\n'


@pytest.mark.parametrize(('line', 'message'), [
    ('G1 X', 'expected a number up to 1e.09 behind X, found none in G1X; write it'),
    ('G1 Xa', 'expected a number up to 1e.09 behind X, found none'),
    ('G1 X1..2', "expected a letter with a number, found '.2'; correct it"),
    ('G1 X1 ?', r"expected a letter with a number, found '\?'; correct it"),
    ('X', 'expected a number up to 1e.09 behind X, found none'),
    ('G1 X20000', 'expected coordinates up to 10000 mm, found G1X20000; correct it'),
    ('G1 X' + 400 * '9', 'expected a number up to 1e.09 behind X, found inf'),
    ('G18', r'expected arcs in the plane of x and y, G17, found G18; write arcs'),
    ('G5 X1', 'expected a command that is known, found G5X1; leave it out'),
    ('G10 L2 P1 X5', 'expected coordinates that go on as they are, found G10L2P1X5; write'),
    ('G55', 'expected coordinates that go on as they are, found G55; write moves without it'),
    ('G2 X3 E1', 'expected an arc with I and J, or with R, found neither; write one'),
    ('G2 X3 I1 R1 E1', 'expected an arc with I and J, or with R, found both; write one'),
    ('G2 X3 I5 E1', r'expected an arc whose ends are as far .* found 5.000 and 3.000 mm; correct'),
    ('G2 I0 J0 E1', 'expected an arc whose ends are as far from its centre, found 0.000'),
    ('G2 X9 R3 E1', 'expected a radius of 4.000 mm or more, found 3.000 mm; correct R'),
    ('G2 R3 E1', 'expected an arc with R that ends elsewhere, found one that ends where'),
    ('G2 X3 I1 P3 E1', 'expected an arc without P and K, found G2X3I1P3E1; write each turn'),
    ('G1 X2 E1*3', 'expected the checksum 104, found 3; the line was damaged'),
    ('G1 X2 G1 Y2', 'expected one command that moves, at the end, found G1 X2 G1 Y2; write each'),
    ('M8 G1 X2', 'expected nothing of another command behind M8, found M8 G1 X2; write each'),
    ('T', 'expected a command, found T; write G1 before it, or make it a'),
    ('T1.5', 'expected the number of a tool, found T1.5; correct it'),
    (';WIDTH:1-2', 'expected a width from 0.02 to 100 mm, found 1-2; correct it'),
    (';WIDTH:4e9', 'expected a width from 0.02 to 100 mm, found 4e9; correct it'),
    ('G1 X2' + 2000 * ' ' + 'E1', 'expected at most 1000 letters, found 20')])
def test_what_is_wrong_is_refused_with_its_line(line: str, message: str) -> None:
    with pytest.raises(DesignError, match=f'line 4: {message}'):
        design_from_g_code(HEAD + line + '\nG1 X3 E1\n')


@pytest.mark.parametrize(('text', 'message'), [
    ('', 'expected moves with E, .* found neither; name the commands'),
    ('M83\nG0 X0 Y0 Z0\nG1 E5', 'expected moves that lay ink, found none; give places'),
    ('M83\nG28\nG1 X5 E1\nG28', 'expected moves that lay ink, found line 3: ink is left out up to '
     'where x is told; give places'),
    ('G0 X0 Y0\nM106 S255\nG0 X9', 'expected moves with E, .* found M106, which have other uses')])
def test_a_file_without_ink_is_refused(text: str, message: str) -> None:
    with pytest.raises(DesignError, match=message):
        design_from_g_code(text)


def written(design: Design) -> str:
    """A design as G-code, in a style of the test's own."""
    lines = ['G21', 'G90', 'M83']
    layer = -1
    for stroke in design.strokes:
        if stroke.layer != layer:
            layer = stroke.layer
            lines.append(f';LAYER:{layer}')
        lines.append(f'T{stroke.tool}')
        (x, y, z), *others = (stroke.points / MM).tolist()
        lines += [f'G0 Z{z + 1000:.5f}', f'G0 X{x:.5f} Y{y:.5f}', f'G0 Z{z:.5f}']
        for (x, y, z), width in zip(others, (stroke.widths / MM).tolist(), strict=True):
            lines += [f';WIDTH:{width:.6f}', f'G1 X{x:.5f} Y{y:.5f} Z{z:.5f} E0.1']
    return '\n'.join(lines)


WHOLE = st.integers(-10_000, 10_000)
POINTS = st.lists(st.tuples(WHOLE, WHOLE, WHOLE), min_size=2, max_size=6, unique=True)


@settings(max_examples=40)
@given(st.lists(st.tuples(POINTS, st.integers(1, 90), st.integers(0, 3)), min_size=1, max_size=5))
def test_what_is_written_is_read(parts: list[tuple[list[tuple[int, int, int]], int, int]]) -> None:
    design = Design(tuple(
        DesignStroke(np.array(points) * 1e-5, np.full(len(points) - 1, width * MM), layer, tool)
        for layer, (points, width, tool) in enumerate(parts)))
    found = design_from_g_code(written(design))
    assert len(found.strokes) == len(design.strokes)
    for one, other in zip(found.strokes, design.strokes, strict=True):
        np.testing.assert_allclose(one.points, other.points, atol=1e-9)
        np.testing.assert_allclose(one.widths, other.widths, atol=1e-9)
        assert (one.layer, one.tool) == (other.layer, other.tool)
