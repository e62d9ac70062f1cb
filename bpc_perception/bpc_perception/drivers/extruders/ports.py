"""Serial devices by names that they keep, wherever and in whatever order they are plugged in."""

from __future__ import annotations

import os
from pathlib import Path

from bpc_perception.core.extruder.tic import ExtruderError

# Links that udev makes, named by maker, model and serial number.
BY_ID = Path('/dev/serial/by-id')


def present() -> list[str]:
    """Return the lasting names of the devices that are plugged in."""
    return sorted(map(str, BY_ID.glob('*')))


def named_present() -> str:
    """Return the devices that are plugged in, in words."""
    return f'{BY_ID} has {", ".join(Path(name).name for name in present()) or "no device"}'


def only_device() -> str:
    """Return the name of the only device. Raises ExtruderError if there are others, or none."""
    names = present()
    if len(names) != 1:
        raise ExtruderError('port: expected the name of a serial line, or a single device; '
                            f'{named_present()}')
    return names[0]


def lasting_name(port: str) -> str:
    """Return the name by which a device will be found again; its port if it has no such name."""
    device = os.path.realpath(port)
    return next((name for name in present() if os.path.realpath(name) == device), port)
