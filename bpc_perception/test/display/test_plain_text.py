"""What others write does no harm where it is shown."""

from __future__ import annotations

import os

import pytest

from bpc_perception.display.plain_text import one_line, printable, table_cell

TITLE = '\x1b]0;all is well\x07\x1b[2J'  # sets the title of a terminal, and clears its screen


@pytest.mark.parametrize(('text', 'shown'), [
    ('2.0 ± 0.1 mm, Düse ▁▂▃ 噴嘴\n', '2.0 ± 0.1 mm, Düse ▁▂▃ 噴嘴\n'),
    (TITLE, r'\x1b]0;all is well\x07\x1b[2J'),
    ('100 %\r  0 %\b\x7f\x9b1m', r'100 %\r  0 %\x08\x7f\x9b1m'),
    ('ab\u202ecd\u2028', r'ab\u202ecd\u2028'),
    (os.fsdecode(b'vase-\xff'), r'vase-\udcff')])
def test_a_terminal_is_told_nothing_but_text(text: str, shown: str) -> None:
    assert printable(text) == shown
    shown.encode()


def test_a_line_stays_one() -> None:
    assert one_line(' ok\n  FAIL /pose: nobody\x1b[1m ') == r'ok   FAIL /pose: nobody\x1b[1m'


@pytest.mark.parametrize(('text', 'cell'), [
    ('=HYPERLINK("http://x";"y")', '\'=HYPERLINK("http://x";"y")'), ('+1+cmd', "'+1+cmd"),
    ('-2+3', "'-2+3"), ('@SUM(1)', "'@SUM(1)"), (' =1', "'=1"), ('\t=1', "'=1"),
    ('＝1', "'＝1"), ('a\t=1', r'a\t=1'), ('-inf', "'-inf"), ('a\n=1', 'a =1'),  # noqa: RUF001
    ('-2.5', '-2.5'), ('+3', '+3'), ('-1e-3', '-1e-3'), ('a=1', 'a=1'), ('', '')])
def test_a_cell_is_no_formula_and_a_number_stays_one(text: str, cell: str) -> None:
    assert table_cell(text) == cell
