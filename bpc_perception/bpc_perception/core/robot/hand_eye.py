"""The pose of the camera on its mount."""

from __future__ import annotations

from dataclasses import dataclass

from bpc_perception.core.arrays import Array


@dataclass(frozen=True)
class HandEye:
    """Where the camera is mounted.

    Attributes:
        on_base: True = fixed beside the robot (eye on base), False = on its flange (in hand).
        T_parent_camera: (4, 4) pose of the camera's optical frame in the base or flange frame.
    """

    on_base: bool
    T_parent_camera: Array
