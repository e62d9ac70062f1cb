"""Stamps to nanoseconds and back."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from message_builders import STAMP_NS
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image

from bpc_perception.messages.stamps import ns_to_stamp, stamp_in, stamp_to_ns

pytestmark = pytest.mark.ros


@pytest.mark.parametrize('stamp_ns', [
    0, 1, 999_999_999, 10**9, STAMP_NS, (2**31 - 1) * 10**9 + 999_999_999, -1, -(10**9) - 1])
def test_a_stamp_survives_to_the_nanosecond(stamp_ns: int) -> None:
    stamp = ns_to_stamp(stamp_ns)
    assert 0 <= stamp.nanosec < 10**9
    assert stamp_to_ns(stamp) == stamp_ns


def test_a_stamp_is_seconds_and_nanoseconds() -> None:
    assert stamp_to_ns(Time(sec=3, nanosec=7)) == 3_000_000_007


@pytest.mark.parametrize('stamp_ns', [0, 1, 1_795_938_816_668_582_995, (2**31 - 1) * 10**9])
def test_the_stamp_is_found_without_unpacking_the_message(stamp_ns: int) -> None:
    message = Image(data=[1, 2, 3])
    message.header.stamp = ns_to_stamp(stamp_ns)
    message.header.frame_id = 'camera'
    assert stamp_in(serialize_message(message)) == stamp_ns
