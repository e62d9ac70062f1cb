"""Camera back ends are found by name, in any package."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

pytest.importorskip('rclpy')
from bpc_perception.drivers import cameras

pytestmark = pytest.mark.ros


def test_those_of_the_product_are_there() -> None:
    assert {'bag', 'zivid'} <= set(cameras.back_ends())
    cameras.check_back_end('bag')


def test_an_unknown_one_is_refused_naming_those_that_are_there() -> None:
    with pytest.raises(ValueError, match=r"^back_end: expected one of bag.* found 'zivid9'$"):
        cameras.check_back_end('zivid9')


def test_one_that_cannot_be_loaded_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = EntryPoint('broken', 'package_that_is_not_there:prepare', cameras.ENTRY_POINT_GROUP)
    monkeypatch.setattr(cameras, 'entry_points', lambda **_: {broken})
    monkeypatch.setattr(cameras, 'back_ends', lambda: ['broken'])
    with pytest.raises(ValueError, match=r'expected broken to be installed, found: .*not_there'):
        cameras.prepare_camera('broken', None)
