"""The product alone, without its simulator installed: it measures, replays and runs live."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bpc_system_tests.parts.command_line import (
    OUTPUTS,
    refusal,
    run,
    running,
    SAMPLE,
    SAMPLE_OUTPUTS,
    succeed,
)
from bpc_system_tests.parts.ros_graph import own_domain

pytestmark = pytest.mark.system


@pytest.fixture(autouse=True)
def _without_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let processes find neither the simulator nor what it registers."""
    kept = [folder for folder in os.environ['PYTHONPATH'].split(os.pathsep)
            if Path(folder).name != 'bpc_sim']
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(kept))


def test_its_commands_are_there_and_those_of_the_simulator_are_not() -> None:
    said = succeed('--help')
    lines = said.split('Commands:')[1].splitlines()
    commands = {line.split()[0] for line in lines if line.strip()}
    assert {'measure', 'replay', 'live', 'check', 'record'} <= commands
    assert commands.isdisjoint({'sim', 'study', 'bench'})
    assert 'No such command' in run('sim').stderr


def test_it_measures(tmp_path: Path) -> None:
    succeed('measure', SAMPLE, '--out', tmp_path / 'out')
    assert {file.name for file in (tmp_path / 'out').iterdir()} == SAMPLE_OUTPUTS


def test_it_replays(short_bag: Path, tmp_path: Path) -> None:
    with own_domain():
        succeed('replay', short_bag, '--out', tmp_path / 'out')
    assert {file.name for file in (tmp_path / 'out').iterdir()} == OUTPUTS


def test_it_runs_live() -> None:
    with own_domain(), running('live', '--no-save', '--handeye',
                               SAMPLE / 'hand_eye.calib', '--params',
                               SAMPLE / 'params.yaml') as process:
        assert process.stdout is not None
        assert 'Waiting for captures' in process.stdout.readline()


def test_a_camera_of_the_simulator_is_refused() -> None:
    said = refusal('live', '--handeye', SAMPLE / 'hand_eye.calib', '--params',
                   SAMPLE / 'params.yaml', '--camera', 'synthetic')
    assert "expected one of bag, zivid, found 'synthetic'" in said
