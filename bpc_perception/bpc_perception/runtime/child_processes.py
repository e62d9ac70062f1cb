"""Nodes started as processes, and ended again whatever happens."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import time
from types import TracebackType
from typing import Any

import yaml

from bpc_perception.runtime.process import HEARTBEAT_VARIABLE, PARENT_VARIABLE
from bpc_perception.runtime.transport import shared_memory
from bpc_perception.runtime.transport.dds_profiles import with_profile

END_PATIENCE = 1.5  # for all nodes together [s]
KILL_PATIENCE = 1.0  # for one that is killed; who waits in the kernel for a device stays [s]
# The shared memory is taken at the start, by each process that is given the file.
FRAME_PUBLISHERS = ('camera_driver', 'composed')


class NodeError(ValueError):
    """A node ended that should not have; the message has its last words."""


class Nodes:
    """Processes of nodes; a context manager that ends all of them in reverse order."""

    def __init__(self, parameter_file: Path | None = None,
                 parameters: Mapping[str, Any] | None = None,
                 remappings: Mapping[str, str] | None = None) -> None:
        self._common = [parameter_file] if parameter_file else []
        self._remappings = dict(remappings or {})
        self._parameters = dict(parameters or {})
        self._logs = Path(os.environ.get('ROS_LOG_DIR') or tempfile.gettempdir())
        self._logs.mkdir(parents=True, exist_ok=True)
        self._started: dict[str, tuple[str, dict[str, Any]]] = {}
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._log_files: dict[str, Path] = {}
        self._pipes: dict[str, int] = {}
        self._starts: dict[str, float] = {}  # [s], steady
        self._beats: dict[str, dict[bytes, float]] = {}  # of each node of a process the last

    def start(self, module: str, **parameters: Any) -> None:
        """Run ``python -m module`` with these parameters, which win over those common to all."""
        name = module.rpartition('.')[2]
        # What they say goes into a log of ours, which is removed where all went well.
        arguments = ['--ros-args', '--disable-external-lib-logs']
        for file in self._common:
            arguments += ['--params-file', str(file)]
        for key, value in {**self._parameters, **parameters}.items():
            arguments += ['-p', f'{key}:={yaml.safe_dump(value).splitlines()[0]}']
        for topic, other in self._remappings.items():
            arguments += ['-r', f'{topic}:={other}']
        handle, log = tempfile.mkstemp(prefix=f'{name}-', suffix='.log', dir=self._logs)
        signs, pipe = os.pipe()
        os.set_blocking(signs, False)
        environment = with_profile(os.environ, captures=name in FRAME_PUBLISHERS) | {
            PARENT_VARIABLE: str(os.getpid()), HEARTBEAT_VARIABLE: str(pipe)}
        self._close_pipe(name)
        self._started[name], self._log_files[name] = (module, parameters), Path(log)
        self._pipes[name], self._beats[name] = signs, {}
        self._starts[name] = time.monotonic()
        # A session of its own: Ctrl-C reaches us alone, and we end the nodes in order.
        self._processes[name] = subprocess.Popen(
            [sys.executable, '-m', module, *arguments], stdin=subprocess.DEVNULL, stdout=handle,
            stderr=handle, start_new_session=True, env=environment, pass_fds=(pipe,))
        os.close(handle)
        os.close(pipe)

    def start_again(self, name: str) -> None:
        """Run a node that has ended once more, as it was; the log of the one before stays."""
        module, parameters = self._started[name]
        self.start(module, **parameters)

    def start_measuring(self, camera: Mapping[str, Any], thickness: Mapping[str, Any],
                        separate: bool) -> None:
        """Start camera driver and thickness node: in one process, or in one each."""
        if separate:
            self.start('bpc_perception.nodes.thickness', **thickness)
            self.start('bpc_perception.nodes.camera_driver', **camera)
        else:
            self.start('bpc_perception.nodes.composed', **camera, **thickness)

    def check(self, *may_end: str) -> None:
        """Raise NodeError if a node has ended, unless it is one that may and went well."""
        for name in self._processes:
            status = self.status(name)
            if status is not None and not (status == 0 and name in may_end):
                raise NodeError(f'{name}: expected it to run, found it {self.end_of(name)}')

    @property
    def names(self) -> list[str]:
        """Of all processes, in the order of their start."""
        return list(self._processes)

    def pid(self, name: str) -> int:
        """The process id of this node."""
        return self._processes[name].pid

    def status(self, name: str) -> int | None:
        """The exit status of this node; None = it runs."""
        return self._processes[name].poll()

    def ended(self, name: str) -> bool:
        """Whether this node has ended."""
        return self.status(name) is not None

    def end_of(self, name: str) -> str:
        """How a node ended, with its last words."""
        words = self._log_files[name].read_text(errors='replace').strip().splitlines()
        return f'ended with status {self.status(name)}: {words[-1] if words else "no output"}'

    def silence(self, name: str) -> tuple[float, bool]:
        """Time since the last sign of life of a process, or of the quietest node in it [s].

        Before the first, since the start; and whether there was one.
        """
        beats, now = self._beats[name], time.monotonic()
        with suppress(BlockingIOError):
            while signs := os.read(self._pipes[name], 65536):
                beats.update(dict.fromkeys(signs.split(), now))
        return now - min(beats.values(), default=self._starts[name]), bool(beats)

    def kill(self, name: str) -> None:
        """End a node the hard way."""
        _kill(self._processes[name])

    def __enter__(self) -> Nodes:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        used: set[str] = set()
        for process in self._processes.values():
            if process.poll() is None:
                used |= shared_memory.used_by(process.pid)
                process.terminate()  # unlike SIGINT also silent while it still loads
        end = time.monotonic() + END_PATIENCE
        for name, process in reversed(self._processes.items()):
            try:
                process.wait(max(end - time.monotonic(), 0.0))
            except subprocess.TimeoutExpired:
                used |= shared_memory.used_by(process.pid)
                _kill(process)
            self._close_pipe(name)
        # Who is killed leaves its own; who end together may each leave a port to the other.
        shared_memory.clean(settled=0.0, among=used)
        if error is None or kind is KeyboardInterrupt:
            for log in self._log_files.values():
                log.unlink(missing_ok=True)

    def _close_pipe(self, name: str) -> None:
        if name in self._pipes:
            os.close(self._pipes.pop(name))


def _kill(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    with suppress(subprocess.TimeoutExpired):
        process.wait(KILL_PATIENCE)
