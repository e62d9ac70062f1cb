"""Text of others, such as names and reasons, made harmless where it is shown."""

from __future__ import annotations

import re
from unicodedata import category

# Control characters, halves of characters, and what ends a line. A terminal obeys some of them.
ESCAPED_CATEGORIES = ('Cc', 'Cs', 'Zl', 'Zp')
# They let a text be shown in another order than it is written in.
DIRECTIONS = '\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069'
FORMULA_STARTS = ('=', '+', '-', '@', '＝', '＋', '－', '＠')  # noqa: RUF001 (wide ones)
NUMBER = re.compile(r'[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?')


def printable(text: str) -> str:
    r"""Return a text whose control characters, but for ends of lines, are written as ``\x1b``."""
    return ''.join(letter if letter == '\n' or _is_plain(letter) else _escaped(letter)
                   for letter in text)


def one_line(text: str) -> str:
    """Return a text in one line, without control characters."""
    return printable(text.strip().replace('\n', ' '))


def table_cell(text: str) -> str:
    """Return a text for a table that programs for spreadsheets open: none takes it for a formula.

    A number stays one.
    """
    line = one_line(text)
    is_formula = line.startswith(FORMULA_STARTS) and not NUMBER.fullmatch(line)
    return f"'{line}" if is_formula else line


def _is_plain(letter: str) -> bool:
    return category(letter) not in ESCAPED_CATEGORIES and letter not in DIRECTIONS


def _escaped(letter: str) -> str:
    return letter.encode('unicode_escape').decode()
