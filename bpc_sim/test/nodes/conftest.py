"""Fixtures of the tests of camera back ends."""

from __future__ import annotations

import sys

import pytest

from bpc_sim.doubles.zivid import still_scene, ZividDouble
from bpc_sim.printer.scenarios import SCENARIOS


@pytest.fixture
def zivid(monkeypatch: pytest.MonkeyPatch) -> ZividDouble:
    """A fast Zivid camera, and its package."""
    scene = still_scene(SCENARIOS['line'](0.02).capture(2.0, 0))
    double = ZividDouble(scene, acquisition=0.04, processing=0.02)
    for name, module in double.modules().items():
        monkeypatch.setitem(sys.modules, name, module)
    return double
