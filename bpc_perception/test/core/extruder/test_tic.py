"""Lines of the stepper driver's state, and what damages them."""

from __future__ import annotations

import pytest

from bpc_perception.core.extruder.tic import (
    error_names,
    format_line,
    parse_line,
    StateError,
    TicState,
)

LINE = b'BPC1,1000,-5,20000,3,10,1,0,64,9120'


def crc(content: bytes) -> int:
    """CRC-16/XMODEM bit by bit, as its definition has it."""
    value = 0
    for byte in content:
        value ^= byte << 8
        for _ in range(8):
            value = (value << 1 ^ (0x1021 if value & 0x8000 else 0)) & 0xFFFF
    return value


SUM = crc(LINE)
STATE = TicState(1000 * 10**6, -5, 20000, 3, 10, 1, 0, 64, 9120)


def test_a_line_is_read() -> None:
    assert parse_line(LINE + b'*%04X\r' % SUM) == STATE
    assert parse_line(LINE + b'*%04x' % SUM) == STATE


def test_a_known_checksum() -> None:
    # The check value of CRC-16/XMODEM in the catalogue of CRCs.
    with pytest.raises(StateError, match='expected checksum 31C3'):
        parse_line(b'123456789*0000')


def test_what_is_written_is_read() -> None:
    assert format_line(STATE) == LINE + b'*%04X\r\n' % SUM
    assert parse_line(format_line(STATE)) == STATE


def test_lines_that_lost_a_byte_or_two_are_refused() -> None:
    whole = LINE + b'*%04X' % SUM
    for first in range(len(whole)):
        for second in range(first, len(whole)):
            damaged = whole[:first] + whole[first + 1:second] + whole[second + 1:]
            with pytest.raises(StateError, match='expected'):
                parse_line(damaged)


def with_sum(content: bytes) -> bytes:
    return content + b'*%04X' % crc(content)


@pytest.mark.parametrize(('content', 'words'), [
    (b'', 'expected BPC1 and 9 numbers'),
    (LINE.replace(b'BPC1', b'BPC2'), 'expected BPC1 and 9 numbers'),
    (LINE + b',1', 'expected BPC1 and 9 numbers'),
    (LINE.replace(b'20000', b'fast'), 'expected whole numbers'),
    (LINE.replace(b',3,', b',11,'), 'step mode: expected a code up to 9, found 11'),
])
def test_another_line_is_refused(content: bytes, words: str) -> None:
    with pytest.raises(StateError, match=words):
        parse_line(with_sum(content))


def test_errors_are_told_by_name() -> None:
    assert error_names(0) == ''
    assert error_names(1 << 6 | 1 << 20) == 'command timeout, encoder skip'
    assert error_names(1 << 30) == 'bit 30'
