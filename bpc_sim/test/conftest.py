"""Fixtures of the tests of nodes."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from bpc_perception.runtime.isolated_graph import free_domain, Graph


@pytest.fixture
def graph() -> Iterator[Graph]:
    """A new, empty ROS graph."""
    with free_domain() as domain:
        made = Graph(domain)
        yield made
        made.close()
