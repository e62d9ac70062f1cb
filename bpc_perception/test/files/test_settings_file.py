"""Settings files: parameter files that keep what the user's file says."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.files.parameter_file import configure, live_recorder, name_other_sections
from bpc_perception.files.settings_file import read_settings, settings_file

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


def test_what_is_told_is_read_in_si(tmp_path: Path) -> None:
    assert read_settings(written(tmp_path, CELL)) == {
        'width': 0.8e-3, 'speed': pytest.approx(9.5e-3), 'flow': pytest.approx(2.117e-9)}


def test_the_flow_of_a_pressure_is_the_area_times_the_speed(tmp_path: Path) -> None:
    file = tmp_path / 'next.yaml'
    file.write_text(settings_file({
        'pressure_kpa': 62.0, 'speed_mm_s': 8.0, 'temperature_c': 21.0,
        'expected_area_mm2': 0.5}, 0.8e-3, 0.1, None))
    assert read_settings(file) == pytest.approx({
        'width': 0.8e-3, 'speed': 8e-3, 'flow': 4e-9, 'pressure': 62e3, 'temperature': 21.0})


@pytest.mark.parametrize(('text', 'lacking'), [
    ('', 'speed_mm_s'),
    (CELL, 'speed_mm_s'),
    ('print_settings: {ros__parameters: {speed_mm_s: 3.0, pressure_kpa: 9.0}}',
     'flow_mm3_s, or pressure_kpa and expected_area_mm2,'),
    ('print_settings: {ros__parameters: {speed_mm_s: -3.0, flow_mm3_s: 2.0}}', 'speed_mm_s'),
    ('print_settings: {ros__parameters: {speed_mm_s: fast, flow_mm3_s: 2.0}}', 'speed_mm_s'),
    ('print_settings: {ros__parameters: {speed_mm_s: 3.0, flow_mm3_s: 2.0}}',
     'advice.target_thickness')])
def test_a_file_without_settings_is_refused(tmp_path: Path, text: str, lacking: str) -> None:
    file = tmp_path / 'cell.yaml'
    file.write_text(text + '\nthickness: {ros__parameters: {advice: {target_thickness: 0.0}}}\n')
    with pytest.raises(ValueError, match=f'expected {lacking} above 0 as .*; name its'):
        read_settings(file)


def test_numbers_have_no_noise(tmp_path: Path) -> None:
    file = tmp_path / 'next.yaml'
    file.write_text(settings_file({}, 1.3 * 1e-3, 0.1, None))
    assert 'target_thickness: 0.0013\n' in file.read_text()


def test_what_is_no_parameter_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match='expected ros__parameters under each node'):
        written(tmp_path, 'thickness: 3')
    with pytest.raises(ValueError, match=r'cell\.yaml'):
        written(tmp_path, '[')
