"""ROS graphs whose nodes are processes, with the test as a listener among them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os

from bpc_perception.testing import free_domain


@contextmanager
def own_domain() -> Iterator[int]:
    """A ROS domain id that no other test has, which processes started meanwhile inherit."""
    before = os.environ.get('ROS_DOMAIN_ID')
    with free_domain() as domain:
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        try:
            yield domain
        finally:
            del os.environ['ROS_DOMAIN_ID']
            if before is not None:
                os.environ['ROS_DOMAIN_ID'] = before
