"""Tests of the set-up that need neither network nor compiler."""

# The names of the tests say what they check.
# ruff: noqa: D103

import ast
from collections.abc import Callable
from pathlib import Path

import pytest

from bootstrap import cmake_repair, environment, python_choice, ros, stamps, venv, workspace
from bootstrap.progress import SetupError

ROOT = Path(__file__).resolve().parent.parent
Installed = dict[str, tuple[int, ...]]


def probe_of(installed: Installed) -> Callable[..., tuple[int, ...] | None]:
    """Return a probe of a machine on which these commands run."""
    return lambda command, *_: installed.get(command)


@pytest.mark.parametrize('file', ['bpc', 'bootstrap/__init__.py', 'bootstrap/python_choice.py'])
def test_an_old_python_parses_what_it_needs_to_complain(file: str) -> None:
    ast.parse((ROOT / file).read_text(), feature_version=(3, 4))


@pytest.mark.parametrize(
    ('variables', 'own', 'installed', 'command'),
    [
        ({}, (3, 10, 13), {'python3.13': (3, 13)}, None),
        ({}, (3, 13, 0), {}, None),
        ({}, (3, 14, 0), {'python3.11': (3, 11), 'python3.10': (3, 10)}, 'python3.11'),
        ({}, (3, 9, 2), {'python3.12': (3, 12)}, 'python3.12'),
        ({'BPC_PYTHON': '/opt/p'}, (3, 11, 7), {'/opt/p': (3, 12)}, '/opt/p'),
        ({'ROS_DISTRO': 'jazzy'}, (3, 11, 7), {'/usr/bin/python3': (3, 12)}, '/usr/bin/python3'),
        ({'ROS_DISTRO': 'jazzy'}, (3, 12, 3), {}, None),
        ({'ROS_DISTRO': 'jazzy'}, (3, 11, 7), {}, None),
    ],
)
def test_python_is_chosen(
    variables: dict[str, str], own: tuple[int, ...], installed: Installed, command: str | None
) -> None:
    assert python_choice.choose(variables, own, probe_of(installed)) == (command, None)


@pytest.mark.parametrize(
    ('variables', 'own', 'installed', 'found'),
    [
        ({}, (3, 9, 2), {}, 'found 3.9.2 and none of python3.13'),
        ({'BPC_PYTHON': 'p'}, (3, 11, 7), {'p': (3, 14)}, 'but p is 3.14'),
        ({'BPC_PYTHON': 'p'}, (3, 11, 7), {}, 'but p does not run'),
    ],
)
def test_an_unsuitable_python_is_named(
    variables: dict[str, str], own: tuple[int, ...], installed: Installed, found: str
) -> None:
    command, complaint = python_choice.choose(variables, own, probe_of(installed))
    assert command is None
    assert complaint is not None
    assert found in complaint
    assert '3.10-3.13' in complaint
    assert '\n' not in complaint


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout with one file of each kind."""
    for file in (
        'bootstrap/requirements.lock',
        'bootstrap/stock.lock',
        'bpc_interfaces/msg/A.msg',
        'bpc_perception/setup.py',
        'bpc_perception/launch/a.launch.py',
        'bpc_perception/bpc_perception/a.py',
    ):
        path = tmp_path / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f'{file}\n')
    return tmp_path


@pytest.mark.parametrize(
    ('file', 'rebuilt'),
    [
        ('bpc_interfaces/msg/A.msg', True),
        ('bpc_interfaces/srv/New.srv', True),
        ('bpc_perception/setup.py', True),
        ('bpc_perception/launch/new.launch.py', True),
        ('bpc_perception/launch/a.launch.py', False),
        ('bpc_perception/bpc_perception/a.py', False),
        ('bpc_perception/bpc_perception/new.py', False),
    ],
)
def test_only_what_is_not_a_link_is_rebuilt(checkout: Path, file: str, rebuilt: bool) -> None:
    before = stamps.workspace_manifest(checkout)
    assert stamps.workspace_manifest(checkout) == before
    (checkout / file).parent.mkdir(exist_ok=True)
    (checkout / file).write_text('changed')
    assert (stamps.workspace_manifest(checkout) != before) is rebuilt


def completed(checkout: Path, python: str) -> venv.Venv:
    """Make the stamp of a checkout's environment, as if it were complete."""
    made = venv.Venv(checkout, rclpy=None)
    made.python.parent.mkdir(parents=True)
    made.python.touch()
    (made.path / venv.STAMP_NAME).write_text(made.stamp(python))
    return made


def test_environment_is_made_again_when_its_lock_changed(checkout: Path) -> None:
    made = completed(checkout, '3.11')
    assert made.is_current()
    made.lock.write_text('changed')
    assert not made.is_current()


