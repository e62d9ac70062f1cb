"""The closed loop over topics: every node is a process; the outcome is that without a graph."""

from __future__ import annotations

from pathlib import Path
import re
import subprocess

import pytest

from bpc_system_tests.parts.command_line import command, refusal

pytestmark = [pytest.mark.system, pytest.mark.ros]

PATIENCE_S = 110.0  # 36 s of print, and start and end of seven processes on a busy machine
REPORT = re.compile(r'Off the target by ([\d.]+) % .* says ([\d.]+) %, and ([\d.]+) % without')


@pytest.mark.timeout(150)
@pytest.mark.usefixtures('ros_domain')
def test_live_as_offline(tmp_path: Path) -> None:
    ended = subprocess.run(
        command('sim', '--closed-loop', '--scenario', 'under_delivery', '--speed', 6,
                '--no-save'),
        cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, text=True,
        timeout=PATIENCE_S, check=False)
    assert (ended.returncode, ended.stderr) == (0, ''), ended.stderr
    found = REPORT.search(ended.stdout)
    assert found, ended.stdout
    live, offline, without = (float(value) for value in found.groups())
    assert live < 0.75 * without, ended.stdout
    assert live == pytest.approx(offline, abs=3), ended.stdout
    assert 'under extrusion' in ended.stdout
    assert not list(tmp_path.iterdir())  # nothing was to be saved


@pytest.mark.parametrize(('options', 'words'), [
    (('--scenario', 'teapot'), 'scenario: expected one of under_delivery'),
    (('--actuator', 'heat'), 'actuator: expected one of flow, speed'),
    (('--record', 'bag'), '--record: expected an open loop'),
    (('--seed', -1), 'seed: expected 0')])
def test_a_wrong_argument_is_refused(options: tuple[object, ...], words: str) -> None:
    assert words in refusal('sim', '--closed-loop', *options)
