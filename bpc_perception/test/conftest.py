"""Fixtures shared by the tests of this package."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
import sys

import pytest

from bpc_perception.runtime.isolated_graph import free_domain, Graph

# Both are read when the first message, or the first node, is made.
os.environ['ROS_PYTHON_CHECK_FIELDS'] = '1'
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
# pytest's importlib mode leaves the folder out: perception_builders.py is beside the tests.
sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def ros_domain() -> Iterator[int]:
    """A ROS domain id of this test's own."""
    with free_domain() as domain:
        yield domain


@pytest.fixture
def graph(ros_domain: int) -> Iterator[Graph]:
    """An empty ROS graph of its own."""
    made = Graph(ros_domain)
    yield made
    made.close()
