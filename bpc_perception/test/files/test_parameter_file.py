"""Parameter files in all forms that ROS accepts."""

from __future__ import annotations

from pathlib import Path

import pytest

from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.core.parameter import ConfigError
from bpc_perception.files.parameter_file import (
    configure,
    name_other_sections,
    NODES,
    ParameterFileError,
)

NODE = 'ros__parameters: {advice.target_thickness: 0.003}'


def target(tmp_path: Path, text: str) -> float:
    """The target thickness that a file gives the thickness node."""
    file = tmp_path / 'params.yaml'
    file.write_text(text)
    return configure(ThicknessConfig(), 'thickness', file).advice.target_thickness


@pytest.mark.parametrize('text', [
    f'thickness: {{{NODE}}}', f'/thickness: {{{NODE}}}', f'/cell/thickness: {{{NODE}}}',
    f'cell: {{thickness: {{{NODE}}}}}', f'/a: {{b: {{thickness: {{{NODE}}}}}}}',
    f'/**: {{{NODE}}}', f'/**: {{thickness: {{{NODE}}}}}', f'/*: {{{NODE}}}',
    f'/**/thickness: {{{NODE}}}', f'/*/thickness: {{{NODE}}}',
    'thickness: {ros__parameters: {advice: {target_thickness: 3e-3}}}',
    'thickness: {ros__parameters: {advice: {target_thickness: 3E-03}}}',
    'thickness: {ros__parameters: {advice: {target_thickness: .3e-2}}}'])
def test_every_way_to_name_a_node_is_understood(tmp_path: Path, text: str) -> None:
    assert target(tmp_path, text) == 0.003


@pytest.mark.parametrize('text', [
    f'other: {{{NODE}}}', f'thickness/other: {{{NODE}}}', f'thickness: {{other: {{{NODE}}}}}', ''])
def test_what_another_node_is_given_is_not_taken(tmp_path: Path, text: str) -> None:
    assert target(tmp_path, text) == 0.0


def test_the_later_of_two_sections_counts(tmp_path: Path) -> None:
    later = 'thickness: {ros__parameters: {advice.target_thickness: 0.004}}'
    assert target(tmp_path, f'/**: {{{NODE}}}\n{later}') == 0.004


def test_numbers_in_lists_may_be_whole_or_have_exponents(tmp_path: Path) -> None:
    file = tmp_path / 'params.yaml'
    file.write_text('path_recorder: {ros__parameters: {nozzle_offset: [0, -1e-3, 150.0e-3]}}')
    assert configure(RecorderConfig(), 'path_recorder', file).nozzle_offset == (0, -0.001, 0.15)


def test_what_every_node_of_ros_has_is_left_to_it(tmp_path: Path) -> None:
    assert target(tmp_path, 'thickness: {ros__parameters: {use_sim_time: true, qos_overrides: '
                            '{/parameter_events: {publisher: {depth: 10}}}, '
                            'advice.target_thickness: 0.003}}') == 0.003


def test_a_name_that_a_node_does_not_know_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r'advice\.aim: no such parameter'):
        target(tmp_path, 'thickness: {ros__parameters: {advice.aim: 1}}')


@pytest.mark.parametrize('text', [
    'thickness:', 'thickness: {ros__parameters: }', 'thickness: 3', NODE, '[1, 2]',
    'thickness: {advice.target_thickness: 0.003}'])
def test_another_form_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(ParameterFileError, match='expected ros__parameters under each node'):
        target(tmp_path, text)


def test_a_section_that_no_node_reads_is_named(tmp_path: Path,
                                               caplog: pytest.LogCaptureFixture) -> None:
    file = tmp_path / 'params.yaml'
    file.write_text(f'thickness: {{{NODE}}}\n/**: {{{NODE}}}\n')
    name_other_sections(file)
    assert caplog.text == ''
    file.write_text(f'thicknes: {{{NODE}}}\ncell: {{zivid_camera: {{{NODE}}}}}\n')
    name_other_sections(file)
    assert 'found thicknes, cell/zivid_camera as well' in caplog.text


def test_every_node_may_have_a_section() -> None:
    folder = Path(__file__).parents[2] / 'bpc_perception' / 'nodes'
    named = {line.split("'")[1] for file in folder.glob('*.py')
             for line in file.read_text('utf-8').splitlines() if "super().__init__('" in line}
    assert set(NODES) == named


@pytest.mark.parametrize(('text', 'found'), [
    ('thickness:\n  ros__parameters: [\n', r"'<stream end>', in line 3, column 1; correct"),
    ('thickness:\n  ros__parameters:\n\t  method: x\n',
     r"character '\\t' that cannot start any token, in line 3, column 1;"),
    ('thickness:\n  ros__parameters:\n    method: a: b\n',
     r'mapping values are not allowed here, in line 3, column 14;'),
    ('a: &x 1\nb: *x\n', r'an alias, \*x, in line 2, column 4;'),
    ('a: 1\nb: 2024-99-99\n', r"'2024-99-99' as a value, in line 2, column 4;"),
    ('a: 1\nb: \x07\n', r"the control character '\\x07', in line 2, column 4;"),
    ('a: "\\UFFFFFFFF"', r'.'),
    ('a: 1\nß: caf\xe9'.encode('latin-1'), r'letters that are not UTF-8, in line 2, column 1;'),
])
def test_a_broken_file_is_named_with_line_and_column(
        tmp_path: Path, text: str | bytes, found: str) -> None:
    file = tmp_path / 'params.yaml'
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ParameterFileError, match=rf'^{file}: .*found: .*{found}') as refused:
        configure(ThicknessConfig(), 'thickness', file)
    assert '\n' not in str(refused.value)


@pytest.mark.parametrize(('text', 'found'), [
    ('- 1', r'found \[1\] under no node'), ('[]', r'found \[\] under no node'),
    ('thickness: {method: paper}', r"found 'paper' under thickness\.method"),
    ('ros__parameters: {method: paper}', r'found it at the top'),
    ('thickness: {ros__parameters: [1]}', r'found \[1\] in that of thickness')])
def test_a_file_of_another_form_is_told_where(tmp_path: Path, text: str, found: str) -> None:
    with pytest.raises(ParameterFileError, match=rf'expected ros__parameters .*, {found}'):
        target(tmp_path, text)
