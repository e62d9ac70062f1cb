"""Extruders on a wire: the lines of an Arduino, or a Tic itself.

The vendors' packages are imported only when an extruder is opened.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
import math
import time
from typing import Any, Protocol

from bpc_perception.core.config import ExtruderConfig
from bpc_perception.core.extruder.tic import ExtruderError, parse_line, StateError, TicState
from bpc_perception.drivers.extruders.ports import named_present

LONGEST_LINE_BYTES = 512
TIC_ANSWER_TIMEOUT_S = 0.1
TIC_QUIET_TIME_S = 0.3  # after this much silence no answer is under way any more
TIC_READING_JITTER_S = 1.0  # of its clock, as we read it on a busy computer
USB_PORT = 'usb'

Refuse = Callable[[object], None]


class Extruder(Protocol):
    """A source of states; what cannot be used is refused."""

    def read(self) -> list[TicState]:
        """Return the states since the last call. Raises ExtruderError when the device is gone."""

    def close(self) -> None:
        """Close the device."""


def load_packages(config: ExtruderConfig) -> tuple[Any, Any]:
    """Return pyserial and, if it is needed, ticlib. Raises ValueError if one is not installed."""
    try:
        return (import_module('serial'),
                import_module('ticlib') if config.back_end == 'tic' else None)
    except ImportError as error:
        raise ValueError(f'back_end: expected the packages of {config.back_end} to be installed, '
                         f'found: {error}; install them, as with pip') from error


def open_extruder(config: ExtruderConfig, refuse: Refuse) -> Extruder:
    """Open the device of a configuration. Nothing is written to it but requests for its state.

    Raises ExtruderError when it is not there, ValueError when its package is not installed.
    """
    serial, ticlib = load_packages(config)
    try:
        if ticlib is None:
            line = serial.Serial(config.port, config.baud, timeout=0, exclusive=True)
            return SerialExtruder(line, refuse)
        if config.port == USB_PORT:
            return TicExtruder(ticlib.TicUSB(), None, refuse)
        line = serial.Serial(config.port, config.baud, timeout=TIC_ANSWER_TIMEOUT_S,
                             exclusive=True)
        return TicExtruder(ticlib.TicSerial(line, config.device_number), line, refuse)
    # ticlib raises plain Exceptions, for instance without pyusb or without a device.
    except Exception as error:
        there = '' if config.port == USB_PORT else f'; {named_present()}'
        raise ExtruderError(
            f'{config.port}: expected the extruder, found: {error}{there}; look at its cable, at '
            'port, and whether you may open it') from error


class SerialExtruder:
    """A micro-controller that sends lines; ``core.extruder.tic`` describes them."""

    def __init__(self, line: Any, refuse: Refuse) -> None:
        self._line = line
        self._refuse = refuse
        self._rest = b''
        self._begun = False  # the first line may be only the end of one

    def read(self) -> list[TicState]:
        """Return the states of all complete lines. Raises ExtruderError."""
        try:
            self._rest += self._line.read(max(self._line.in_waiting, 1))
        except OSError as error:  # serial.SerialException is one
            raise ExtruderError(f'serial line: expected to read it, found: {error}'
                                '; look at its cable') from error
        *lines, self._rest = self._rest.split(b'\n')
        if len(self._rest) > LONGEST_LINE_BYTES:
            self._refuse(f'line: expected an end within {LONGEST_LINE_BYTES} bytes, found none')
            self._rest = b''
        if lines and not self._begun:
            self._begun = True
            del lines[0]
        states = []
        for line in lines:
            try:
                states.append(parse_line(line))
            except StateError as error:
                self._refuse(error)
        return states

    def close(self) -> None:
        """Close the line."""
        self._line.close()


@dataclass(frozen=True)
class _TicVariables:
    """Variables of a Tic, in the blocks in which they are read.

    Attributes:
        motion: position and velocity, 8 bytes.
        status: operation state, flags, errors, 8 bytes.
        step_mode: code of the size of a microstep.
        supply: supply voltage and the time since the start, 6 bytes.
    """

    motion: bytes
    status: bytes
    step_mode: int
    supply: bytes

    @property
    def up_ms(self) -> int:
        """Time since the start of the Tic [ms]."""
        return int.from_bytes(self.supply[2:], 'little')

    def state(self) -> TicState:
        """Return the state that the variables describe. Raises StateError."""
        motion, status = self.motion, self.status
        return TicState(
            device_ns=self.up_ms * 10**6, position=_signed(motion[:4]),
            velocity=_signed(motion[4:]), step_mode=self.step_mode, operation_state=status[0],
            misc_flags=status[1], error_status=int.from_bytes(status[2:4], 'little'),
            errors_occurred=int.from_bytes(status[4:8], 'little'),
            vin_mv=int.from_bytes(self.supply[:2], 'little'))


class TicExtruder:
    """A Tic that is asked for its variables through ticlib, and never told to do anything.

    ticlib has a method for each variable. Here variables that belong together are read as one
    block: then position and velocity are of the same instant. This also keeps all error bits; the
    list in ticlib leaves out the last.

    An answer does not say to which request it belongs. If one came late, it would be taken for the
    answer to the next request, and so on. So nothing is requested while an answer may still be
    under way, and a state counts only if the clock of the Tic has advanced as ours has.
    """

    GET_VARIABLE = 0xA1  # command; unlike 0xA2 it does not clear the errors

    def __init__(self, tic: Any, line: Any, refuse: Refuse) -> None:
        self._tic = tic
        self._line = line
        self._refuse = refuse
        self._quiet_since = -math.inf  # [s]
        self._last: tuple[float, int] | None = None  # our time [s], the Tic's [ms]

    def read(self) -> list[TicState]:
        """Return the state now, or nothing when it cannot be trusted. Raises ExtruderError."""
        try:
            if not self._is_quiet():
                return []
            variables = self._read_variables()
        except OSError as error:  # the line or the USB device is gone
            raise ExtruderError(f'tic: expected to read it, found: {error}'
                                '; look at its cable') from error
        except RuntimeError as error:  # from ticlib: bytes were lost, or are late
            self._begin_anew(f'tic: expected an answer, found: {error}')
            return []
        if not self._follow_clock(variables.up_ms):
            return []
        try:
            return [variables.state()]
        except StateError as error:
            self._refuse(f'tic: {error}')
            return []

    def _read_variables(self) -> _TicVariables:
        motion = self._block(0x22, 8)
        status = self._block(0x00, 8)
        step_mode, = self._block(0x49, 1)
        return _TicVariables(motion, status, step_mode, supply=self._block(0x33, 6))

    def _follow_clock(self, up_ms: int) -> bool:
        """Note the clock of the Tic [ms]; return whether it has advanced as ours has."""
        now = time.monotonic()
        before, self._last = self._last, (now, up_ms)
        if before is None:
            return False
        if 0 < up_ms - before[1] < (now - before[0] + TIC_READING_JITTER_S) * 1e3:
            return True
        self._begin_anew('tic: expected its clock to go on as ours does, found '
                         f'{before[1]} and then {up_ms} ms: it was reset, or its answers are late')
        return False

    def _begin_anew(self, reason: str) -> None:
        """Refuse what was read, and wait until all requested answers must have come."""
        self._refuse(reason)
        self._quiet_since, self._last = time.monotonic(), None

    def _is_quiet(self) -> bool:
        """Return whether no answer is waiting or under way."""
        if self._line is None:  # over USB an answer belongs to its request
            return True
        if count := self._line.in_waiting:
            self._line.reset_input_buffer()
            self._begin_anew(f'tic: expected no more than was asked for, found {count} bytes')
        return time.monotonic() - self._quiet_since > TIC_QUIET_TIME_S

    def close(self) -> None:
        """Close the line, or release the USB device."""
        if self._line is not None:
            self._line.close()
        else:
            import_module('usb.util').dispose_resources(self._tic.usb)

    def _block(self, offset: int, length: int) -> bytes:
        return bytes(self._tic._block_read(self.GET_VARIABLE, offset, length))


def _signed(value: bytes) -> int:
    return int.from_bytes(value, 'little', signed=True)
