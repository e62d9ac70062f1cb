"""A stand-in for the rig's extruder on a pseudo-terminal, byte for byte as on the wire.

It is either an Arduino that sends lines, or a Tic that answers on its own serial line in the
Pololu protocol (user's guide, section 9). It can lose bytes, be late, be reset, change its step
mode and be unplugged.
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

LINE_PERIOD_S = 0.02
POLOLU_START_BYTE = 0xAA
GET_VARIABLE = 0x21  # command
REQUEST_BYTES = 5
NORMAL_OPERATION = 10  # operation state
VARIABLES_BYTES = 0x56

# Position [full steps] and velocity [full steps/s] of the motor at a time of time.time() [s].
Motion = Callable[[float], tuple[float, float]]


class TicDouble:
    """The state of a Tic.

    Attributes:
        step_mode, misc_flags, error_status, errors_occurred: as in the variables of a Tic.
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
        """Reset as after a loss of power: the clock restarts, and the position is uncertain."""
        self._started = time.time()
        self._zero = self._motion(self._started)[0]
        self.misc_flags |= 2  # position uncertain

    def state(self) -> TicState:
        """Return the present state."""
        now = time.time()
        steps, speed = self._motion(now)
        size = MICROSTEPS[self.step_mode]
        return TicState(
            device_ns=round((now - self._started) * 1e3) * 10**6,
            position=round((steps - self._zero) * size), velocity=round(speed * size * 10000),
            step_mode=self.step_mode, operation_state=NORMAL_OPERATION, misc_flags=self.misc_flags,
            error_status=self.error_status, errors_occurred=self.errors_occurred, vin_mv=9120)

    def variables(self) -> bytes:
        """Return all variables as bytes, by offset."""
        state = self.state()
        memory = bytearray(VARIABLES_BYTES)
        for offset, length, value in (
                (0x00, 1, state.operation_state), (0x01, 1, state.misc_flags),
                (0x02, 2, state.error_status), (0x04, 4, state.errors_occurred),
                (0x22, 4, state.position & 0xFFFFFFFF), (0x26, 4, state.velocity & 0xFFFFFFFF),
                (0x33, 2, state.vin_mv), (0x35, 4, (state.device_ns or 0) // 10**6),
                (0x49, 1, state.step_mode)):
            memory[offset:offset + length] = value.to_bytes(length, 'little')
        return bytes(memory)


class Wire:
    """A Tic on a pseudo-terminal whose name stays the same; a context manager.

    Attributes:
        tic: the state of the Tic.
        drop: share of the bytes that get lost.
        late: delay of what is sent next [s].
        copies: how often each line is sent.
        answered: how often something was sent.
    """

    def __init__(self, tic: TicDouble, port: Path, lines: bool, device_number: int = 14) -> None:
        self.tic = tic
        self.drop = 0.0
        self.late = 0.0
        self.copies = 1
        self.answered = 0
        self._port = port
        self._lines = lines
        self._device_number = device_number
        self._random = random.Random(0)
        self._thread: threading.Thread | None = None
        self._unplugged = threading.Event()
        self._request = b''

    def plug(self) -> None:
        """Connect the device: its port appears."""
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
        """Disconnect the device: its port disappears."""
        if self._thread is None:
            return
        self._port.unlink(missing_ok=True)
        self._unplugged.set()
        self._thread.join()
        self._thread = None

    def _serve(self, master: int) -> None:
        """Send lines or answer requests until unplugged."""
        next_line = time.monotonic()
        while not self._unplugged.is_set():
            try:
                if self._lines:
                    self._unplugged.wait(max(next_line - time.monotonic(), 0))
                    # What a device had no time to send it does not send later at once.
                    next_line = max(next_line, time.monotonic()) + LINE_PERIOD_S
                    self._send(master, format_line(self.tic.state()) * self.copies)
                elif select.select([master], [], [], LINE_PERIOD_S)[0]:
                    self._answer(master, os.read(master, 64))
            except OSError:  # the other end is not open, or the buffer is full
                self._unplugged.wait(LINE_PERIOD_S)
        os.close(master)

    def _answer(self, master: int, data: bytes) -> None:
        """Answer the complete requests in the bytes received so far."""
        self._request += data
        while len(self._request) >= REQUEST_BYTES:
            start, number, command, offset, length = self._request[:REQUEST_BYTES]
            if (start, number, command) != (POLOLU_START_BYTE, self._device_number, GET_VARIABLE):
                self._request = self._request[1:]  # look for the start of the next request
                continue
            self._request = self._request[REQUEST_BYTES:]
            self._send(master, self.tic.variables()[offset:offset + length])

    def _send(self, master: int, data: bytes) -> None:
        """Send bytes, with the loss and the delay that are set."""
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
