"""Camera back ends: one module each, imported only when chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from typing import Protocol

from rclpy.node import Node

from bpc_perception.core.capture.capture import Capture

# The back ends are the entry points of this group, in any package. Each is a function
# ``prepare(node)``: it declares the parameters that the back end needs and returns a function that
# opens a Camera, each time it is called.
ENTRY_POINT_GROUP = 'bpc.cameras'
WARN = 'WARN'  # key of a note that is a warning


class CameraError(RuntimeError):
    """The camera cannot deliver a capture; the message says why."""


class Camera(Protocol):
    """A source of captures."""

    def connect(self) -> None:
        """Make sure that the device is there. Raises CameraError when it is not there yet."""

    def due(self, now_ns: int) -> bool:
        """Return whether it has a capture to deliver unasked, as a recording does."""

    def capture(self, now_ns: int) -> Capture:
        """Take a capture at ``now_ns`` of the node's clock. Raises CameraError for none."""

    def notes(self) -> Mapping[str, object]:
        """Return what the diagnostics show of the device; the value of a key WARN is a warning."""

    def close(self) -> None:
        """Close the device."""


def back_ends() -> list[str]:
    """Return the names of all installed back ends."""
    return sorted(entry_points(group=ENTRY_POINT_GROUP).names)


def check_back_end(name: str) -> None:
    """Raise ValueError unless a back end of this name is installed."""
    if name not in back_ends():
        raise ValueError(f'back_end: expected one of {", ".join(back_ends())}, found {name!r}')


def prepare_camera(name: str, node: Node) -> Callable[[], Camera]:
    """Return a function that opens the camera of a back end.

    Raises ValueError when the back end is unknown or not installed. Opening may raise it, too.
    """
    check_back_end(name)
    entry, = {entry for entry in entry_points(group=ENTRY_POINT_GROUP) if entry.name == name}
    try:
        prepare = entry.load()
    except ImportError as error:
        raise ValueError(f'back_end: expected {name} to be installed, found: {error}'
                         '; install what is missing') from error
    opener: Callable[[], Camera] = prepare(node)
    return opener
