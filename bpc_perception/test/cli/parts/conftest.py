"""A small result, and a terminal to write to."""

import io

import numpy as np
from perception_builders import profile_of
import pytest

from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.profile import Status

MM = 1e-3


@pytest.fixture
def profile():
    return profile_of([2 * MM, 0.0, np.nan, 3 * MM],
                      [Status.MEASURED, Status.GAP, Status.NO_DATA, Status.MEASURED])


@pytest.fixture
def advice():
    return RateAdvice(0, 'print', True, Reason.OVER_EXTRUSION, 2 * MM, 3 * MM, (0.0, 3 * MM), 2,
                      0.7, 1.4, 0.5, 1.0, 5 * 10**9)


class Screen(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def screen(monkeypatch):
    """A terminal to write to, whatever the tests are started with."""
    for name in ('NO_COLOR', 'FORCE_COLOR', 'COLORTERM'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('TERM', 'xterm-256color')
    return Screen()
