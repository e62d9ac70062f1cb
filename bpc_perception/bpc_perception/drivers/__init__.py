"""Camera back ends: one module each, imported only when chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Protocol

from rclpy.node import Node

from bpc_perception.core.capture import Capture

# A module of a back end has a function ``prepare(node)`` that declares the parameters it needs
# and returns what opens its Camera, as often as it is called.
BACK_ENDS = {'bag': 'bpc_perception.drivers.bag', 'synthetic': 'bpc_sim.synthetic_camera',
             'zivid': 'bpc_perception.drivers.zivid'}


WARN = 'WARN'


class CameraError(RuntimeError):
    """The camera cannot deliver; the message says why."""


class Camera(Protocol):
    """A source of captures."""

    def connect(self) -> None:
        """Make sure that the device is there. Raises CameraError when it is not, yet."""

    def due(self, now_ns: int) -> bool:
        """Whether it has a capture to deliver of its own accord, as a recording does."""

    def capture(self, now_ns: int) -> Capture:
        """Take a capture. Raises CameraError when there is none."""

    def notes(self) -> Mapping[str, object]:
        """What is worth knowing of the device, for the diagnostics; a key WARN warns."""

    def close(self) -> None:
        """Let go of the device."""


def prepare_camera(name: str, node: Node) -> Callable[[], Camera]:
    """What opens the camera of a back end.

    Raises ValueError when the back end is unknown or not installed; opening it may, too.
    """
    if name not in BACK_ENDS:
        raise ValueError(f'back_end: expected one of {", ".join(BACK_ENDS)}, found "{name}"')
    try:
        module = import_module(BACK_ENDS[name])
    except ImportError as error:
        raise ValueError(f'back_end: expected {name} to be installed, found: {error}') from error
    opener: Callable[[], Camera] = module.prepare(node)
    return opener
