"""What holds the packages together: layers, declared dependencies, one version."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
import re
import subprocess
import sys
from xml.etree import ElementTree

import pytest

import bpc_perception

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = sorted(ROOT.glob('*/package.xml'))
IDS = [file.parent.name for file in PACKAGES]
SOURCE = Path(bpc_perception.__file__).parent
CORE = sorted((SOURCE / 'core').rglob('*.py'))
ROS = re.compile(r'^(rclpy|rosidl\w*|rpyutils|ament_\w+|\w+_(msgs|interfaces))$')

# Python module to the name in package.xml, where the two differ.
KEYS = {'cv2': 'python3-opencv', 'hypothesis': 'python3-hypothesis', 'jinja2': 'python3-jinja2',
        'numpy': 'python3-numpy', 'pytest': 'python3-pytest', 'rich': 'python3-rich',
        'scipy': 'python3-scipy', 'typer': 'python3-typer', 'yaml': 'python3-yaml',
        'serial': 'python3-serial', 'markupsafe': 'python3-jinja2'}  # a part of it
# Without a rosdep key for Ubuntu 24.04; bootstrap/stock.lock has them.
WITHOUT_KEY = {'mcap', 'rosbags', 'lz4', 'zstandard', 'ticlib', 'plotly', 'apsw', 'nicegui',
               'selenium'}
# What NiceGUI stands on, and the page with it.
WITHOUT_KEY |= {'fastapi', 'starlette', 'uvicorn'}
# Extras in setup.py, imported when asked for.
EXTRAS = {'matplotlib', 'dask', 'distributed', 'mitsuba', 'openpyxl', 'pyarrow', 'shapely',
          'statsmodels'}
# The floor plan. A module imports from its own room and from those above it in this list, never
# from those below. A room within a room may stand apart: the longest name that fits counts.
FLOOR_PLAN = {
    'bpc_perception': (
        'core.arrays', 'core.geometry', 'core.filters', 'core.parameter', 'core.robot',
        'core.capture.colour_space', 'core.config', 'core.extruder', 'core.capture', 'core.path',
        'core.targets', 'core.stroke_ends', 'core.profile', 'core.amounts', 'core.design',
        'core.printability', 'core.testprints', 'core.window', 'core.measurement.view',
        'core.measurement.bed',
        'core.measurement.scale', 'core.measurement.side_points', 'core.measurement.verdicts',
        'core.measurement.samples', 'core.measurement.track', 'core.measurement.kept',
        'core.measurement.cross_section.sections', 'core.measurement.cross_section.appearance',
        'core.measurement.cross_section.pooled_fit',
        'core.measurement.cross_section.by_cloud', 'core.measurement.cross_section.edges',
        'core.measurement.cross_section',
        'core.measurement.cross_section.on_ink', 'core.measurement.paper', 'core.measurement',
        'core.advice', 'core.learning', 'core.inspection', 'core.repair', 'core.control',
        'core.calibration',
        'core.watch', 'core.result', 'core.session', 'core',
        'display', 'claims', 'files', 'messages', 'recording', 'report', 'runtime.exit_status',
        'runtime.held_warnings', 'runtime.transport', 'runtime', 'drivers', 'page',
        'nodes.parts', 'nodes', 'batch', 'cli.parts', 'cli', '__main__'),
    'bpc_sim': (
        'ink', 'scene', 'printer', 'closed_loop', 'config', 'stress', 'raytraced', 'doubles',
        'nodes', 'studies', 'benchmarks', 'cli.parts', 'cli'),
}
MOST_MODULES = 14  # in a room: one look has to take them in


def imported(file: Path) -> Iterator[str]:
    """The modules that a file imports, with all dots."""
    for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield str(node.module)
            yield from (f'{node.module}.{alias.name}' for alias in node.names)


def foreign(files: list[Path], own: set[str]) -> set[str]:
    """Top-level modules that files import and that are neither Python's nor their own."""
    found = {name.split('.')[0] for file in files for name in imported(file)}
    return found - set(sys.stdlib_module_names) - own


def declared(package: Path, *kinds: str) -> set[str]:
    """The names in a package.xml's elements of these kinds."""
    root = ElementTree.parse(package).getroot()
    return {str(element.text) for kind in kinds for element in root.iter(kind)}


def sources(package: str) -> list[Path]:
    """The modules of one of our packages, but for those that only say what a room is for."""
    return sorted((ROOT / package / package).rglob('*.py'))


def dotted(file: Path, package: str) -> str:
    """The name by which a module is imported, without its package's."""
    parts = file.relative_to(ROOT / package / package).with_suffix('').parts
    return '.'.join(part for part in parts if part != '__init__')


def place(module: str, package: str) -> int:
    """Where in the floor plan a module of a package stands."""
    plan = FLOOR_PLAN[package]
    room = max((room for room in plan if f'{module}.'.startswith(f'{room}.')), key=len, default='')
    assert room, f'{package}.{module}: expected a room of the floor plan, found none'
    return plan.index(room)


def test_the_core_has_modules() -> None:
    assert len(CORE) > 40


