"""The command line: refusals, explanations and outputs."""

from __future__ import annotations

import csv
import json
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys

import pytest

from bpc_perception.recording.bag import Bag
from bpc_sim.printer import scenarios
from bpc_system_tests.parts.command_line import (
    command,
    OUTPUTS,
    PATIENCE_S,
    refusal,
    run,
    SAMPLE,
    SAMPLE_OUTPUTS,
    succeed,
)
from bpc_system_tests.parts.ros_graph import own_domain

pytestmark = pytest.mark.system

COMMANDS = ('demo', 'test', 'measure', 'replay', 'live', 'sim', 'record', 'study', 'bench',
            'calibrate', 'check', 'compare', 'batch')
SCENARIOS = ('spiral_gaps', 'line', 'ring', 'meander', 'archimedean', 'fermat')


def test_help_names_every_command() -> None:
    text = succeed('--help')
    assert all(f'\n  {command} ' in text for command in COMMANDS)
    assert succeed() == text


@pytest.mark.parametrize('name', COMMANDS)
def test_every_command_explains_itself(name: str) -> None:
    text = succeed(name, '--help')
    assert text.startswith(f'Usage: bpc {name} ')
    assert '--help' in text


def test_sim_names_all_that_it_prints() -> None:
    words = re.split(r'[\s,.]+', succeed('sim', '--help'))
    assert set(scenarios.SCENARIOS) <= set(words)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize('loaded', [
    'typer', 'bpc_perception.cli.app', 'bpc_perception.runtime.run'])
