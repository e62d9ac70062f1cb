"""What the tests of messages share."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from perception_builders import START_NS
import pytest

from bpc_perception.messages.stamps import ConversionError

NAN = np.nan
refused = pytest.raises(ConversionError, match=r'expected .*found')
STAMP_NS = START_NS + 123_456_789


def assert_same(found: Any, expected: Any) -> None:
    """Check that two dataclasses hold the same values, and arrays of the same type."""
    assert type(found) is type(expected)
    for field in fields(expected):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        if isinstance(other, np.ndarray):
            assert one.dtype == other.dtype, field.name
            np.testing.assert_array_equal(one, other, err_msg=field.name)
        else:
            assert one == other or (one != one and other != other), field.name
