"""What the tables say is so: parameters, topics, quality of service, files, packages."""

from __future__ import annotations

import ast
from pathlib import Path
import re

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
import yaml

from bpc_perception.batch.table import COLUMNS as BATCH_COLUMNS
from bpc_perception.core.config import CameraConfig
from bpc_perception.core.parameter import flatten
from bpc_perception.files.parameter_file import configure, live_recorder
from bpc_perception.messages import topics
from bpc_perception.report.control.tables import CAPABILITY, CONTROL
from bpc_perception.report.profile_table import COLUMNS, DESIGN_COLUMNS
from bpc_perception.report.repair_table import COLUMNS as REPAIR_COLUMNS
from bpc_perception.report.tables.table import Column
from bpc_sim.closed_loop.situations import SITUATIONS
from bpc_system_tests.documentation import parameter_tables, reference
from bpc_system_tests.documentation.pages import (
    blocks,
    DOCS,
    links,
    NODE_PAGES,
    read,
    ROOT,
    section,
    table_rows,
)

FIRST_PRINT = DOCS / 'tutorials' / 'first_print.md'
INSTALLED = DOCS / 'tutorials' / 'installed_jazzy.md'
FILES = DOCS / 'reference' / 'files.md'
REMAKE = 'made anew by: python test/bpc_system_tests/documentation/reference.py'
# Packages for which rosdep has no key, or one that Ubuntu 24.04 refuses.
NOT_OF_ROSDEP = {'mcap', 'rosbags', 'lz4', 'zstandard', 'plotly', 'ticlib', 'matplotlib',
                 'distributed', 'pyarrow', 'nicegui'}
QOS = {'camera': topics.CAMERA_QOS, 'camera info': topics.CAMERA_INFO_QOS,
       'pose': topics.POSE_QOS, 'extruder': topics.EXTRUSION_QOS, 'path': topics.PATH_QOS,
       'update': topics.UPDATE_QOS, 'result': topics.RESULT_QOS, 'repair': topics.REPAIR_QOS,
       'view': topics.VIEW_QOS}


def loaded_with(module: str, known: set[str]) -> set[str]:
    """Add to the names known all that is imported as soon as a module of ours is."""
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


def quality(profile: QoSProfile) -> list[str]:
    """Return a quality of service in the words of the table."""
    reliable = profile.reliability == ReliabilityPolicy.RELIABLE
    kept = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return ['reliable' if reliable else 'best effort', 'transient local' if kept else 'volatile',
            f'keep last {profile.depth}']


@pytest.mark.parametrize('path', [path for path, _ in reference.files()],
                         ids=lambda path: path.name)
def test_what_is_generated_is_current(path: Path) -> None:
    wanted = dict(reference.files())[path]
    assert path.read_text(encoding='utf-8') == wanted, REMAKE


def test_every_node_has_a_page_with_its_parameters() -> None:
    assert {page.stem for page in NODE_PAGES.glob('*.md')} == set(parameter_tables.TABLES)


@pytest.mark.parametrize('node', parameter_tables.FILES)
def test_parameter_file_gives_the_defaults(node: str) -> None:
    default = parameter_tables.FILES[node]()
    path = parameter_tables.CONFIG / f'{node}.yaml'
    assert configure(default, node, path) == default
    text = path.read_text(encoding='utf-8')
    for page in (FIRST_PRINT, FILES):
        assert path in {(page.parent / target).resolve() for target in links(page)}
    assert all(f'\n    {name}: ' in text for name, _, _ in flatten(default))


def test_the_example_for_a_printer_is_whole_and_accepted(tmp_path: Path) -> None:
    example, = blocks(section(FIRST_PRINT, 'Parameter file'), 'yaml')
    assert set(yaml.safe_load(example)) == {'/**', *parameter_tables.FILES}
    file = tmp_path / 'cell.yaml'
    file.write_text(example)
    for node, kind in parameter_tables.FILES.items():
        configure(kind(), node, file)
    assert configure(CameraConfig(), 'camera_driver', file).rate > 0  # or it takes nothing
    live_recorder(file)


