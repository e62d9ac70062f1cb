"""What holds the packages together: layers, declared dependencies, one version."""

from __future__ import annotations

import ast
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
CORE = sorted(path.stem for path in (SOURCE / 'core').glob('*.py'))
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
EXTRAS = {'matplotlib', 'dask', 'distributed', 'pyarrow'}
# Used where it is installed; it depends on this package itself.
OPTIONAL = {'bpc_perception': {'bpc_sim'}}


def imported(file: Path) -> Iterator[str]:
    """The modules that a file imports, with all dots."""
    for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield str(node.module)


def foreign(files: list[Path], package: str) -> set[str]:
    """Top-level modules that files import and that are neither Python's nor their own."""
    own = {package, *(file.stem for file in files)}
    found = {name.split('.')[0] for file in files for name in imported(file)}
    return found - set(sys.stdlib_module_names) - own - OPTIONAL.get(package, set())


def declared(package: Path, *kinds: str) -> set[str]:
    """The names in a package.xml's elements of these kinds."""
    root = ElementTree.parse(package).getroot()
    return {str(element.text) for kind in kinds for element in root.iter(kind)}


def test_the_core_has_modules() -> None:
    assert len(CORE) > 10


def test_the_core_loads_without_ros() -> None:
    names = ', '.join(f'bpc_perception.core.{name}' for name in CORE if name != '__init__')
    script = f'import sys, {names}; print(*sys.modules)'
    ended = subprocess.run([sys.executable, '-c', script], capture_output=True, text=True,
                           timeout=60, check=True)
    loaded = {name.split('.')[0] for name in ended.stdout.split()}
    assert 'numpy' in loaded
    assert {name for name in loaded if ROS.match(name)} == set()


@pytest.mark.parametrize('name', CORE)
def test_the_core_knows_nothing_of_what_is_above_it(name: str) -> None:
    for module in imported(SOURCE / 'core' / f'{name}.py'):
        assert not ROS.match(module.split('.')[0]), module
        if module.startswith('bpc_'):
            assert module.startswith('bpc_perception.core'), module


@pytest.mark.parametrize('package', PACKAGES, ids=IDS)
def test_package_xml_names_every_module_used(package: Path) -> None:
    name = str(ElementTree.parse(package).findtext('name'))
    folder = package.parent / name
    files = [*folder.rglob('*.py'), *package.parent.glob('launch/*.py')]
    if name == 'bpc_system_tests':
        files = []
    names = declared(package, 'exec_depend', 'depend')
    needed = {KEYS.get(module, module) for module in foreign(files, name) - WITHOUT_KEY - EXTRAS}
    assert needed - names == set()


@pytest.mark.parametrize('package', PACKAGES, ids=IDS)
def test_package_xml_names_every_module_that_tests_use(package: Path) -> None:
    name = str(ElementTree.parse(package).findtext('name'))
    folder = 'bpc_system_tests' if name == 'bpc_system_tests' else 'test'
    files = [*(package.parent / folder).glob('*.py')]
    names = declared(package, 'exec_depend', 'depend', 'test_depend') | {name}
    needed = {KEYS.get(module, module) for module in foreign(files, name) - WITHOUT_KEY - EXTRAS}
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
