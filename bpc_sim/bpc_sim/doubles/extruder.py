"""A stand-in for the rig's extruder on a pseudo-terminal, byte for byte as on the wire.

Either an Arduino that sends lines, or a Tic that answers on its own serial line in the Pololu
protocol (user's guide, section 9). It can lose bytes, be late, be reset, change its step mode
and be unplugged.
"""

from __future__ import annotations

from collections.abc import Callable
import os
from pathlib import Path
import random
import select
import threading
import time
import tty
from types import TracebackType

from bpc_perception.core.extruder.tic import format_line, MICROSTEPS, TicState

LINE_PERIOD = 0.02  # [s]
POLOLU, GET_VARIABLE = 0xAA, 0x21
NORMAL = 10

# Position [full steps] and velocity [full steps/s] of the motor at a time of time.time() [s].
Motion = Callable[[float], tuple[float, float]]


class TicDouble:
    """What a Tic knows of itself.

    Attributes:
        step_mode, misc_flags, error_status, errors_occurred: as in its variables.
    """

    def __init__(self, motion: Motion) -> None:
        self._motion = motion
        self._started = time.time()
        self._zero = 0.0
        self.step_mode = 3
        self.misc_flags = 1  # energized
        self.error_status = 0
        self.errors_occurred = 0

    def reset(self) -> None:
        """As after a loss of power: the clock starts anew, and nobody vouches for the position."""
        self._started = time.time()
        self._zero = self._motion(self._started)[0]
        self.misc_flags |= 2

    def state(self) -> TicState:
        """Its state now."""
        now = time.time()
        steps, speed = self._motion(now)
        size = MICROSTEPS[self.step_mode]
        return TicState(
            device_ns=round((now - self._started) * 1e3) * 10**6,
            position=round((steps - self._zero) * size), velocity=round(speed * size * 10000),
            step_mode=self.step_mode, operation_state=NORMAL, misc_flags=self.misc_flags,
            error_status=self.error_status, errors_occurred=self.errors_occurred, vin_mv=9120)

    def variables(self) -> bytes:
        """Its variables, by offset."""
        state = self.state()
        memory = bytearray(0x56)
        for offset, length, value in (
                (0x00, 1, state.operation_state), (0x01, 1, state.misc_flags),
                (0x02, 2, state.error_status), (0x04, 4, state.errors_occurred),
                (0x22, 4, state.position & 0xFFFFFFFF), (0x26, 4, state.velocity & 0xFFFFFFFF),
                (0x33, 2, state.vin_mv), (0x35, 4, (state.device_ns or 0) // 10**6),
                (0x49, 1, state.step_mode)):
            memory[offset:offset + length] = value.to_bytes(length, 'little')
        return bytes(memory)


class Wire:
    """A Tic on a pseudo-terminal, which has a name that stays; a context manager.

    Attributes:
        drop: share of the bytes that get lost.
        late: by how much the next that it sends comes late [s].
        answered: how often it sent something.
    """

    def __init__(self, tic: TicDouble, port: Path, lines: bool, device_number: int = 14) -> None:
        self.tic = tic
        self.drop = 0.0
        self.late = 0.0
        self.answered = 0
        self._port = port
        self._lines = lines
        self._device_number = device_number
        self._random = random.Random(0)
        self._thread: threading.Thread | None = None
        self._unplugged = threading.Event()
        self._request = b''

    def plug(self) -> None:
        """Connect it."""
        master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        self._port.unlink(missing_ok=True)
        self._port.symlink_to(os.ttyname(slave))
        os.close(slave)
        self._unplugged.clear()
        self._thread = threading.Thread(target=self._serve, args=(master,), daemon=True)
        self._thread.start()

    def unplug(self) -> None:
        """Disconnect it: its port is gone."""
        if self._thread is None:
            return
        self._port.unlink(missing_ok=True)
        self._unplugged.set()
        self._thread.join()
        self._thread = None

    def _serve(self, master: int) -> None:
        next_line = time.monotonic()
        while not self._unplugged.is_set():
            try:
                if self._lines:
                    self._unplugged.wait(max(next_line - time.monotonic(), 0))
                    next_line += LINE_PERIOD
                    self._send(master, format_line(self.tic.state()))
                elif select.select([master], [], [], LINE_PERIOD)[0]:
                    self._answer(master, os.read(master, 64))
            except OSError:  # nobody has the other end open, or it is full
                self._unplugged.wait(LINE_PERIOD)
        os.close(master)

    def _answer(self, master: int, data: bytes) -> None:
        self._request += data
        while len(self._request) >= 5:
            start, number, command, offset, length = self._request[:5]
            if (start, number, command) != (POLOLU, self._device_number, GET_VARIABLE):
                self._request = self._request[1:]  # as a receiver that looks for a start
                continue
            self._request = self._request[5:]
            self._send(master, self.tic.variables()[offset:offset + length])

    def _send(self, master: int, data: bytes) -> None:
        late, self.late = self.late, 0.0
        time.sleep(late)
        kept = bytes(byte for byte in data if self._random.random() >= self.drop)
        os.write(master, kept)
        self.answered += 1

    def __enter__(self) -> Wire:
        self.plug()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.unplug()
