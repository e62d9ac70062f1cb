"""Extruders on a wire: an Arduino's lines, or the Tic itself. The vendors' packages come late."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
import math
import time
from typing import Any, Protocol

from bpc_perception.core.config import ExtruderConfig
from bpc_perception.core.extruder.tic import ExtruderError, parse_line, StateError, TicState

LONGEST_LINE = 512  # [bytes]
TIC_PATIENCE = 0.1  # for an answer [s]
TIC_QUIET = 0.3  # after which none is under way any more [s]
TIC_DELAY = 1.0  # by which our reading of its clock may vary on a busy computer [s]
USB = 'usb'

Refuse = Callable[[object], None]


class Extruder(Protocol):
    """A source of states; what comes and cannot be used is refused."""

    def read(self) -> list[TicState]:
        """The states since the last call. Raises ExtruderError when the device is gone."""

    def close(self) -> None:
        """Let go of the device."""


def open_extruder(config: ExtruderConfig, refuse: Refuse) -> Extruder:
    """The device of a configuration, not written to beyond asking for its state.

    Raises ExtruderError where it is not there, ValueError where its package is not installed.
    """
    try:
        serial = import_module('serial')
        ticlib = import_module('ticlib') if config.back_end == 'tic' else None
    except ImportError as error:
        raise ValueError(f'back_end: expected the packages of {config.back_end} to be installed, '
                         f'found: {error}') from error
    try:
        if ticlib is None:
            line = serial.Serial(config.port, config.baud, timeout=0, exclusive=True)
            return SerialExtruder(line, refuse)
        if config.port == USB:
            return TicExtruder(ticlib.TicUSB(), None, refuse)
        line = serial.Serial(config.port, config.baud, timeout=TIC_PATIENCE, exclusive=True)
        return TicExtruder(ticlib.TicSerial(line, config.device_number), line, refuse)
    # ticlib raises plain Exceptions: no pyusb, no device.
    except Exception as error:
        raise ExtruderError(f'{config.port}: expected the extruder, found: {error}') from error


class SerialExtruder:
    """Lines of a micro-controller, see ``core.extruder``."""

    def __init__(self, line: Any, refuse: Refuse) -> None:
        self._line = line
        self._refuse = refuse
        self._rest = b''
        self._begun = False  # what comes first may be the end of a line

    def read(self) -> list[TicState]:
        """The states of all complete lines."""
        try:
            self._rest += self._line.read(max(self._line.in_waiting, 1))
        except OSError as error:  # serial.SerialException is one
            raise ExtruderError(f'serial line: expected to read it, found: {error}') from error
        *lines, self._rest = self._rest.split(b'\n')
        if len(self._rest) > LONGEST_LINE:
            self._refuse(f'line: expected an end within {LONGEST_LINE} bytes, found none')
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


class TicExtruder:
    """A Tic, asked for its variables through ticlib. It is told nothing.

    ticlib has a method for each variable. Those that belong together are read as one block, so
    that position and velocity are of the same instant, and all error bits are kept, of which
    ticlib's own list leaves out the last.

    An answer does not say to which question. One that comes late would be taken for that to the
    next, and so on from there. Hence nothing is asked where an answer may still be under way, and
    a state counts only if the Tic's clock has gone on as ours has.
    """

    READ = 0xA1  # "get variable"; unlike 0xA2 it does not clear the errors

    def __init__(self, tic: Any, line: Any, refuse: Refuse) -> None:
        self._tic = tic
        self._line = line
        self._refuse = refuse
        self._quiet_since = -math.inf  # [s]
        self._last: tuple[float, int] | None = None  # our time [s], the Tic's [ms]

    def read(self) -> list[TicState]:
        """The state now."""
        try:
            if not self._is_quiet():
                return []
            motion = self._block(0x22, 8)
            status = self._block(0x00, 8)
            step_mode, = self._block(0x49, 1)
            supply = self._block(0x33, 6)  # and the time since its start
        except OSError as error:  # the line or USB is gone
            raise ExtruderError(f'tic: expected to read it, found: {error}') from error
        except RuntimeError as error:  # of ticlib: bytes were lost, or are late
            return self._begin_anew(f'tic: expected an answer, found: {error}')
        now, up_ms = time.monotonic(), int.from_bytes(supply[2:], 'little')
        before, self._last = self._last, (now, up_ms)
        if before is None:
            return []
        if not 0 < up_ms - before[1] < (now - before[0] + TIC_DELAY) * 1e3:
            return self._begin_anew('tic: expected its clock to go on as ours does, found '
                                    f'{before[1]} and then {up_ms} ms: it was reset, or its '
                                    'answers are late')
        try:
            return [TicState(
                device_ns=up_ms * 10**6, position=_signed(motion[:4]),
                velocity=_signed(motion[4:]), step_mode=step_mode, operation_state=status[0],
                misc_flags=status[1], error_status=int.from_bytes(status[2:4], 'little'),
                errors_occurred=int.from_bytes(status[4:8], 'little'),
                vin_mv=int.from_bytes(supply[:2], 'little'))]
        except StateError as error:
            self._refuse(f'tic: {error}')
            return []

    def _begin_anew(self, reason: str) -> list[TicState]:
        """Refuse what was read, and wait until what was asked for so far has come."""
        self._refuse(reason)
        self._quiet_since, self._last = time.monotonic(), None
        return []

    def _is_quiet(self) -> bool:
        """Whether no answer is waiting or under way."""
        if self._line is None:  # over USB an answer belongs to its question
            return True
        if count := self._line.in_waiting:
            self._line.reset_input_buffer()
            self._begin_anew(f'tic: expected no more than was asked for, found {count} bytes')
        return time.monotonic() - self._quiet_since > TIC_QUIET

    def close(self) -> None:
        """Close the line, or give the USB device back."""
        if self._line is not None:
            self._line.close()
        else:
            import_module('usb.util').dispose_resources(self._tic.usb)

    def _block(self, offset: int, length: int) -> bytes:
        return bytes(self._tic._block_read(self.READ, offset, length))


def _signed(value: bytes) -> int:
    return int.from_bytes(value, 'little', signed=True)
