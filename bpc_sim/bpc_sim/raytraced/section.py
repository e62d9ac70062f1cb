"""Cross-sections of beads: closed outlines whose extent along the bed is the width."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array

OUTLINE_POINTS = 49  # from foot to foot
SUNK_M = 5e-5  # that an outline goes on into what it lies on, so that no light comes through


@dataclass(frozen=True)
class Section:
    """A bead's section, in widths.

    Attributes:
        x, z: (K,) outline from the left foot over the ridge to the right foot; the largest extent
            along x is 1, the feet are at z = 0.
    """

    x: Array
    z: Array

    @property
    def height(self) -> float:
        """Height of the ridge, in widths."""
        return float(self.z.max())


def cap(contact_angle: float) -> Section:
    """Return a circular arc that meets the bed at an angle [rad].

    Beyond a right angle it overhangs its feet.
    """
    reach = np.linspace(contact_angle, -contact_angle, OUTLINE_POINTS)
    extent = 2 * np.sin(min(contact_angle, np.pi / 2))
    return Section(-np.sin(reach) / extent, (np.cos(reach) - np.cos(contact_angle)) / extent)


def superellipse(height: float, exponent: float) -> Section:
    """Return the upper half of |2 x|^n + |z / height|^n = 1."""
    angle = np.linspace(np.pi, 0.0, OUTLINE_POINTS)
    cos, sin = np.cos(angle), np.sin(angle).clip(0)
    return Section(np.sign(cos) * np.abs(cos)**(2 / exponent) / 2,
                   height * sin**(2 / exponent))
