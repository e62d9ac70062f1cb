"""Settings files: parameter files that keep what the user's file says."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.files.parameter_file import configure, live_recorder, name_other_sections
from bpc_perception.files.settings_file import settings_file

CELL = '''\
/**:
  ros__parameters:
    advice: {target_thickness: 0.003, window: 0.03}
path_recorder:
  ros__parameters:
    nozzle_offset: [0.0, 0.0, 0.15]
'''


def written(folder: Path, base: str | None = None) -> Path:
    below = None
    if base is not None:
        below = folder / 'cell.yaml'
        below.write_text(base)
    file = folder / 'next.yaml'
    file.write_text(settings_file({'flow_mm3_s': 2.117, 'speed_mm_s': 9.5}, 0.8e-3, 0.1, below))
    return file


def advice_of(file: Path) -> tuple[float, float]:
    config = configure(ThicknessConfig(), 'thickness', file)
    return config.advice.target_thickness, config.tolerance.width


def test_target_and_tolerance_are_read_as_parameters(
        tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    file = written(tmp_path)
    assert advice_of(file) == (0.8e-3, 0.1)
    with caplog.at_level(logging.WARNING):
        name_other_sections(file)
    assert caplog.text == ''
    assert 'flow_mm3_s: 2.117' in file.read_text()


def test_the_users_values_are_kept(tmp_path: Path) -> None:
    file = written(tmp_path, CELL)
    assert advice_of(file) == (0.8e-3, 0.1)
    assert configure(ThicknessConfig(), 'thickness', file).advice.window == 0.03
    assert live_recorder(file).nozzle_offset == (0.0, 0.0, 0.15)


@pytest.mark.parametrize('section', [
    'thickness: {ros__parameters: {advice.target_thickness: 0.003, advice.target_file: a.csv}}',
    'thickness: {ros__parameters: {advice: {target_thickness: 0.003, target_file: a.csv}}}',
    '/cell/thickness: {ros__parameters: {tolerance.width: 0.5}}',
    'cell: {thickness: {ros__parameters: {tolerance: {width: 0.5}}}}',
    '/**/thickness: {ros__parameters: {advice: {window: 0.03}}}'])
def test_an_earlier_target_is_replaced_wherever_it_is(tmp_path: Path, section: str) -> None:
    file = written(tmp_path, section)
    assert advice_of(file) == (0.8e-3, 0.1)
    assert configure(ThicknessConfig(), 'thickness', file).advice.target_file == ''
    assert file.read_text().count('target_thickness') == 1


def test_what_is_no_parameter_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match='expected ros__parameters under each node'):
        written(tmp_path, 'thickness: 3')
    with pytest.raises(ValueError, match=r'cell\.yaml'):
        written(tmp_path, '[')
