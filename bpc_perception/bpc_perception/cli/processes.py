"""Nodes started as processes, and ended again whatever happens."""

from __future__ import annotations

from collections.abc import Mapping
import os
from pathlib import Path
import subprocess
import sys
import tempfile
from types import TracebackType
from typing import Any

import yaml

from bpc_perception.nodes.process import PARENT_VARIABLE

END_PATIENCE = 2.0  # [s]
# Read by Fast DDS under the one or the other name; a user's own file wins.
TRANSPORT = str(Path(__file__).parents[1] / 'transport.xml')
TRANSPORT_VARIABLES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
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
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._log_files: dict[str, Path] = {}

    def start(self, module: str, **parameters: Any) -> None:
        """Run ``python -m module`` with these parameters, which win over those common to all."""
        name = module.rpartition('.')[2]
        arguments = ['--ros-args']
        for file in self._common:
            arguments += ['--params-file', str(file)]
        for key, value in {**self._parameters, **parameters}.items():
            arguments += ['-p', f'{key}:={yaml.safe_dump(value).splitlines()[0]}']
        for topic, other in self._remappings.items():
            arguments += ['-r', f'{topic}:={other}']
        handle, log = tempfile.mkstemp(prefix=f'{name}-', suffix='.log', dir=self._logs)
        self._log_files[name] = Path(log)
        environment = os.environ | {PARENT_VARIABLE: str(os.getpid())}
        if name in FRAME_PUBLISHERS:
            environment = dict.fromkeys(TRANSPORT_VARIABLES, TRANSPORT) | environment
        # A session of its own: Ctrl-C reaches us alone, and we end the nodes in order.
        self._processes[name] = subprocess.Popen(
            [sys.executable, '-m', module, *arguments], stdin=subprocess.DEVNULL,
            stdout=handle, stderr=handle, start_new_session=True, env=environment)
        os.close(handle)

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
        for name, process in self._processes.items():
            status = process.poll()
            if status is not None and not (status == 0 and name in may_end):
                words = self._log_files[name].read_text(errors='replace').strip().splitlines()
                raise NodeError(f'{name}: expected it to run, found it ended with status '
                                f'{status}: {words[-1] if words else "no output"}')

    def pid(self, name: str) -> int:
        """The process id of this node."""
        return self._processes[name].pid

    def ended(self, name: str) -> bool:
        """Whether this node has ended."""
        return self._processes[name].poll() is not None

    def __enter__(self) -> Nodes:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        for process in self._processes.values():
            if process.poll() is None:
                process.terminate()  # unlike SIGINT also silent while it still loads
        for process in reversed(self._processes.values()):
            try:
                process.wait(END_PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if error is None:
            for log in self._log_files.values():
                log.unlink(missing_ok=True)
