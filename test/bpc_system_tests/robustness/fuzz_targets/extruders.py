"""Fuzz targets: the serial lines of extruders."""

from __future__ import annotations

from binascii import crc_hqx
from contextlib import suppress

from rclpy.serialization import serialize_message
import ticlib

from bpc_perception.core.config import PlungerConfig
from bpc_perception.core.extruder.plunger import Plunger
from bpc_perception.core.extruder.tic import ExtruderError, format_line, TicState
from bpc_perception.drivers.extruders.devices import SerialExtruder, TicExtruder
from bpc_perception.messages.extruder import extruder_from_message, extruder_to_message
from bpc_perception.messages.stamps import ConversionError

PLUNGER = PlungerConfig(lead=0.8e-3, bore=14e-3)
PIECE_BYTES = 37  # in which bytes arrive on a line


class FakeLine:
    """A serial line on which given bytes arrive in pieces."""

    def __init__(self, data: bytes) -> None:
        self._data = data

    @property
    def in_waiting(self) -> int:
        return min(len(self._data), PIECE_BYTES)

    def read(self, size: int = 1) -> bytes:
        data, self._data = self._data[:size], self._data[size:]
        return data

    def write(self, data: bytes) -> int:
        return len(data)

    def reset_input_buffer(self) -> None:
        pass

    def close(self) -> None:
        pass


class AnsweringLine(FakeLine):
    """A serial line on which bytes arrive only when they are read."""

    @property
    def in_waiting(self) -> int:
        return 0


def extruder_lines() -> list[bytes]:
    """Return what an Arduino sends."""
    states = [TicState(time * 10**6, -500 + time, 2000000, 3, vin_mv=12000)
              for time in (0, 20, 40)]
    return [b''.join(map(format_line, states)), format_line(states[1])]


def read_lines(data: bytes) -> object:
    """Read lines as they are, and again with correct checksums."""
    plunger = Plunger(PLUNGER)
    right = b'\n'.join(line.rpartition(b'*')[0] + b'*%04X' % crc_hqx(line.rpartition(b'*')[0], 0)
                       for line in data.split(b'\n'))
    for text in (data, b'\n' + right + b'\n'):
        refusals: list[object] = []
        extruder = SerialExtruder(FakeLine(text), refusals.append)
        for _ in range(len(text) // PIECE_BYTES + 1):
            for state in extruder.read():
                publish(state, plunger)
    return None


def tic_answers() -> bytes:
    """Return what a Tic answers to the four questions, three times."""
    motion = (1000).to_bytes(4, 'little') + (-20000).to_bytes(4, 'little', signed=True)
    status = bytes((10, 1, 0, 0, 0, 0, 0, 0))
    return b''.join(motion + status + b'\3' + b'\x10\x2e' + up_ms.to_bytes(4, 'little')
                    for up_ms in (1000, 1020, 1040))


def read_tic(data: bytes) -> object:
    """Read from a Tic on a serial line that answers given bytes."""
    line, plunger = AnsweringLine(data), Plunger(PLUNGER)
    refusals: list[object] = []
    extruder = TicExtruder(ticlib.TicSerial(line, None), line, refusals.append)
    for _ in range(3):
        try:
            for state in extruder.read():
                publish(state, plunger)
        except ExtruderError:
            return None
    return None


def publish(state: TicState, plunger: Plunger) -> None:
    """Do all that the bridge does with a state, up to the bytes that it sends."""
    message = extruder_to_message(state.device_ns or 0, plunger.motion(state), state.error_status)
    serialize_message(message)
    with suppress(ConversionError):  # of a rate that no syringe reaches
        extruder_from_message(message)
