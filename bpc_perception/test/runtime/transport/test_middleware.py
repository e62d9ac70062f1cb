"""What the user asks of the middleware, and whether it can be had."""

from __future__ import annotations

import os

import pytest

pytest.importorskip('rclpy')
from bpc_perception.cli.parts.monitor import monitoring
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.runtime.run import run
from bpc_perception.runtime.transport import middleware

pytestmark = pytest.mark.ros


def test_without_the_middleware_asked_for_no_node_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(middleware, '_missing', '')
    monkeypatch.setenv('RMW_IMPLEMENTATION', 'rmw_other_cpp')
    middleware.do_without_missing()
    assert 'RMW_IMPLEMENTATION' not in os.environ
    with pytest.raises(ValueError, match=r'^RMW_IMPLEMENTATION: expected rmw_fastrtps_cpp\b.*, '
                                         'found rmw_other_cpp, which is not installed$'):
        middleware.expect_middleware()


def test_the_middleware_asked_for_is_taken_where_it_is_there(
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp')
    middleware.do_without_missing()
    middleware.expect_middleware()
    assert os.environ['RMW_IMPLEMENTATION'] == 'rmw_fastrtps_cpp'


@pytest.mark.parametrize('domain', ['abc', '233', '300', '-1', '1.5', ' '])
def test_a_domain_that_is_none_is_refused(
        domain: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', domain)
    complaint = f'ROS_DOMAIN_ID: expected a number from 0 to 232, found {domain!r}'
    with pytest.raises(ValueError, match=complaint), monitoring(Terminal()):
        pass
    with pytest.raises(SystemExit, match='2'):
        run(list)
    assert capsys.readouterr().err == f'list: {complaint}\n'


@pytest.mark.parametrize('domain', ['', '0', '232'])
def test_a_domain_is_taken(domain: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', domain)
    middleware.expect_middleware()
