"""Finds out whether there is a sourced ROS 2 Jazzy that this Python can use."""

from collections.abc import Mapping
import importlib.util
from pathlib import Path
import sys
import sysconfig

from bootstrap.progress import SetupError


def sourced_rclpy(root: Path) -> Path | None:
    """Return the folder of an rclpy that this Python can load, outside our own environments."""
    spec = importlib.util.find_spec('rclpy')
    if spec is None or spec.origin is None:
        return None
    folder = Path(spec.origin).parent
    extension = folder / f'_rclpy_pybind11{sysconfig.get_config_var("EXT_SUFFIX")}'
    return folder if extension.exists() and root not in folder.parents else None


def stock_rclpy(environment: Mapping[str, str], root: Path) -> Path | None:
    """Return the rclpy of a sourced stock Jazzy, or None if the wheels are needed.

    Raises:
        SetupError: another distribution is sourced, or Jazzy with another Python.
    """
    distribution = environment.get('ROS_DISTRO')
    if not distribution:
        return None
    if distribution != 'jazzy':
        raise SetupError(
            f'needs ROS 2 jazzy, found {distribution} sourced (ROS_DISTRO); '
            'use a shell without it, or source jazzy'
        )
    rclpy = sourced_rclpy(root)
    if rclpy and sys.version_info[:2] != (3, 12):
        raise SetupError(
            f'needs ROS 2 jazzy on Python 3.12, as on Ubuntu 24.04, found {rclpy} sourced; '
            'in a shell without it, ./bpc brings its own'
        )
    return rclpy
