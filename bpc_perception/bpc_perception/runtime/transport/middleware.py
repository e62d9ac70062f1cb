"""The middleware and the domain that the user asks for, and whether they can be had.

This imports nothing of rclpy: where RMW_IMPLEMENTATION names a middleware that is missing, rcl
ends the process while rclpy is loaded.
"""

from __future__ import annotations

from contextlib import suppress
import os

from ament_index_python import get_resources

MIDDLEWARE_VARIABLE = 'RMW_IMPLEMENTATION'
DOMAIN_VARIABLE = 'ROS_DOMAIN_ID'
DOMAINS = range(233)  # with more, the ports of Fast DDS do not fit into 16 bits

_missing = ''  # the middleware that was asked for, if it is not there


def installed() -> list[str]:
    """Return the names of the middlewares that are there."""
    return sorted(set(get_resources('rmw_typesupport')) - {'rmw_implementation'})


def do_without_missing() -> None:
    """Take the default in place of a missing middleware, for commands that need none."""
    global _missing
    asked = os.environ.get(MIDDLEWARE_VARIABLE)
    with suppress(OSError):  # no ROS in the environment: rclpy is going to say so
        if asked and asked not in installed():
            _missing = os.environ.pop(MIDDLEWARE_VARIABLE)


def expect_middleware() -> None:
    """Raise ValueError if a node could not be started with the middleware and domain asked for."""
    if _missing:
        raise ValueError(f'{MIDDLEWARE_VARIABLE}: expected {" or ".join(installed())}, '
                         f'found {_missing}, which is not installed')
    domain = os.environ.get(DOMAIN_VARIABLE) or '0'
    if not (domain.isdecimal() and int(domain) in DOMAINS):
        raise ValueError(f'{DOMAIN_VARIABLE}: expected a number from 0 to {DOMAINS[-1]}, '
                         f'found {domain!r}')
