"""Start nodes as processes, and end them again whatever happens."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
import logging
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import time
from types import TracebackType
from typing import Any

from bpc_perception.claims import domain
from bpc_perception.runtime.process import HEARTBEAT_VARIABLE, PARENT_VARIABLE
from bpc_perception.runtime.ros_arguments import ros_arguments
from bpc_perception.runtime.transport import shared_memory
from bpc_perception.runtime.transport.dds_profiles import with_profile

END_PATIENCE_S = 1.5  # for all nodes together, unless they write files
KILL_PATIENCE_S = 1.0  # for each; a process that waits in the kernel for a device may not end
# Only these get the profile for captures: a process with it takes the shared memory at its start.
CAPTURE_PUBLISHERS = ('camera_driver', 'composed')
LONGEST_LAST_WORDS_BYTES = 4096

logger = logging.getLogger(__name__)


class NodeError(ValueError):
    """A node ended that should run; the message has its last words."""


class Nodes:
    """Processes of nodes; a context manager that ends all of them in reverse order."""

    def __init__(self, parameter_file: Path | None = None,
                 parameters: Mapping[str, Any] | None = None,
                 remappings: Mapping[str, str] | None = None,
                 end_patience: float = END_PATIENCE_S) -> None:
        """Begin without nodes.

        Args:
            parameter_file: of all nodes; None = none.
            parameters: of all nodes.
            remappings: of topics.
            end_patience: for all nodes together at their end [s].
        """
        self._end_patience = end_patience
        self._parameter_file = parameter_file
        self._remappings = dict(remappings or {})
        self._parameters = dict(parameters or {})
        self._children: dict[str, _Child] = {}  # in the order of their first start

    def start(self, module: str, **parameters: Any) -> None:
        """Run ``python -m module`` with these parameters, which win over those common to all.

        Raises OSError if there can be no other process; then all is as before.
        """
        name = module.rpartition('.')[2]
        handle, log = _open_log(name)
        read_end, write_end = os.pipe()
        os.set_blocking(read_end, False)
        environment = with_profile(os.environ, captures=name in CAPTURE_PUBLISHERS) | {
            PARENT_VARIABLE: str(os.getpid()), HEARTBEAT_VARIABLE: str(write_end)}
        try:
            # The node gets its own session: Ctrl-C reaches only us, and we end the nodes in order.
            process = subprocess.Popen(
                [sys.executable, '-m', module, *ros_arguments(
                    self._parameters | parameters, self._remappings, self._parameter_file)],
                stdin=subprocess.DEVNULL, stdout=handle, stderr=handle, start_new_session=True,
                env=environment, pass_fds=(write_end, *domain.descriptors()))
        except OSError:
            os.close(handle)
            os.close(read_end)
            raise
        finally:
            os.close(write_end)
        if name in self._children:
            self._children[name].close()
        self._children[name] = _Child(module, parameters, process, handle, log, read_end)

    def start_again(self, name: str) -> None:
        """Start an ended node again with the same parameters; its old log stays."""
        child = self._children[name]
        self.start(child.module, **child.parameters)

    def start_measuring(self, camera: Mapping[str, Any], thickness: Mapping[str, Any],
                        separate: bool) -> None:
        """Start camera driver and thickness node: in one process, or in one each."""
        if separate:
            self.start('bpc_perception.nodes.thickness', **thickness)
            self.start('bpc_perception.nodes.camera_driver', **camera)
        else:
            self.start('bpc_perception.nodes.composed', **camera, **thickness)

    def check(self, *may_end: str) -> None:
        """Raise NodeError if a node has ended; those that may end may do so with status 0."""
        for name in self._children:
            status = self.status(name)
            if status is not None and not (status == 0 and name in may_end):
                raise NodeError(f'{name}: expected it to run, found it {self.end_of(name)}')

    @property
    def names(self) -> list[str]:
        """Names of all processes, in the order of their start."""
        return list(self._children)

    def pid(self, name: str) -> int:
        """Return the process id of a node."""
        return self._children[name].process.pid

    def status(self, name: str) -> int | None:
        """Return the exit status of a node; None = it runs."""
        return self._children[name].process.poll()

    def ended(self, name: str) -> bool:
        """Return whether a node has ended."""
        return self.status(name) is not None

    def end_of(self, name: str) -> str:
        """Return how a node ended, with its last words."""
        words = self._children[name].last_words()
        return f'ended with status {self.status(name)}: {words[-1] if words else "no output"}'

    def silence(self, name: str) -> tuple[float, bool]:
        """Return how long a process has given no sign of life [s], and whether it ever gave one.

        Of several nodes in it, the quietest one counts. Before the first sign, the time counts
        from the start.
        """
        return self._children[name].silence()

    def kill(self, name: str) -> None:
        """Kill a node."""
        self._children[name].kill()

    def __enter__(self) -> Nodes:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        used = self._end_all()
        # A killed process leaves its own files; two that end together may each leave a port to the
        # other.
        shared_memory.clean(settled=0.0, among=used)
        if error is None or kind is KeyboardInterrupt:
            for child in self._children.values():
                child.remove_log()
        for child in self._children.values():
            child.close()

    def _end_all(self) -> set[str]:
        """End all processes; return the names of the shared memory that they used."""
        used: set[str] = set()
        for child in self._children.values():
            if child.process.poll() is None:
                used |= shared_memory.used_by(child.process.pid)
                child.process.terminate()  # unlike SIGINT it is silent, even while a node loads
        end = time.monotonic() + self._end_patience
        for child in reversed(self._children.values()):
            try:
                child.process.wait(max(end - time.monotonic(), 0.0))
            except subprocess.TimeoutExpired:
                used |= shared_memory.used_by(child.process.pid)
                child.kill()
        return used


@dataclass
class _Child:
    """A process of one node or more.

    Attributes:
        module, parameters: what was started.
        process: the process.
        output: descriptor of the file with its output.
        log: where that file is; None = in memory alone.
        heartbeat: the pipe from which its signs of life are read; None = closed.
        started: time of its start [s], steady.
        beats: time of the last sign of life of each node in it [s], steady.
    """

    module: str
    parameters: Mapping[str, Any]
    process: subprocess.Popen[bytes]
    output: int
    log: Path | None
    heartbeat: int | None
    started: float = field(default_factory=time.monotonic)
    beats: dict[bytes, float] = field(default_factory=dict)

    def silence(self) -> tuple[float, bool]:
        assert self.heartbeat is not None
        now = time.monotonic()
        with suppress(BlockingIOError):
            while signs := os.read(self.heartbeat, 65536):
                self.beats.update(dict.fromkeys(signs.split(), now))
        return now - min(self.beats.values(), default=self.started), bool(self.beats)

    def kill(self) -> None:
        self.process.kill()
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(KILL_PATIENCE_S)

    def last_words(self) -> list[str]:
        """Return the last lines of its output, even of a file that was removed."""
        size = os.fstat(self.output).st_size
        words = os.pread(self.output, LONGEST_LAST_WORDS_BYTES,
                         max(0, size - LONGEST_LAST_WORDS_BYTES))
        return words.decode(errors='replace').strip().splitlines()

    def remove_log(self) -> None:
        if self.log is not None:
            with suppress(OSError):  # somebody has removed it, or nobody may
                self.log.unlink()

    def close(self) -> None:
        if self.heartbeat is not None:
            os.close(self.heartbeat)
            os.close(self.output)
            self.heartbeat = None


def _open_log(name: str) -> tuple[int, Path | None]:
    """Return a new file for the output of a node, and where it is; None = in memory alone.

    A node has to start also where there is no folder for its log, or no room in it.
    """
    for folder in _log_folders():
        try:
            folder.mkdir(parents=True, exist_ok=True)
            handle, path = tempfile.mkstemp(prefix=f'{name}-', suffix='.log', dir=folder)
        except OSError as error:
            logger.warning('logs: expected to write into %s, found: %s', folder, error.strerror)
        else:
            return handle, Path(path)
    return os.memfd_create(f'{name}.log'), None


def _log_folders() -> Iterator[Path]:
    if folder := os.environ.get('ROS_LOG_DIR'):
        yield Path(folder)
    with suppress(OSError):  # there is none
        yield Path(tempfile.gettempdir())
