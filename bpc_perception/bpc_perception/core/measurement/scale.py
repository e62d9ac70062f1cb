"""The length of path over which surface and light are taken as steady."""

from __future__ import annotations

STEADY_LENGTH_M = 0.008
SECTIONS_ASKED = 10  # within that length, of what is steady


def steady_window(spacing: float) -> int:
    """Return how many path points, an odd number, lie within the steady length.

    Args:
        spacing: distance between path points [m].
    """
    return 2 * round(STEADY_LENGTH_M / 2 / spacing) + 1


def steady_step(spacing: float) -> int:
    """Return from one path point to which next what is steady is looked at.

    Args:
        spacing: distance between path points [m].
    """
    return max(1, round(STEADY_LENGTH_M / SECTIONS_ASKED / spacing))
