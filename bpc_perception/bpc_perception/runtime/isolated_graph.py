"""What the tests of all packages share: ROS graphs that do not hear one another.

ROS is imported late, since tests of the core do without.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
import random
import socket
import time
from typing import Any

DOMAIN_IDS = range(1, 102)
LOCK_PORT = 21000


@contextmanager
def free_domain() -> Iterator[int]:
    """A ROS domain id that no other test on this machine has, now."""
    candidates = list(DOMAIN_IDS)
    random.Random(os.getpid()).shuffle(candidates)
    for domain in candidates:
        lock = socket.socket()
        try:
            lock.bind(('127.0.0.1', LOCK_PORT + domain))
        except OSError:
            lock.close()
            continue
        with lock:
            yield domain
        return
    raise RuntimeError('expected a free ROS domain id, found all taken')


class Graph:
    """Nodes of one test in a context and executor of their own."""

    def __init__(self, domain: int) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.executor = SingleThreadedExecutor(context=self.context)
        self._nodes: list[Any] = []

    def make(self, kind: Callable[..., Any], *args: Any, **parameters: Any) -> Any:
        """A node; keywords are parameter overrides, with __ for the dot in their names."""
        from rclpy.parameter import Parameter

        overrides = [Parameter(name.replace('__', '.'), value=value)
                     for name, value in parameters.items()]
        node = kind(*args, context=self.context, parameter_overrides=overrides)
        self._nodes.append(node)
        self.executor.add_node(node)
        return node

    def spin_until(self, condition: Callable[[], Any], timeout: float = 10.0) -> None:
        """Spin until the condition holds; fails the test when it does not in time."""
        end = time.monotonic() + timeout
        while not condition():
            left = end - time.monotonic()
            assert left > 0, 'timed out waiting for the condition'
            self.executor.spin_once(timeout_sec=min(left, 0.05))

    def close(self) -> None:
        """End all nodes."""
        self.executor.shutdown()
        for node in self._nodes:
            node.destroy_node()
        self.context.try_shutdown()
