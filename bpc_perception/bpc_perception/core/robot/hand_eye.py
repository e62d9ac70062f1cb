"""The pose of the camera on its mount."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert
from bpc_perception.core.robot.poses import PoseBuffer

MOUNTS = {'eye_on_base': True, 'eye_in_hand': False}  # name to whether it is on the base


def mount_name(on_base: bool) -> str:
    """Return the name of a mount."""
    return next(name for name, base in MOUNTS.items() if base == on_base)


@dataclass(frozen=True)
class HandEye:
    """Where the camera is mounted.

    Attributes:
        on_base: True = fixed beside the robot (eye on base), False = on its flange (in hand).
        T_parent_camera: (4, 4) pose of the camera's optical frame in the base or flange frame.
        parent_frame, camera_frame: their names where it was calibrated; empty = not stated.
    """

    on_base: bool
    T_parent_camera: Array
    parent_frame: str = ''
    camera_frame: str = ''

    def moved(self, shift: Array, T_base_camera: Array) -> HandEye:
        """Return it with the camera moved by a shift (3,) in the base frame [m].

        Of a camera in the hand that holds for the flange's orientation at a pose (4, 4) of it.
        """
        there = T_base_camera.copy()
        there[:3, 3] += shift
        T_parent_base = self.T_parent_camera @ invert(T_base_camera)
        return replace(self, T_parent_camera=T_parent_base @ there)

    def contradiction(self, base_frame: str, camera_frame: str) -> str:
        """Return a warning if these frames have other names than in the calibration; empty = not.

        Only the numbers count. But other names may mean that they are of another camera or cell.
        """
        named = [('camera', self.camera_frame, camera_frame)]
        if self.on_base:
            named.append(('base', self.parent_frame, base_frame))
        others = [f'the {body} frame {found} instead of {expected}'
                  for body, found, expected in named
                  if found and expected and found.strip('/') != expected.strip('/')]
        if not others:
            return ''
        return (f'hand-eye calibration: expected one of this camera, found {" and ".join(others)};'
                ' is it the right file?')

    def camera_pose(self, poses: PoseBuffer, stamp_ns: int, maximum_gap: float) -> Array | None:
        """Return T_base_camera (4, 4) [m] at a time [ns]; None = the flange's pose is not known.

        Args:
            poses: of the flange.
            stamp_ns: the time.
            maximum_gap: between the poses around it, see PoseBuffer.at [s].
        """
        if self.on_base:
            return self.T_parent_camera
        T_base_flange = poses.at(stamp_ns, maximum_gap)
        return None if T_base_flange is None else T_base_flange @ self.T_parent_camera
