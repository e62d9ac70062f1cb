"""Let a command that looks after nodes never wait for whoever reads its output.

A terminal may be held (Ctrl-S) or frozen, a pipe may be full or closed, a disk full. One thread
writes, from a bounded queue. What finds no room in it, or cannot be written, is dropped and
counted, by whole lines.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, ExitStack, suppress
import io
import os
import select
import sys
from threading import Condition, Thread

MOST_WAITING_BYTES = 1 << 20
LAST_WORDS_PATIENCE_S = 1.0  # at the end, in which somebody has to take something
STDERR = 2


class PatientStream(io.TextIOBase):
    """A stream that takes text at once, and writes it as soon as its descriptor takes it.

    Attributes:
        lost: the number of lines that were dropped.
    """

    def __init__(self, handle: int, encoding: str) -> None:
        self._handle = handle
        self._encoding = encoding
        self._text = ''  # neither flushed nor a whole line yet
        self._waiting: deque[bytes] = deque()
        self._size = 0  # of what is waiting
        self._changed = Condition()
        self._ended = self._torn = False
        self.lost = 0
        Thread(target=self._run, daemon=True).start()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """As that of the stream in whose place it is."""
        return self._encoding

    def writable(self) -> bool:
        """Return True."""
        return True

    def isatty(self) -> bool:
        """Return whether it is a terminal that takes the text."""
        return os.isatty(self._handle)

    def fileno(self) -> int:
        """Return the descriptor that takes the text."""
        return self._handle

    def write(self, text: str) -> int:
        """Take text; whole lines are written without a flush."""
        with self._changed:
            whole, line_end, self._text = (self._text + text).rpartition('\n')
            self._queue(whole + line_end)
        return len(text)

    def flush(self) -> None:
        """Let all text be written."""
        with self._changed:
            text, self._text = self._text, ''
            self._queue(text)

    def finish(self) -> None:
        """Wait until all is written, as long as somebody takes something; then write no more."""
        self.flush()
        with self._changed:
            while self._waiting and self._changed.wait(LAST_WORDS_PATIENCE_S):
                pass
            self._ended = True
            self._changed.notify_all()

    def _queue(self, text: str) -> None:
        data = text.encode(self._encoding, 'backslashreplace')
        if self._size + len(data) > MOST_WAITING_BYTES:
            self.lost += text.count('\n')
        elif data:
            self._waiting.append(data)
            self._size += len(data)
            self._changed.notify_all()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._ended)
                if self._ended:
                    return
                data = self._waiting[0]
            self._write(data)
            with self._changed:
                self._waiting.popleft()
                self._size -= len(data)
                self._changed.notify_all()

    def _write(self, data: bytes) -> None:
        left = b'\n' + data if self._torn else data
        while left:
            try:
                left = left[os.write(self._handle, left):]
            except BlockingIOError:  # somebody who has it too has set it so
                with suppress(OSError, ValueError):
                    select.select([], [self._handle], [], LAST_WORDS_PATIENCE_S)
            except OSError:
                self.lost += data.count(b'\n')
                self._torn = left != data
                return
        self._torn = False


@contextmanager
def patient_output() -> Iterator[None]:
    """Let stdout and stderr be patient during the block, for libraries in C++ as well."""
    before = sys.stdout, sys.stderr
    try:
        handles = [stream.fileno() for stream in before]
    except (AttributeError, OSError, ValueError):  # no stream, or one without a descriptor
        yield
        return
    with ExitStack() as at_end:
        own_stderr = os.dup(handles[1])
        streams = [PatientStream(handle, stream.encoding)
                   for handle, stream in zip((handles[0], own_stderr), before, strict=True)]
        for stream in before:
            with suppress(OSError):
                stream.flush()
        sys.stdout, sys.stderr = streams
        try:
            if handles[1] == STDERR:
                at_end.enter_context(_relayed(own_stderr, streams[1]))
            yield
        finally:
            at_end.close()
            sys.stdout, sys.stderr = before
            streams[0].finish()
            if streams[0].lost or streams[1].lost:
                streams[1].write(f'bpc: {streams[0].lost + streams[1].lost} lines of output are '
                                 'lost: nobody took them\n')
            streams[1].finish()


@contextmanager
def _relayed(own_stderr: int, stream: PatientStream) -> Iterator[None]:
    """Hand what anybody writes to the descriptor of stderr to a stream, during the block."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)  # who writes it may have the interpreter's lock
    os.dup2(writing, STDERR)
    os.close(writing)

    def relay() -> None:
        with open(reading, encoding=stream.encoding, errors='replace') as lines:
            for line in lines:
                stream.write(line)

    thread = Thread(target=relay, daemon=True)
    thread.start()
    try:
        yield
    finally:
        os.dup2(own_stderr, STDERR)  # this closes the pipe
        thread.join(LAST_WORDS_PATIENCE_S)