def test_told_to_end_while_it_loads_it_just_ends(tmp_path: Path, loaded: str,
                                                 number: signal.Signals) -> None:
    bag = tmp_path / 'bag'
    python, *rest = command('record', '--out', bag)
    # As in the background of a script, where SIGINT is ignored. Python reports what it loads.
    in_background = ['sh', '-c', 'trap "" INT; exec "$@"', 'sh']
    with own_domain(), subprocess.Popen(
            [*in_background, python, '-X', 'importtime', *rest], stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        try:
            for line in process.stderr:
                if line.split('|')[-1].strip() == loaded:
                    break
            process.send_signal(number)
            _, said = process.communicate(timeout=PATIENCE_S)
        finally:
            process.kill()
    assert process.returncode == (0 if (bag / 'metadata.yaml').exists() else 130)
    assert 'Traceback' not in said


# C++ destructors may wait for ever; here even while they hold Python's lock.
HANGS_AT_EXIT = """
import ctypes
import sys

from bpc_perception.cli.parts.monitor import monitoring
from bpc_perception.cli.parts.terminal import Terminal

with monitoring(Terminal()):
    pass
ctypes.CDLL(None).on_exit(ctypes.CDLL(None).pause, None)
sys.stdout.write('said')
"""
HANGS_WITHOUT_ROS = """
import ctypes
import sys

import rclpy

from bpc_perception.cli.app import main

rclpy.try_shutdown = ctypes.PyDLL(None).pause
sys.argv = ['bpc', 'record', '--out', sys.argv[1]]
main()
"""


def test_who_hangs_at_its_exit_ends_all_the_same() -> None:
    with own_domain():
        ended = subprocess.run([sys.executable, '-c', HANGS_AT_EXIT], stdin=subprocess.DEVNULL,
                               capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    assert (ended.returncode, ended.stderr, ended.stdout) == (-signal.SIGALRM, '', 'said')


def test_a_recorder_that_hangs_in_ending_ends_with_its_recording_whole(tmp_path: Path) -> None:
    bag = tmp_path / 'bag'
    with own_domain(), subprocess.Popen(
            [sys.executable, '-c', HANGS_WITHOUT_ROS, bag], stdin=subprocess.DEVNULL,
            stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            assert 'recording into' in process.stderr.readline()
            process.terminate()
            process.wait(PATIENCE_S)
        finally:
            process.kill()
    assert process.returncode == -signal.SIGALRM
    assert (bag / 'metadata.yaml').exists()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with files that a user may name by mistake."""
    (tmp_path / 'empty').mkdir()
    (tmp_path / 'text.txt').write_text('no recording\n')
    (tmp_path / 'text.mcap').write_text('no recording, whatever its name says\n')
    (tmp_path / 'text.db3').write_text('no recording, whatever its name says\n')
    (tmp_path / 'zeros.mcap').write_bytes(bytes(4096))
    (tmp_path / 'torn.yaml').write_text('thickness: {ros__parameters: [\n')
    (tmp_path / 'unknown.yaml').write_text('thickness: {ros__parameters: {colour: 1}}\n')
    (tmp_path / 'method.yaml').write_text('thickness: {ros__parameters: {method: guess}}\n')
    (tmp_path / 'joints.yaml').write_text(
        '/**: {ros__parameters: {pose: {source: joint_states}}}\n')
    (tmp_path / 'list.yaml').write_text('- 1\n')
    (tmp_path / 'mount.calib').write_text(
        (SAMPLE / 'hand_eye.calib').read_text().replace('eye_on_base', 'eye_on_roof'))
    (tmp_path / 'bare').mkdir()
    shutil.copy(SAMPLE / 'spiral_gaps_0.mcap', tmp_path / 'bare')
    return tmp_path


# The arguments, and what the error line has to name: what was expected or found, or where.
WRONG = {
    'command': (['measures'], ['measures', '--help']),
    'no bag': (['measure'], ['bpc measure', 'BAG']),
    'unknown option': (['measure', SAMPLE, '--hand-eye', 'x'], ['--hand-eye']),
    'option without value': (['measure', SAMPLE, '--out'], ['--out']),
    'no out': (['measure', SAMPLE], ['--out']),
    'capture no number': (['measure', SAMPLE, '--out', 'out', '--capture', 'two'],
                          ['--capture', 'valid integer']),
    'capture out of range': (['measure', SAMPLE, '--out', 'out', '--capture', 5],
                             ['found --capture 5 of 5', 'name one of 0 to 4']),
    'capture below 0': (['measure', SAMPLE, '--out', 'out', '--capture', -1],
                        ['--capture', 'greater than or equal to 0']),
    'out is a file': (['measure', SAMPLE, '--out', 'text.txt'],
                      ['text.txt', 'expected a folder', 'a file']),
    'out below a file': (['measure', SAMPLE, '--out', 'text.txt/out'],
                         ['text.txt/out', 'expected a folder', 'a file']),
    'missing bag': (['measure', 'nowhere', '--out', 'out'],
                    ['nowhere: expected a bag', 'found nothing']),
    'folder without bag': (['measure', 'empty', '--out', 'out'],
                           ['empty: expected a rosbag2 folder', 'found neither']),
    'file of another kind': (['measure', 'text.txt', '--out', 'out'],
                             ['text.txt: expected a rosbag2 folder', 'found neither']),
    'text for MCAP': (['measure', 'text.mcap', '--out', 'out'],
                      ['text.mcap', 'expected an MCAP file', 'found']),
    'zeros for MCAP': (['measure', 'zeros.mcap', '--out', 'out'],
                       ['zeros.mcap', 'expected an MCAP file', 'found']),
    'text for sqlite3': (['measure', 'text.db3', '--out', 'out'],
                         ['text.db3', 'expected a sqlite3 file of rosbag2', 'found']),
    'no calibration in the bag': (['measure', 'bare', '--out', 'out'],
                                  ['hand-eye', '--handeye FILE', 'hand_eye.calib', 'neither']),
    'missing calibration': (['measure', SAMPLE, '--out', 'out', '--handeye', 'nowhere'],
                            ['hand-eye', 'expected nowhere', 'found nothing']),
    'calibration of unknown mount': (
        ['measure', SAMPLE, '--out', 'out', '--handeye', 'mount.calib'],
        ['mount.calib', 'expected calibration_type', "found 'eye_on_roof'"]),
    'missing parameters': (['measure', SAMPLE, '--out', 'out', '--params', 'nowhere'],
                           ['nowhere: expected a readable YAML file', 'No such file']),
    'torn parameters': (['measure', SAMPLE, '--out', 'out', '--params', 'torn.yaml'],
                        ['torn.yaml: expected a readable YAML file', 'found']),
    'parameters of another form': (['measure', SAMPLE, '--out', 'out', '--params', 'list.yaml'],
                                   ['list.yaml: expected ros__parameters']),
    'unknown parameter': (['measure', SAMPLE, '--out', 'out', '--params', 'unknown.yaml'],
                          ['colour: no such parameter']),
    'parameter out of range': (['measure', SAMPLE, '--out', 'out', '--params', 'method.yaml'],
                               ['method: expected one of', "found 'guess'"]),
    'replay of a missing bag': (['replay', 'nowhere'], ['nowhere: expected a bag']),
    'replay without speed': (['replay', SAMPLE, '--rate', 0, '--out', 'out'],
                             ['rate: expected 0.01 to 100', 'found 0.0']),
    'demo without speed': (['demo', '--rate', -1], ['rate: expected 0.01 to 100', 'found -1.0']),
    'live without calibration': (['live'], ['--handeye']),
    'live with a missing calibration': (['live', '--handeye', 'nowhere'],
                                        ['nowhere', 'No such file']),
    'live without a nozzle': (['live', '--handeye', SAMPLE / 'hand_eye.calib'],
                              ['nozzle_offset: expected', 'found none', 'bpc calibrate nozzle']),
    'live with a topic for nothing': (
        ['live', '--handeye', SAMPLE / 'hand_eye.calib', '--params', SAMPLE / 'params.yaml',
         '--remap', '/lbr/joint_states'], ['--remap: expected TOPIC:=OTHER', 'joint_states']),
    'live with joints of no robot': (
        ['live', '--handeye', SAMPLE / 'hand_eye.calib', '--params', 'joints.yaml'],
        ['pose.robot: expected one of lbr_med_7', 'found none']),
    'unknown scenario': (['sim', '--scenario', 'teapot'],
                         ['scenario: expected one of', *SCENARIOS, "found 'teapot'"]),
    'sim without speed': (['sim', '--speed', 0], ['speed: expected 0.1 to 500 mm/s', 'found 0']),
    'sim without captures': (['sim', '--rate', 0], ['rate: expected more than 0']),
    'sim with a target of no size': (['sim', '--record', 'bag', '--target', -1],
                                     ['target_thickness: expected 0 to', 'found -0.001']),
    'sim into a bag that exists': (['sim', '--record', 'bare'],
                                   ['bare: expected a new bag', 'exists']),
    'record without bag': (['record'], ['--out']),
    'record with a calibration that is none': (
        ['record', '--out', 'new', '--handeye', 'mount.calib'], ['eye_on_base', 'eye_on_roof']),
    'record a robot that is not said': (
        ['record', '--out', 'new', '--params', 'joints.yaml'],
        ['pose.robot: expected one of lbr_med_7', 'found none']),
    'record into a bag that exists': (['record', '--out', 'bare'],
                                      ['bare: expected a new bag', 'exists']),
    'unknown study': (['study', 'table9'], ['study: expected one of table1', 'found table9']),
    'compare with nothing': (['compare', 'empty'], ['compare: expected two prints', 'found one']),
    'compare what is no result': (['compare', 'empty', 'bare'],
                                  ['empty: expected a folder with profile.csv', 'found no']),
    'compare into no page': (['compare', 'empty', 'bare', '--out', 'page.pdf'],
                             ['page.pdf: expected a name that ends in .html']),
    'batch of a file': (['batch', 'text.txt', '--out', 'out'],
                        ['text.txt: expected a folder, found none']),
    'batch of nothing': (['batch', 'empty', '--out', 'out'],
                         ['empty: expected recordings in it or below', 'found none']),
    'quiet JSON': (['measure', SAMPLE, '--out', 'out', '--quiet', '--json'],
                   ['expected --quiet or --json, found both']),
    'study into no folder': (['study', 'table1', '--json', 'nowhere/rows.json'],
                             ['nowhere/rows.json: expected', 'found none']),
}


@pytest.mark.usefixtures('ros_domain')
@pytest.mark.parametrize(('arguments', 'words'), WRONG.values(), ids=WRONG)
def test_what_cannot_be_done_is_refused_in_one_line(
        arguments: list[object], words: list[str], folder: Path) -> None:
    before = sorted(folder.rglob('*'))
    line = refusal(*arguments, folder=folder)
    assert line.startswith('bpc')
    assert all(word in line for word in words), line
    assert sorted(folder.rglob('*')) == before


def test_earlier_outputs_outlive_a_refusal(measured_sample: Path, folder: Path) -> None:
    out = shutil.copytree(measured_sample, folder / 'out')
    before = {file.name: file.read_bytes() for file in out.iterdir()}
    refusal('measure', SAMPLE, '--out', out, '--capture', 5)
    assert {file.name: file.read_bytes() for file in out.iterdir()} == before


def test_a_recording_is_measured_in_a_shell_for_other_programs(
        measured_sample: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (('RMW_IMPLEMENTATION', 'rmw_other_cpp'), ('ROS_DOMAIN_ID', 'abc'),
                        ('PYTHONIOENCODING', 'ascii')):
        monkeypatch.setenv(name, value)
    succeed('measure', SAMPLE, '--out', tmp_path)
    assert (tmp_path / 'profile.csv').read_bytes() == (
        measured_sample / 'profile.csv').read_bytes()


def test_measure_leaves_its_files_and_names_them(measured_sample: Path) -> None:
    assert {file.name for file in measured_sample.iterdir()} == SAMPLE_OUTPUTS
    captures = json.loads((measured_sample / 'summary.json').read_text())['captures']
    assert [capture['capture'] for capture in captures] == [0, 1, 2, 3, 4]


def test_measure_of_a_capture_is_that_of_all_captures(
        measured_sample: Path, tmp_path: Path) -> None:
    printed = succeed('measure', SAMPLE, '--out', tmp_path / 'all', '--all')
    for name in OUTPUTS:
        assert f'{tmp_path / "all" / name}\n' in printed
    folders = {path.name for path in (tmp_path / 'all').iterdir() if path.is_dir()}
    assert folders == {f'capture_{number:04d}' for number in range(5)}
    last = (measured_sample / 'profile.csv').read_bytes()
    assert (tmp_path / 'all' / 'profile.csv').read_bytes() == last
    assert (tmp_path / 'all' / 'capture_0004' / 'profile.csv').read_bytes() == last

    succeed('measure', SAMPLE, '--out', tmp_path / 'one', '--capture', 1)
    one = tmp_path / 'one'
    assert (one / 'profile.csv').read_bytes() == (
        tmp_path / 'all' / 'capture_0001' / 'profile.csv').read_bytes()
    assert json.loads((one / 'summary.json').read_text())['capture'] == 1
    assert (one / 'profile.csv').stat().st_size < len(last)


def test_scripts_get_json_and_figures(tmp_path: Path) -> None:
    printed = succeed('measure', SAMPLE, '--out', tmp_path, '--json', '--figures')
    events = [json.loads(line) for line in printed.splitlines()]
    files = {str(path) for path in tmp_path.rglob('*') if path.is_file()}
    assert {event['path'] for event in events if event['event'] == 'file'} == files
    assert str(tmp_path / 'figures' / 'thickness.pdf') in files
    captures = [event for event in events if event['event'] == 'capture']
    assert [event['capture'] for event in captures] == [0, 1, 2, 3, 4]
    assert captures[-1]['advice']['reason'] == 'UNDER_EXTRUSION'


def test_prints_are_compared(measured_sample: Path, tmp_path: Path) -> None:
    page = tmp_path / 'compare.html'
    assert succeed('compare', measured_sample, measured_sample, '--out', page,
                   '--quiet') == ''
    assert '2 prints compared' in page.read_text()
    assert list(tmp_path.iterdir()) == [page]


def test_what_is_left_of_a_torn_recording_is_measured(
        measured_sample: Path, tmp_path: Path) -> None:
    torn = tmp_path / 'torn.mcap'
    torn.write_bytes((SAMPLE / 'spiral_gaps_0.mcap').read_bytes()[:-200_000])
    ended = run('measure', torn, '--handeye', SAMPLE / 'hand_eye.calib', '--params',
                SAMPLE / 'params.yaml', '--out', tmp_path / 'out')
    assert ended.returncode == 0
    damage, incomplete = ended.stderr.splitlines()  # each said once
    assert damage.startswith(f'bpc: {torn}: torn, read up to the damage')
    assert incomplete.endswith('found no color/camera_info and no points/xyzrgba')
    whole = json.loads((measured_sample / 'summary.json').read_text())['captures']
    rest = json.loads((tmp_path / 'out' / 'summary.json').read_text())['captures']
    assert [one['capture'] for one in rest] == [0, 1, 2, 3]
    assert [one['counts'] for one in rest] == [one['counts'] for one in whole[:4]]


def test_recorded_simulation_is_the_same_each_time(tmp_path: Path) -> None:
    # Message by message: the bytes of a file differ where CDR leaves padding undefined.
    bags = [tmp_path / name / 'print' for name in 'ab']
    for bag in bags:
        succeed('sim', '--scenario', 'line', '--speed', 25, '--record', bag)
    files, others = ({file.name for file in bag.iterdir()} for bag in bags)
    assert files == others == {'print_0.mcap', 'metadata.yaml', 'hand_eye.calib', 'params.yaml'}
    for name in files - {'print_0.mcap'}:
        assert (bags[0] / name).read_bytes() == (bags[1] / name).read_bytes()
    messages, again = (list(bag.messages(set(bag.topics))) for bag in map(Bag, bags))
    assert len(messages) > 600
    assert messages == again


@pytest.mark.accuracy
def test_table_of_the_paper_is_met(tmp_path: Path) -> None:
    file = tmp_path / 'rows.json'
    printed = succeed('study', 'table1', '--json', file)
    rows = json.loads(file.read_text())
    assert all(set(row) == set(rows[0]) for row in rows)
    assert all(isinstance(value, str | int | float) for row in rows for value in row.values())
    paper = [row for row in rows if (row['drawing'], row['method']) == ('area', 'paper')]
    assert [row['case'] for row in paper] == list(range(1, 9))
    for row in paper:
        assert 0.02 < row['MAE_mm'] < 0.06
        assert row['print'] in printed


@pytest.mark.parametrize(('bag', 'status', 'words'), [
    ('spiral_gaps', 3, 'not good: 1 × gap'), ('strokes', 0, 'good')])
def test_measure_tells_whether_a_print_is_good(tmp_path: Path, bag: str, status: int,
                                               words: str) -> None:
    ended = run('measure', SAMPLE.parent / bag, '--out', tmp_path / 'out', '--verdict', '--json')
    assert ended.returncode == status, ended.stderr
    said = [json.loads(line) for line in ended.stdout.splitlines()]
    verdict, = (each for each in said if each['event'] == 'verdict')
    summary = json.loads((tmp_path / 'out' / 'summary.json').read_text())
    assert {key: verdict[key] for key in summary['verdict']} == summary['verdict']
    assert summary['verdict']['ended']
    assert f'This print is <strong>{words}</strong>' in (
        tmp_path / 'out' / 'report.html').read_text()


def write_lines(file: Path, count: int) -> Path:
    """Write the design of the sample strokes, five lines 5 mm apart, or of more of them."""
    rows = [f'{x},{5 * number - 10},0,{number + 1},2' for number in range(count)
            for x in (-18, 18)]
    file.write_text('\n'.join(('x_mm,y_mm,z_mm,stroke,width_mm', *rows, '')))
    return file


def test_a_print_is_compared_with_its_design(tmp_path: Path) -> None:
    """The bed of the simulator tells where the design lies, and how it is turned."""
    out = tmp_path / 'out'
    succeed('measure', SAMPLE.parent / 'strokes', '--out', out, '--design',
            write_lines(tmp_path / 'lines.csv', 5))
    found = json.loads((out / 'summary.json').read_text())['design']
    place = scenarios.bed_pose()
    assert [found[name] for name in ('x_mm', 'y_mm')] == pytest.approx(
        (place[:2, 3] * 1e3).tolist(), abs=0.3)
    assert found['yaw_degrees'] == pytest.approx(20, abs=0.1)
    assert found['nozzle_off']['most_mm'] < 0.05
    assert found['bead_off']['most_mm'] < 0.1
    assert found['layers'][0]['fidelity'] == 1
    assert (found['missing'], found['surplus']) == ([], [])
    assert 'Beside its design' in (out / 'report.html').read_text()
    rows = list(csv.DictReader((out / 'profile.csv').read_text().splitlines()))
    assert {row['design_stroke'] for row in rows if row['stroke'] != '0'} == set('12345')
    assert {row['wanted_mm'] for row in rows if row['design_stroke']} == {'2.0'}
    assert max(abs(float(row['bead_off_mm'])) for row in rows if row['bead_off_mm']) < 0.1


def test_strokes_of_a_design_that_were_not_printed_are_told(tmp_path: Path) -> None:
    """Beside a recording, the parameters tell the design as the options do."""
    out, parameters = tmp_path / 'out', tmp_path / 'cell.yaml'
    kept = (SAMPLE.parent / 'strokes' / 'params.yaml').read_text()
    parameters.write_text(kept + f"""
/**/thickness:
  ros__parameters:
    design: {{file: {write_lines(tmp_path / 'lines.csv', 6)}, place: '550,50,21,20'}}
""")
    ended = run('measure', SAMPLE.parent / 'strokes', '--out', out, '--params', parameters,
                '--verdict')
    assert (ended.returncode, '1 × skipped' in ended.stdout) == (3, True)
    summary = json.loads((out / 'summary.json').read_text())
    found, defects = summary['design'], summary['verdict']['defects']
    assert [(each['kind'], each['stroke'], each['worst_mm']) for each in defects] == [
        ('SKIPPED', 6, pytest.approx(36))]
    missing, = found['missing']
    assert (missing['stroke'], missing['presence']) == (6, 'SKIPPED')  # as in the defect
    assert found['layers'][0]['fidelity'] == pytest.approx(5 / 6, abs=0.01)


@pytest.mark.parametrize(('options', 'words'), [
    (('--design-at', '1,2,3,4'), 'name its file with --design'),
    (('--design', 'nothing.gcode'), 'nothing.gcode'),
    (('--design', 'lines.csv', '--design-at', '1,2'), 'expected four numbers')])
def test_a_design_that_cannot_be_taken_is_refused(tmp_path: Path, options: tuple[str, ...],
                                                  words: str) -> None:
    write_lines(tmp_path / 'lines.csv', 5)
    given = [tmp_path / each if each.endswith(('.csv', '.gcode')) else each for each in options]
    assert words in refusal('measure', SAMPLE, '--out', tmp_path / 'out', *given)
    assert not (tmp_path / 'out').exists()
