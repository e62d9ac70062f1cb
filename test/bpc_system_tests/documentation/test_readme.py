"""The documentation says what is so: commands, options, parameters, topics, files."""

from __future__ import annotations

import ast
from itertools import pairwise
from pathlib import Path
import re

import cv2
import pytest
import typer
import yaml

from bpc_perception.cli import app
from bpc_perception.core.config import CameraConfig
from bpc_perception.core.parameter import flatten
from bpc_perception.core.profile import Status
from bpc_perception.files.parameter_file import configure, live_recorder
from bpc_perception.messages import topics
from bpc_sim.printer.scenarios import SCENARIOS
from bpc_system_tests.documentation import reference
from bpc_system_tests.robustness.test_faults import TESTS

ROOT = reference.ROOT
TEXTS = {name: (ROOT / name).read_text(encoding='utf-8')
         for name in ('README.md', 'CONTRIBUTING.md', 'bags/README.md', 'docs/faults.md')}
README = TEXTS['README.md']
REMAKE = 'made anew by: python test/bpc_system_tests/documentation/reference.py'
ENV = 'env'  # answered by the set-up, before there is a command line
# Packages for which rosdep has no key, or one that Ubuntu 24.04 refuses.
NOT_OF_ROSDEP = {'mcap', 'rosbags', 'lz4', 'zstandard', 'plotly', 'ticlib', 'matplotlib',
                 'distributed', 'pyarrow', 'nicegui'}


def options() -> dict[str, set[str]]:
    """The options of every command, with those of its own commands if it has any."""
    group = typer.main.get_command(app)
    return {name: {option for each in (command, *getattr(command, 'commands', {}).values())
                   for parameter in each.params for option in parameter.opts} | {'--help'}
            for name, command in group.commands.items()}


def launch_arguments(file: Path) -> set[str]:
    """The names that a launch file declares, as far as they are written in it as strings."""
    return {node.value for node in ast.walk(ast.parse(file.read_text(encoding='utf-8')))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)}


def section(heading: str) -> str:
    """The part of the README under a heading."""
    return README.split(f'\n## {heading}\n')[1].split('\n## ')[0]


def loaded_with(module: str, known: set[str]) -> set[str]:
    """Adds to the names known all that is imported as soon as a module of ours is."""
    stem = ROOT / 'bpc_perception' / module.replace('.', '/')
    for file in (stem.with_suffix('.py'), stem / '__init__.py'):
        for statement in ast.parse(file.read_text('utf-8')).body if file.exists() else ():
            names = [alias.name for alias in getattr(statement, 'names', ())]
            if isinstance(statement, ast.ImportFrom):
                names = [f'{statement.module}.{name}' for name in names] + [str(statement.module)]
            for name in {*names} - known:
                known.add(name)
                loaded_with(name, known)
    return known


@pytest.mark.parametrize('path', [path for path, _ in reference.files()],
                         ids=lambda path: path.name)
def test_parameters_are_those_of_the_configuration(path: Path) -> None:
    wanted = dict(reference.files())[path]
    assert path.read_text(encoding='utf-8') == wanted, REMAKE


@pytest.mark.parametrize('node', reference.FILES)
def test_parameter_file_gives_the_defaults(node: str) -> None:
    default = reference.FILES[node]()
    path = reference.CONFIG / f'{node}.yaml'
    assert configure(default, node, path) == default
    text = path.read_text(encoding='utf-8')
    assert f'[{path.name}](bpc_perception/config/{path.name})' in section('On a printer')
    assert all(f'\n    {name}: ' in text for name, _, _ in flatten(default))


def test_the_example_for_a_printer_is_whole_and_accepted(tmp_path: Path) -> None:
    example, = re.findall(r'```yaml\n(.*?)```', section('On a printer'), re.DOTALL)
    assert set(yaml.safe_load(example)) == {'/**', *reference.FILES}
    file = tmp_path / 'cell.yaml'
    file.write_text(example)
    for node, kind in reference.FILES.items():
        configure(kind(), node, file)
    assert configure(CameraConfig(), 'camera_driver', file).rate > 0  # or it takes nothing
    live_recorder(file)


@pytest.mark.parametrize('name', ['check', 'live', 'record', 'calibrate handeye'])
def test_examples_for_a_rig_name_its_parameters(name: str) -> None:
    outside_tables = re.sub(r'^\|.*$', '', README, flags=re.MULTILINE)
    found = re.findall(rf'\./bpc {name} [^`\n]*--(?:handeye|out|mount)\b[^`\n]*', outside_tables)
    assert found
    for command in found:
        assert '--params' in command, command


@pytest.mark.parametrize('name', TEXTS)
def test_commands_exist(name: str) -> None:
    known = options()
    found = re.findall(r'\./bpc ([a-z]+)([^`\n|#;]*)', TEXTS[name])
    for command, rest in found:
        assert command == ENV or command in known, command
        own = rest.split(' -- ')[0]
        for option in re.findall(r'(?<=\s)--[a-z-]+', own):
            assert option in known[command], (command, option)


