"""What the tests of nodes share."""

from __future__ import annotations

from collections.abc import Iterator

from bpc_perception.testing import free_domain, Graph
import pytest


@pytest.fixture
def graph() -> Iterator[Graph]:
    """An empty ROS graph of its own."""
    with free_domain() as domain:
        made = Graph(domain)
        yield made
        made.close()
