"""Settings in the words of those who print."""

from __future__ import annotations

from collections.abc import Iterable

from bpc_perception.core.window.sweep import Drive

UNITS = {Drive.FLOW: (1e9, 'mm³/s'), Drive.PRESSURE: (1e-3, 'kPa')}
MM = 1e-3
KELVIN = 273.15
MOST_NAMED = 9


def driven(drive: Drive, value: float) -> str:
    """Return a flow [m^3/s] or a pressure [Pa] with its unit."""
    factor, unit = UNITS[drive]
    return f'{value * factor:.3g} {unit}'


def moved(speed: float) -> str:
    """Return a speed [m/s] with its unit."""
    return f'{speed / MM:.3g} mm/s'


def wide(width: float) -> str:
    """Return a width [m] with its unit."""
    return f'{width / MM:.3f} mm'


def at(drive: Drive, value: float, speed: float) -> str:
    """Return a setting: flow [m^3/s] or pressure [Pa], and speed [m/s]."""
    return f'{driven(drive, value)} with {moved(speed)}'


def several(names: Iterable[str]) -> str:
    """Return names as a list for people, no longer than can be read."""
    names = list(names)
    more = len(names) - MOST_NAMED
    return ', '.join(names[:MOST_NAMED]) + (f' and {more} more' if more > 0 else '')
