"""What a test leaves in its graph, the next test on its domain must not find."""

from __future__ import annotations

import gc
from typing import Any
import weakref

import pytest

pytest.importorskip('rclpy')
from rclpy.node import Node

from bpc_perception.runtime.isolated_graph import Graph

pytestmark = pytest.mark.ros


class HalfMade(Node):
    """A node that refuses to be made when it is in the graph already."""

    made: weakref.ref[Node]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('half_made', **kwargs)
        HalfMade.made = weakref.ref(self)
        self.itself = self  # only the cyclic garbage collector frees it
        raise ValueError('expected to be made, found otherwise')


def test_a_node_that_refused_to_be_made_leaves_with_its_graph(ros_domain: int) -> None:
    gc.disable()
    try:
        graph = Graph(ros_domain)
        with pytest.raises(ValueError, match='expected to be made'):
            graph.make(HalfMade)
        assert HalfMade.made() is not None
        graph.close()
        assert HalfMade.made() is None
    finally:
        gc.enable()