def test_environment_is_made_again_for_stock_jazzy(checkout: Path) -> None:
    completed(checkout, '3.11')
    assert not venv.Venv(checkout, rclpy=checkout / 'rclpy').is_current()


def test_half_made_environment_is_made_again(checkout: Path) -> None:
    made = completed(checkout, '3.11')
    (made.path / venv.STAMP_NAME).unlink()
    assert not made.is_current()


def test_only_an_asked_for_python_replaces_the_environment(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = completed(checkout, '3.99')
    monkeypatch.delenv('BPC_PYTHON', raising=False)
    assert made.is_current()
    monkeypatch.setenv('BPC_PYTHON', 'python3')
    assert not made.is_current()


@pytest.mark.parametrize(
    ('made_from', 'possible'),
    [
        ('python 3.11\nat .venv\nabc setup.py\n', True),
        ('unfinished\npython 3.11\nat .venv\n', True),
        ('python 3.12\nat .venv\nabc setup.py\n', False),
        ('python 3.11\nat .venv\nabc setup.py\nlink config/gone.yaml\n', False),
        ('', False),
    ],
)
def test_build_goes_on_from_an_earlier_one(made_from: str, possible: bool) -> None:
    target = 'python 3.11\nat .venv\ndef setup.py\nlink config/new.yaml\n'
    assert workspace.can_build_upon(made_from, target) is possible


def test_cmake_exports_name_this_python() -> None:
    export = (
        'set(dirs "${_IMPORT_PREFIX}/include/std_msgs;'
        '/opt/python/cp312-cp312/include/python3.12;'
        '/opt/python/cp312-cp312/lib/python3.12/site-packages/numpy/_core/include")\n'
    )
    assert cmake_repair.repaired(export, '/usr/include/python3.12', '/v/numpy/include') == (
        'set(dirs "${_IMPORT_PREFIX}/include/std_msgs;/usr/include/python3.12;/v/numpy/include")\n'
    )


@pytest.mark.parametrize(
    ('log', 'reason'),
    [
        (
            'WARNING: Retrying (Retry(total=0)) after connection broken\n'
            'ERROR: Could not find a version that satisfies a==1 (from versions: none)\n'
            'ERROR: No matching distribution found for a==1\n',
            'no connection; Could not find a version that satisfies a==1 (from versions: none)',
        ),
        (
            'ERROR: Could not install packages due to an OSError: '
            '[Errno 28] No space left on device\n',
            'the disk is full; Could not install packages due to an OSError: '
            '[Errno 28] No space left on device',
        ),
        ('killed\n', 'an error'),
    ],
)
def test_reason_of_a_failed_installation(log: str, reason: str) -> None:
    assert venv.why_pip_failed(log) == reason


def test_reason_of_a_failed_build() -> None:
    log = 'Starting >>> a\nFailed   <<< a [0.5s, exited with code 1]\nSummary: 0 packages\n'
    assert workspace.why_colcon_failed(log) == 'a failing'


def test_build_tools_are_the_locked_ones() -> None:
    wanted = 'setuptools==79 \\\n    --hash=sha256:b\n    # via x\n'
    lock = 'scipy==1 \\\n    --hash=sha256:a\n' + wanted + 'six==1'
    assert venv.build_tools_of(lock) == wanted


def test_another_distribution_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SetupError, match='needs ROS 2 jazzy, found humble sourced'):
        ros.stock_rclpy({'ROS_DISTRO': 'humble'}, tmp_path)


def test_users_own_settings_stay(checkout: Path) -> None:
    given = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'ROS_LOG_DIR': '/logs'}
    values = environment.variables(venv.Venv(checkout, rclpy=None), given)
    assert values['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'SUBNET'
    assert values['ROS_LOG_DIR'] == '/logs'
    assert values['RMW_IMPLEMENTATION'] == 'rmw_fastrtps_cpp'


def test_environment_set_twice_is_the_same(checkout: Path) -> None:
    target = venv.Venv(checkout, rclpy=None)
    once = environment.variables(target, {'PATH': '/bin', 'PYTHONPATH': '/mine'})
    assert environment.variables(target, once) == once
    assert once['PYTHONPATH'].endswith(':/mine')


def test_unusable_sourced_ros_is_kept_out(checkout: Path) -> None:
    given = {'ROS_DISTRO': 'jazzy', 'PYTHONPATH': '/opt/ros/jazzy/lib/python3.12/site-packages'}
    values = environment.variables(venv.Venv(checkout, rclpy=None), given)
    assert '/opt/ros' not in values['PYTHONPATH']
