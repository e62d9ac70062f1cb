"""From the stepper driver's numbers to metres and litres, counted by hand."""

from __future__ import annotations

import math

import pytest

from bpc_perception.core.config import PlungerConfig
from bpc_perception.core.extruder.plunger import Plunger
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
# 200 steps a turn of 1 mm: in mode 3, an eighth, a microstep is 0.625 micrometres.
CONFIG = PlungerConfig(lead=1e-3, bore=0.02)


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


def test_microsteps_become_metres() -> None:
    # 16000000 microsteps in 10000 s are 1600 a second: one turn, one millimetre.
    motion = Plunger(CONFIG).motion(TicState(None, 3200, 16_000_000, 3))
    assert motion.velocity == pytest.approx(1e-3)
    assert motion.position == pytest.approx(2e-3)
    assert motion.flow_rate == pytest.approx(math.pi / 4 * 0.02**2 * 1e-3)
    assert motion.extruding
    assert not motion.position_uncertain


def test_a_reversed_drive() -> None:
    config = PlungerConfig(lead=1e-3, bore=0.02, reversed=True)
    pushing = Plunger(config).motion(TicState(None, -3200, -16_000_000, 3))
    assert (pushing.extruding, pushing.velocity, pushing.position) == (
        True, pytest.approx(1e-3), pytest.approx(2e-3))
    retracting = Plunger(config).motion(TicState(None, 0, 16_000_000, 3))
    assert not retracting.extruding
    assert retracting.flow_rate < 0


def test_a_change_of_step_mode_moves_no_plunger() -> None:
    plunger = Plunger(CONFIG)
    plunger.motion(TicState(None, 3200, 0, 3))  # 2 mm
    changed = plunger.motion(TicState(None, 3200, 0, 5))
    assert changed.position == pytest.approx(2e-3)
    further = plunger.motion(TicState(None, 9600, 6400 * 10000, 5))  # a turn on, at one a second
    assert further.position == pytest.approx(3e-3)
    assert further.velocity == pytest.approx(1e-3)


def test_what_is_not_known_is_not_a_number() -> None:
    motion = Plunger(PlungerConfig()).motion(TicState(None, 3200, 1, 3, misc_flags=2))
    assert math.isnan(motion.velocity)
    assert math.isnan(motion.position)
    assert math.isnan(motion.flow_rate)
    assert motion.extruding  # the sign is known
    assert motion.position_uncertain


def test_errors_are_told_by_name() -> None:
    assert error_names(0) == ''
    assert error_names(1 << 6 | 1 << 20) == 'command timeout, encoder skip'
    assert error_names(1 << 30) == 'bit 30'
