"""ROS graphs that do not hear one another, for tests of all packages and benchmarks.

ROS is imported late, since tests of the core need none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import gc
import os
import random
import socket
import time
from typing import Any

DOMAIN_IDS = range(1, 102)
FIRST_LOCK_PORT = 21000  # with the domain id added; who has the port bound has the domain


@contextmanager
def free_domain() -> Iterator[int]:
    """Yield a ROS domain id that no other test on this machine has meanwhile."""
    candidates = list(DOMAIN_IDS)
    random.Random(os.getpid()).shuffle(candidates)
    for domain in candidates:
        lock = socket.socket()
        try:
            lock.bind(('127.0.0.1', FIRST_LOCK_PORT + domain))
        except OSError:
            lock.close()
            continue
        with lock:
            yield domain
        return
    raise RuntimeError('expected a free ROS domain id, found all taken')


class Graph:
    """Nodes of one test, with their own context and executor, which may be of another kind."""

    def __init__(self, domain: int, executor: Callable[..., Any] | None = None) -> None:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.executor = (executor or SingleThreadedExecutor)(context=self.context)
        self._nodes: list[Any] = []
        self._half_made = False  # whether a node refused to be made

    def make(self, kind: Callable[..., Any], *args: Any, **parameters: Any) -> Any:
        """Make a node; keywords are parameter overrides, with __ for the dot in their names."""
        from rclpy.parameter import Parameter

        overrides = [Parameter(name.replace('__', '.'), value=value)
                     for name, value in parameters.items()]
        try:
            node = kind(*args, context=self.context, parameter_overrides=overrides)
        except BaseException:
            self._half_made = True
            raise
        self._nodes.append(node)
        self.executor.add_node(node)
        return node

    def spin_until(self, condition: Callable[[], Any], timeout: float = 10.0) -> None:
        """Spin until the condition holds; fail the test after ``timeout`` [s]."""
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
        if self._half_made:  # or else it stays in the graph until somebody happens to collect
            gc.collect()