def test_the_core_loads_without_ros() -> None:
    names = ', '.join(f'bpc_perception.{dotted(file, "bpc_perception")}' for file in CORE)
    script = f'import sys, {names}; print(*sys.modules)'
    ended = subprocess.run([sys.executable, '-c', script], capture_output=True, text=True,
                           timeout=60, check=True)
    loaded = {name.split('.')[0] for name in ended.stdout.split()}
    assert 'numpy' in loaded
    assert {name for name in loaded if ROS.match(name)} == set()


@pytest.mark.parametrize('file', CORE, ids=lambda file: dotted(file, 'bpc_perception'))
def test_the_core_knows_nothing_of_what_is_above_it(file: Path) -> None:
    for module in imported(file):
        assert not ROS.match(module.split('.')[0]), module
        if module.startswith('bpc_'):
            assert module.startswith('bpc_perception.core'), module


@pytest.mark.parametrize('package', FLOOR_PLAN)
def test_imports_go_one_way_through_the_floor_plan(package: str) -> None:
    modules = {dotted(file, package) for file in sources(package)}
    wrong = []
    for file in sources(package):
        name = dotted(file, package)
        for found in imported(file):
            other = found.removeprefix(f'{package}.')
            if other == found or other not in modules or not name:
                continue
            if place(other, package) > place(name, package):
                wrong.append(f'{name} imports {other}')
    assert wrong == []


def test_the_product_does_not_import_its_simulator() -> None:
    files = [*sources('bpc_perception'), *(ROOT / 'bpc_perception').glob('launch/*.py'),
             *(ROOT / 'bpc_perception' / 'test').rglob('*.py')]
    assert len(files) > 100
    assert [file for file in files for name in imported(file)
            if name.split('.')[0] == 'bpc_sim'] == []


def test_every_import_of_ours_exists() -> None:
    """Also the late ones, and those of scripts; mypy ignores modules that are not there."""
    places = {'bpc_perception': ROOT / 'bpc_perception', 'bpc_sim': ROOT / 'bpc_sim',
              'bpc_system_tests': ROOT / 'test'}
    files = [file for place in places.values() for file in place.rglob('*.py')]
    assert len(files) > 300
    missing = []
    for file in files:
        for name in imported(file):
            package, *parts = name.split('.')
            if package not in places or not parts:
                continue
            # The last part may be something in a module.
            module = places[package].joinpath(package, *parts)
            holder = module.parent
            here = any(path.exists() for path in (module, module.with_suffix('.py')))
            source = next((path.read_text('utf-8') for path in (
                holder.with_suffix('.py'), holder / '__init__.py') if path.exists()), '')
            if not here and not re.search(rf'\b{parts[-1]}\b', source):
                missing.append(f'{file.relative_to(ROOT)}: {name}')
    assert missing == []


@pytest.mark.parametrize('package', FLOOR_PLAN)
def test_a_room_is_taken_in_at_one_look(package: str) -> None:
    rooms = Counter(file.parent for file in sources(package) if file.name != '__init__.py')
    assert {room: count for room, count in rooms.items() if count > MOST_MODULES} == {}


@pytest.mark.parametrize('package', PACKAGES, ids=IDS)
def test_package_xml_names_every_module_used(package: Path) -> None:
    name = str(ElementTree.parse(package).findtext('name'))
    folder = package.parent / name
    files = [*folder.rglob('*.py'), *package.parent.glob('launch/*.py')]
    if name == 'bpc_system_tests':
        files = []
    names = declared(package, 'exec_depend', 'depend')
    needed = {KEYS.get(module, module) for module in foreign(files, {name}) - WITHOUT_KEY - EXTRAS}
    assert needed - names == set()


@pytest.mark.parametrize('package', PACKAGES, ids=IDS)
def test_package_xml_names_every_module_that_tests_use(package: Path) -> None:
    name = str(ElementTree.parse(package).findtext('name'))
    folder = 'bpc_system_tests' if name == 'bpc_system_tests' else 'test'
    files = [*(package.parent / folder).rglob('*.py')]
    names = declared(package, 'exec_depend', 'depend', 'test_depend') | {name}
    own = {name, *(file.stem for file in files)}
    needed = {KEYS.get(module, module) for module in foreign(files, own) - WITHOUT_KEY - EXTRAS}
    assert needed - names == set()


def test_all_packages_have_one_version() -> None:
    versions = {str(file.relative_to(ROOT)): str(ElementTree.parse(file).findtext('version'))
                for file in PACKAGES}
    for setup in ROOT.glob('*/setup.py'):
        versions[str(setup.relative_to(ROOT))] = re.findall(
            r"version='([^']+)'", setup.read_text())[0]
    for module in ROOT.glob('bpc_*/bpc_*/__init__.py'):
        for found in re.findall(r"^__version__ = '([^']+)'", module.read_text(), re.M):
            versions[str(module.relative_to(ROOT))] = found
    assert len(versions) >= 8
    assert set(versions.values()) == {bpc_perception.__version__}


def test_every_module_is_described() -> None:
    for file in SOURCE.rglob('*.py'):
        assert ast.get_docstring(ast.parse(file.read_text(encoding='utf-8'))), file
