"""The state of the extruder's stepper driver, and the line in which a micro-controller sends it.

The driver is a Pololu Tic; names, units and bits are those of its user's guide and of
``tic_protocol.h`` in pololu-tic-software. It is read directly, or through a micro-controller that
sends one line for each state:

    BPC1,millis,position,velocity,step_mode,operation_state,misc_flags,error_status,
    errors_occurred,vin_mv*XXXX

All of this is one line, which ends with LF or CR LF. The numbers are decimal integers. The four
digits after the asterisk are hexadecimal: the CRC-16/XMODEM of all bytes before it. (The exclusive
or of NMEA 0183 stays the same when two equal digits get lost.) ``millis`` is the
micro-controller's clock [ms], 32 bits.
"""

from __future__ import annotations

from binascii import crc_hqx
from dataclasses import dataclass

LINE_START = b'BPC1'
LINE_FIELDS = ('millis', 'position', 'velocity', 'step_mode', 'operation_state', 'misc_flags',
               'error_status', 'errors_occurred', 'vin_mv')
VELOCITY_PERIOD_S = 10_000  # velocities are in microsteps per this time
# Microsteps per full step, by the code of the step mode.
MICROSTEPS = {0: 1, 1: 2, 2: 4, 3: 8, 4: 16, 5: 32, 6: 2, 7: 64, 8: 128, 9: 256}
OPERATION_STATES = {0: 'reset', 2: 'de-energized', 4: 'soft error', 6: 'waiting for ERR line',
                    8: 'starting up', 10: 'normal'}
# Widths of the Tic's variables, and of the micro-controller's clock.
FIELD_LIMITS = {'millis': (0, 2**32 - 1), 'position': (-2**31, 2**31 - 1),
                'velocity': (-2**31, 2**31 - 1), 'operation_state': (0, 255),
                'misc_flags': (0, 255), 'error_status': (0, 2**16 - 1),
                'errors_occurred': (0, 2**32 - 1), 'vin_mv': (0, 2**16 - 1)}
# By their bits.
ERROR_NAMES = {0: 'intentionally de-energized', 1: 'motor driver', 2: 'low VIN', 3: 'kill switch',
               4: 'required input invalid', 5: 'serial error', 6: 'command timeout',
               7: 'safe start violation', 8: 'ERR line high', 16: 'serial framing',
               17: 'RX overrun', 18: 'format', 19: 'CRC', 20: 'encoder skip'}


class ExtruderError(RuntimeError):
    """The extruder cannot be read any more; the message says why."""


class StateError(ValueError):
    """One state cannot be used; the message names what was expected and found."""


@dataclass(frozen=True)
class TicState:
    """What the stepper driver reports.

    Raises StateError if the step mode is unknown or a number has more bits than the Tic sends.

    Attributes:
        device_ns: time by the device's clock [ns]; None = it has no clock.
        position: commanded [microsteps].
        velocity: commanded [microsteps per 10000 s].
        step_mode: code of the size of a microstep.
        operation_state, misc_flags, error_status, errors_occurred: as the Tic has them.
        vin_mv: supply voltage [mV].
    """

    device_ns: int | None
    position: int
    velocity: int
    step_mode: int
    operation_state: int = 10
    misc_flags: int = 0
    error_status: int = 0
    errors_occurred: int = 0
    vin_mv: int = 0

    def __post_init__(self) -> None:
        if self.step_mode not in MICROSTEPS:
            raise StateError(f'step mode: expected a code up to {max(MICROSTEPS)}, '
                             f'found {self.step_mode}; is it a Tic?')
        for name, (least, most) in FIELD_LIMITS.items():
            value = (self.device_ns or 0) // 10**6 if name == 'millis' else getattr(self, name)
            if not least <= value <= most:
                raise StateError(f'{name}: expected {least} to {most}, found {value}'
                                 '; is it of the reference sketch?')


def error_names(bits: int) -> str:
    """Return the errors of ``error_status`` or ``errors_occurred`` in words; empty = none."""
    return ', '.join(ERROR_NAMES.get(bit, f'bit {bit}') for bit in range(32) if bits >> bit & 1)


def parse_line(line: bytes) -> TicState:
    """Return the state in a line.

    Raises StateError if the checksum, the number of fields or a number is wrong.
    """
    content, star, given = line.strip().rpartition(b'*')
    expected = b'%04X' % crc_hqx(content, 0)
    if not star or given.upper() != expected:
        raise StateError(f'line: expected checksum {expected.decode()}, found {_shown(line)}'
                         '; look at cable and baud rate')
    start, *fields = content.split(b',')
    if start != LINE_START or len(fields) != len(LINE_FIELDS):
        raise StateError(f'line: expected {LINE_START.decode()} and {len(LINE_FIELDS)} numbers, '
                         f'found {_shown(line)}; is it of the reference sketch?')
    try:
        millis, *numbers = (int(field) for field in fields)
    except ValueError:
        raise StateError(f'line: expected whole numbers, found {_shown(line)}'
                         '; is it of the reference sketch?') from None
    return TicState(millis * 10**6, *numbers)


def format_line(state: TicState) -> bytes:
    """Return the line of a state, as the reference sketch sends it."""
    numbers = ((state.device_ns or 0) // 10**6, state.position, state.velocity, state.step_mode,
               state.operation_state, state.misc_flags, state.error_status,
               state.errors_occurred, state.vin_mv)
    content = b','.join((LINE_START, *(b'%d' % number for number in numbers)))
    return content + b'*%04X\r\n' % crc_hqx(content, 0)


def _shown(line: bytes) -> str:
    """Return the start of a line as it can be shown."""
    return repr(line[:80])[1:]