def test_every_command_is_in_the_table() -> None:
    for command in options():
        assert f'\n| `./bpc {command}' in README, command


def test_options_named_beside_a_command_exist() -> None:
    known = options()
    for row in re.findall(r'^\| `\./bpc ([a-z]+).*$', README, re.MULTILINE):
        line = next(line for line in README.splitlines() if line.startswith(f'| `./bpc {row}'))
        for option in re.findall(r'`(--[a-z-]+)', line):
            assert option in known[row], (row, option)


@pytest.mark.parametrize('name', TEXTS)
def test_files_exist(name: str) -> None:
    links = re.findall(r'\]\(([^)#:]+)\)', TEXTS[name])
    programs = re.findall(r'python ([a-z_/]+\.py)', TEXTS[name])
    for target in links:
        assert ((ROOT / name).parent / target).exists(), target
    for target in programs:
        assert (ROOT / target).exists(), target


@pytest.mark.parametrize('name', ['README.md', 'CONTRIBUTING.md', 'docs/faults.md'])
def test_tests_exist(name: str) -> None:
    found = re.findall(r'(?:pytest|\./bpc test --)((?: [^\s`]+)+)', TEXTS[name])
    arguments = [each for command in found for each in command.split()]
    for file in arguments:
        assert not file.endswith('.py') or (ROOT / file).exists(), file
    chosen = [after for option, after in pairwise(arguments) if option == '-k']
    assert chosen
    for part in chosen:
        assert any(part in test for test in TESTS), part


def test_sections_linked_to_exist() -> None:
    headings = {re.sub(r'[^a-z0-9_ -]', '', line.lstrip('# ').lower()).replace(' ', '-')
                for line in README.splitlines() if line.startswith('#')}
    for anchor in re.findall(r'\]\(#([^)]+)\)', README):
        assert anchor in headings, anchor


def test_launch_files_and_their_arguments_exist() -> None:
    calls = re.findall(r'ros2 launch (\w+) (\w+\.launch\.py)(.*)', README)
    assert calls
    for package, file, rest in calls:
        path = ROOT / package / 'launch' / file
        for argument in re.findall(r'(\w+):=', rest):
            assert argument in launch_arguments(path), (file, argument)
    live = launch_arguments(ROOT / 'bpc_perception' / 'launch' / 'live.launch.py')
    for argument in re.findall(r'`(\w+):=', README):
        assert argument in live, argument


@pytest.mark.parametrize('package', ['bpc_perception', 'bpc_sim'])
def test_launched_nodes_are_installed(package: str) -> None:
    setup = (ROOT / package / 'setup.py').read_text(encoding='utf-8')
    launched: set[str] = set()
    for path in ROOT.glob('bpc_*/launch/*.launch.py'):
        text = path.read_text(encoding='utf-8')
        compile(text, path, 'exec')
        if package == 'bpc_sim':
            text = ''.join(re.findall(r"package='bpc_sim', executable='\w+'", text))
        else:
            text = re.sub(r"package='(bpc_sim|zivid_camera)', executable='\w+'", '', text)
        launched |= set(re.findall(r"executable='(\w+)'", text))
    assert launched
    for executable in launched:
        assert f"'{executable} = {package}." in setup, executable


@pytest.mark.parametrize('node', ['path_recorder', 'thickness', 'composed', 'extruder_bridge'])
def test_what_rosdep_lacks_of_a_node_is_installed_by_pip(node: str) -> None:
    needed = {name.split('.')[0] for name in loaded_with(f'bpc_perception.nodes.{node}', set())}
    installed = re.findall(r'^python3 -m pip install .*$',
                           section('With an installed ROS 2 Jazzy'), re.MULTILINE)
    assert needed & NOT_OF_ROSDEP <= set(' '.join(installed).split())


def test_every_topic_is_described() -> None:
    for name in topics.CAMERA | topics.PRINT | topics.RESULTS:
        assert f'| `{name}` |' in README, name


def test_what_is_recorded_is_listed() -> None:
    kept, = re.findall(r'\nIt keeps, (.*?)\. Not kept', README, re.DOTALL)
    assert set(re.findall(r'`([\w/]+)`', kept)) == {
        *topics.CAMERA, *topics.PRINT, *topics.ROBOT, *topics.RESULTS}


def test_every_status_and_scenario_is_described() -> None:
    for status in Status:
        assert f'\n| `{status.name}` |' in README, status
    for scenario in SCENARIOS:
        assert f'`{scenario}`' in README, scenario


def test_picture_is_small() -> None:
    picture = ROOT / 'docs' / 'overlay.png'
    assert picture.stat().st_size < 200_000
    image = cv2.imread(str(picture))
    assert image is not None
    assert min(image.shape[:2]) > 300