@pytest.mark.parametrize('node', ['path_recorder', 'thickness', 'composed', 'extruder_bridge'])
def test_what_rosdep_lacks_of_a_node_is_installed_by_pip(node: str) -> None:
    needed = {name.split('.')[0] for name in loaded_with(f'bpc_perception.nodes.{node}', set())}
    installed = re.findall(r'^python3 -m pip install .*$', read(INSTALLED), re.MULTILINE)
    assert needed & NOT_OF_ROSDEP <= set(' '.join(installed).split())


@pytest.mark.parametrize(('node', 'described'), [
    ('camera_driver', topics.CAMERA), ('thickness', topics.CAMERA),
    ('path_recorder', {topics.EXTRUSION: '', topics.PATH: ''}),
    ('extruder_bridge', {topics.EXTRUSION: ''}),
    ('thickness', {topics.PROFILE: '', topics.ADVICE: '', topics.OVERLAY: ''}),
    ('bag_player', {topics.EXTRUSION: ''})])
def test_topics_of_a_node_are_described(node: str, described: dict[str, object]) -> None:
    for name in described:
        assert f'\n| `{name}` |' in read(NODE_PAGES / f'{node}.md'), name


def test_every_topic_is_described() -> None:
    text = ''.join(read(page) for page in sorted(NODE_PAGES.glob('*.md')))
    for name in topics.CAMERA | topics.PRINT | topics.RESULTS:
        assert f'| `{name}` |' in text, name


def test_the_quality_of_service_is_that_of_the_topics() -> None:
    rows = table_rows(section(DOCS / 'reference' / 'nodes.md', 'Quality of service'))
    assert {name.strip('*'): row for name, *row in rows} == {
        name: quality(profile) for name, profile in QOS.items()}


def test_quality_of_service_is_named_as_in_its_table() -> None:
    for page in NODE_PAGES.glob('*.md'):
        for table in re.findall(r'^\| .* QoS \|\n(?:\|.*\n)+', read(page), re.MULTILINE):
            for row in table_rows(table):
                assert row[-1] in QOS or row[-1].startswith('reliable, '), (page, row)


def test_what_is_recorded_is_listed() -> None:
    kept, = re.findall(r'it keeps (.*?)\.\n', section(
        NODE_PAGES / 'bag_recorder.md', 'What it keeps'), re.DOTALL)
    assert set(re.findall(r'`([\w/]+)`', kept)) == {
        *topics.CAMERA, *topics.PRINT, *topics.ROBOT, *topics.RESULTS}


def test_the_columns_of_a_profile_are_listed() -> None:
    text = section(FILES, 'Results')
    assert f'`{",".join(COLUMNS)}`' in text.replace('\n', '')
    described = [name for row in table_rows(text) for name in re.findall(r'`(\w+)`', row[0])]
    assert described == [*COLUMNS, *DESIGN_COLUMNS]


def test_the_columns_of_a_repair_are_listed() -> None:
    rows = table_rows(section(FILES, 'repair.csv'))
    assert [name for row in rows for name in re.findall(r'`(\w+)`', row[0])] == [*REPAIR_COLUMNS]


def test_the_columns_of_a_batch_are_listed() -> None:
    rows = table_rows(section(FILES, 'Table of many prints'))
    described = [name for row in rows for name in re.findall(r'`(\w+)`', row[0])]
    assert sorted(described) == sorted(column.name for column in BATCH_COLUMNS)


@pytest.mark.parametrize(('title', 'columns'), [
    ('control', CONTROL), ('capability', CAPABILITY)])
def test_the_columns_of_control_charts_are_listed(title: str, columns: tuple[Column, ...]) -> None:
    text = section(FILES, 'Tables of control charts').split(f'\n### {title}\n')[1]
    rows = table_rows(text.split('\n### ')[0])
    described = [name for row in rows for name in re.findall(r'`(\w+)`', row[0])]
    assert sorted(described) == sorted(column.name for column in columns)


def test_every_closed_loop_situation_is_described() -> None:
    text = read(DOCS / 'figures' / 'closed_loop.md')
    for situation in SITUATIONS:
        assert f'`{situation}`' in text, situation
