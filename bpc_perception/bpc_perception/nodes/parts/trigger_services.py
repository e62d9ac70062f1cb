"""Call services of other nodes on request of another thread."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

Outcome = tuple[bool, str]  # success and message


class TriggerServices:
    """Clients of Trigger services. Requests come from any thread, calls are made in the node's.

    Args:
        node: the node that calls.
        services: name of each request to the name of its service.
    """

    def __init__(self, node: Node, services: Mapping[str, str]) -> None:
        self._clients = {name: node.create_client(Trigger, service)
                         for name, service in services.items()}
        self._requests: deque[tuple[str, Future[Outcome]]] = deque()
        self._requested = node.create_guard_condition(self._call_requested)

    def request(self, name: str) -> Future[Outcome]:
        """Request a call; return its outcome."""
        outcome: Future[Outcome] = Future()
        self._requests.append((name, outcome))
        self._requested.trigger()
        return outcome

    def _call_requested(self) -> None:
        while self._requests:
            self._call(*self._requests.popleft())

    def _call(self, name: str, outcome: Future[Outcome]) -> None:
        client = self._clients[name]
        if not client.service_is_ready():
            outcome.set_result((False, f'nobody offers {client.srv_name}'))
            return
        client.call_async(Trigger.Request()).add_done_callback(partial(_pass_on, outcome))


def _pass_on(outcome: Future[Outcome], answered: Any) -> None:
    answer = answered.result()
    if not outcome.cancelled():
        outcome.set_result((answer.success, answer.message or 'done'))
