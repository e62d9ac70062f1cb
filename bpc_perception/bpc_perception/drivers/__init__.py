"""Camera back ends: one module each, imported only when chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from typing import Protocol

from rclpy.node import Node

from bpc_perception.core.capture.capture import Capture

# Entry points of this group are the back ends, in whatever package they are: a function
# ``prepare(node)`` that declares the parameters it needs and returns what opens its Camera, as
# often as it is called.
GROUP = 'bpc.cameras'
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


def back_ends() -> list[str]:
    """The names of all back ends that are installed."""
    return sorted(entry_points(group=GROUP).names)


def check_back_end(name: str) -> None:
    """Raise ValueError unless a back end of this name is installed."""
    if name not in back_ends():
        raise ValueError(f'back_end: expected one of {", ".join(back_ends())}, found {name!r}')


def prepare_camera(name: str, node: Node) -> Callable[[], Camera]:
    """What opens the camera of a back end.

    Raises ValueError when the back end is unknown or not installed; opening it may, too.
    """
    check_back_end(name)
    entry, = {entry for entry in entry_points(group=GROUP) if entry.name == name}
    try:
        prepare = entry.load()
    except ImportError as error:
        raise ValueError(f'back_end: expected {name} to be installed, found: {error}') from error
    opener: Callable[[], Camera] = prepare(node)
    return opener
