"""Fixtures shared by the system tests."""

from __future__ import annotations

from collections.abc import Iterator
import os
from pathlib import Path
from typing import Any

import pytest

from bpc_perception.runtime.transport.dds_profiles import choose_profile
from bpc_system_tests.parts import browser as browsers, command_line
from bpc_system_tests.parts.command_line import ROOT
from bpc_system_tests.parts.ros_graph import own_domain

# Inherited by every process that a test starts.
os.environ['BPC_ROOT'] = str(ROOT)
os.environ['ROS_PYTHON_CHECK_FIELDS'] = '1'
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
# The tests themselves publish captures too.
choose_profile(captures=True)


@pytest.fixture
def ros_domain() -> Iterator[int]:
    """A ROS domain id of this test's own, for its processes too."""
    with own_domain() as domain:
        yield domain


@pytest.fixture(scope='session')
def measured_sample(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `bpc measure` leaves behind of the sample bag."""
    out = tmp_path_factory.mktemp('sample') / 'out'
    command_line.succeed('measure', command_line.SAMPLE, '--out', out)
    return out


@pytest.fixture(scope='session')
def short_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A print of four seconds with three captures: the quickest to play."""
    bag = tmp_path_factory.mktemp('short') / 'line'
    command_line.succeed(
        'sim', '--scenario', 'line', '--speed', 25, '--rate', 0.8, '--record', bag)
    return bag


@pytest.fixture(scope='module')
def browser() -> Iterator[Any]:
    """A browser for the tests of a file."""

    if lacking := browsers.missing():
        if browsers.required():
            pytest.fail(lacking)
        pytest.skip(lacking)
    with browsers.browsing() as driver:
        yield driver
