"""Closing its terminal ends a command in good order, unless the command ignores that."""

from __future__ import annotations

import atexit
from collections.abc import Iterator
import os
import signal
from typing import Any

import pytest

pytest.importorskip('rclpy')
from bpc_perception.__main__ import main
from bpc_perception.cli import app
from bpc_perception.cli.parts.monitor import monitoring
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.runtime.exit_status import INTERRUPTED

pytestmark = pytest.mark.ros


def not_handled(*_: object) -> None:
    """Stands in for the default action, which would end the tests as well."""
    raise AssertionError('expected SIGHUP to be handled')


@pytest.fixture(params=[not_handled, signal.SIG_IGN], ids=['terminal', 'nohup'])
def before(request: pytest.FixtureRequest) -> Iterator[Any]:
    """Set the action for SIGHUP that is found when a command starts."""
    handlers = {number: signal.getsignal(number)
                for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT)}
    signal.signal(signal.SIGHUP, request.param)
    yield request.param
    for number, handler in handlers.items():
        signal.signal(number, handler)


def test_a_closed_terminal_ends_a_monitor(before: Any, ros_domain: int,
                                          monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    reached = False
    with monitoring(Terminal()) as monitor:
        os.kill(os.getpid(), signal.SIGHUP)
        monitor.spin_until(lambda: False, 0.1)
        reached = True
    assert reached == (before == signal.SIG_IGN)
    assert signal.getsignal(signal.SIGHUP) == before


def test_a_closed_terminal_interrupts_any_command(before: Any,
                                                  monkeypatch: pytest.MonkeyPatch) -> None:
    def command(*_: Any, **__: Any) -> None:
        os.kill(os.getpid(), signal.SIGHUP)

    monkeypatch.setattr(app, 'command_line', lambda _: command)
    monkeypatch.setattr(app, 'choose_profile', lambda: None)
    monkeypatch.setattr(app.shared_memory, 'clean', lambda **_: None)
    monkeypatch.setattr(atexit, 'register', lambda _: None)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == (None if before == signal.SIG_IGN else INTERRUPTED)
