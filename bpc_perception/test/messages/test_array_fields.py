"""Large arrays in messages: the right bytes, in both modes of the generated setters."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

pytest.importorskip('rclpy')
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2

from bpc_perception.messages import array_fields

pytestmark = pytest.mark.ros
VALUES = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
SCRIPT = """
import numpy as np
from bpc_perception.messages import array_fields
from sensor_msgs.msg import Image
message = Image()
values = np.arange(1000, dtype=np.uint16)
array_fields.set_data(message, values)
assert array_fields._setter() is array_fields._shared
assert np.shares_memory(np.asarray(message.data), values)
"""


@pytest.mark.parametrize('way', [array_fields._shared, array_fields._copied])
def test_what_arrives_are_the_bytes_of_the_array(way: object, monkeypatch: pytest.MonkeyPatch
                                                 ) -> None:
    monkeypatch.setattr(array_fields, '_setter', lambda: way)
    message = PointCloud2(width=3)
    array_fields.set_data(message, VALUES)
    arrived = deserialize_message(serialize_message(message), PointCloud2)
    assert bytes(arrived.data) == VALUES.tobytes()
    assert arrived.width == 3


def test_where_sharing_gives_other_bytes_they_are_copied(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(array_fields, '_shared', lambda *_: None)
    assert array_fields._setter.__wrapped__() is array_fields._copied


@pytest.mark.parametrize('checks', ['0', '1'])
def test_nothing_is_copied_here(checks: str) -> None:
    subprocess.run([sys.executable, '-c', SCRIPT], check=True, timeout=60,
                   env={**os.environ, 'ROS_PYTHON_CHECK_FIELDS': checks})
