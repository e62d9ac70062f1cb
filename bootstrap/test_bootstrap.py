"""Tests of the set-up that need neither network nor compiler."""

# The names of the tests say what they check.
# ruff: noqa: D103

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import subprocess
import sys

import pytest

from bootstrap import (
    cmake_repair,
    environment,
    main,
    path_order,
    places,
    progress,
    python_choice,
    ros,
    stamps,
    venv,
    workspace,
)
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
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with one file of each kind."""
    monkeypatch.delenv('BPC_PYTHON', raising=False)
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


def completed(checkout: Path, python: str, name: str = 'made') -> venv.Venv:
    """Make the stamp of a checkout's environment, as if it were complete."""
    made = venv.Venv(checkout, None, checkout / places.FOLDER / name)
    made.python.parent.mkdir(parents=True)
    made.python.touch()
    (made.path / places.IN_USE_NAME).touch()
    places.complete(made.path, made.stamp(python))
    return made


def built(checkout: Path, made: venv.Venv, name: str = 'build') -> workspace.Workspace:
    """Make the stamp of a build, as if it were complete."""
    path = checkout / places.FOLDER / name
    for package in stamps.PYTHON_PACKAGES:
        (path / 'build' / package).mkdir(parents=True)
    (path / places.IN_USE_NAME).touch()
    places.complete(path, workspace.stamp(made))
    return workspace.Workspace(made, path)


def test_environment_is_made_again_when_its_lock_changed(checkout: Path) -> None:
    made = completed(checkout, '3.11')
    assert venv.find(checkout, None) == made
    made.lock.write_text('changed')
    assert venv.find(checkout, None) is None


def test_environment_is_made_again_for_stock_jazzy(checkout: Path) -> None:
    completed(checkout, '3.11')
    assert venv.find(checkout, checkout / 'rclpy') is None


def test_half_made_environment_is_made_again(checkout: Path) -> None:
    made = completed(checkout, '3.11')
    (made.path / places.STAMP_NAME).unlink()
    assert venv.find(checkout, None) is None


def test_only_an_asked_for_python_needs_another_environment(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    completed(checkout, '3.99')
    assert venv.find(checkout, None)
    monkeypatch.setenv('BPC_PYTHON', 'python3')
    assert not venv.find(checkout, None)


def test_of_several_environments_that_of_the_last_start_is_taken(checkout: Path) -> None:
    for name in 'abc':
        completed(checkout, '3.11', name)
    places.point_to(checkout, checkout / places.FOLDER / 'b')
    found = venv.find(checkout, None)
    assert found
    assert found.path.name == 'b'
    assert (checkout / '.venv').resolve() == found.path


def test_a_build_belongs_to_its_environment_and_its_messages(checkout: Path) -> None:
    made, other = completed(checkout, '3.11'), completed(checkout, '3.12', 'other')
    there = built(checkout, made)
    assert workspace.find(made) == there
    assert workspace.find(other) is None
    (checkout / 'bpc_interfaces/msg/A.msg').write_text('changed')
    assert workspace.find(made) is None


@pytest.fixture
def aged(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout in which everything was started long ago."""
    monkeypatch.setattr(places, 'KEPT_S', -1.0)
    return checkout


def test_what_was_started_long_ago_is_removed(aged: Path) -> None:
    made = built(aged, completed(aged, '3.11'))
    old = built(aged, completed(aged, '3.12', 'old'), 'old build')
    main.tidy(aged, made)
    assert sorted(places.existing(aged)) == sorted(made.places)
    assert not any(place.exists() for place in old.places)


def test_what_was_started_of_late_stays_for_shells(checkout: Path) -> None:
    made, other = built(checkout, completed(checkout, '3.11')), completed(checkout, '3.12', 'b')
    main.tidy(checkout, made)
    assert other.is_current()


def test_what_was_never_completed_is_removed(checkout: Path) -> None:
    made = built(checkout, completed(checkout, '3.11'))
    half = completed(checkout, '3.12', 'half').path
    (half / places.STAMP_NAME).unlink()
    (checkout / places.FOLDER / 'empty').mkdir()
    main.tidy(checkout, made)
    assert sorted(places.existing(checkout)) == sorted(made.places)


@pytest.fixture
def holder(aged: Path) -> Iterator[subprocess.Popen[str]]:
    """What ./bpc becomes: it holds an environment over the execution of another program."""
    code = (
        'import os, sys; from pathlib import Path; from bootstrap import places;'
        'places.hold(Path(sys.argv[1])); os.execvp("cat", ["cat"])'
    )
    held = completed(aged, '3.12', 'held').path
    with subprocess.Popen(
        [sys.executable, '-c', code, held], cwd=ROOT,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
    ) as process:  # fmt: skip
        assert process.stdin
        assert process.stdout
        process.stdin.write('executed\n')
        assert process.stdout.readline() == 'executed\n'
        yield process


def test_what_runs_keeps_its_environment(aged: Path, holder: subprocess.Popen[str]) -> None:
    made, held = built(aged, completed(aged, '3.11')), aged / places.FOLDER / 'held'
    main.tidy(aged, made)
    assert held.exists()
    holder.communicate()
    main.tidy(aged, made)
    assert not held.exists()


def test_what_is_being_removed_is_not_started(aged: Path) -> None:
    made = completed(aged, '3.11').path
    assert not places.is_held(made)
    assert not places.hold(made)


@contextmanager
def running(cat: str, folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Run a link to cat until it can be seen what runs: right after its start it cannot."""
    with subprocess.Popen(
        [cat], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    ) as process:
        assert process.stdin
        assert process.stdout
        process.stdin.write('runs\n')
        assert process.stdout.readline() == 'runs\n'
        yield process


def test_what_was_started_by_hand_keeps_its_environment(aged: Path) -> None:
    made, by_hand = built(aged, completed(aged, '3.11')), completed(aged, '3.12', 'by hand')
    by_hand.python.unlink()
    by_hand.python.symlink_to('/bin/cat')
    with running(str(by_hand.python), aged) as process:
        main.tidy(aged, made)
        assert by_hand.path.exists()
        process.communicate()
    main.tidy(aged, made)
    assert not by_hand.path.exists()


@pytest.fixture
def earlier(checkout: Path) -> Path:
    """A checkout as earlier versions of the set-up left it."""
    (checkout / '.venv' / 'bin').mkdir(parents=True)
    (checkout / '.venv' / 'bin' / 'python').symlink_to('/bin/cat')
    (checkout / 'build').mkdir()
    (checkout / 'install').mkdir()
    places.complete(checkout / 'install', 'a stamp')
    return checkout


def test_folders_of_earlier_versions_stay_while_something_runs(earlier: Path) -> None:
    made = built(earlier, completed(earlier, '3.11'))
    folders = [earlier / name for name in ('.venv', 'build', 'install')]
    with running('./.venv/bin/python', earlier) as process:
        main.tidy(earlier, made)
        assert all(folder.is_dir() and not folder.is_symlink() for folder in folders)
        process.communicate()
    main.tidy(earlier, made)
    assert [folder.exists() for folder in folders] == [True, False, False]
    assert (earlier / '.venv').resolve() == made.venv.path


def test_a_workspace_that_was_built_without_us_stays(earlier: Path) -> None:
    (earlier / 'install' / places.STAMP_NAME).unlink()
    main.tidy(earlier, built(earlier, completed(earlier, '3.11')))
    assert (earlier / 'build').is_dir()
    assert (earlier / 'install').is_dir()


def test_an_environment_that_fails_leaves_no_trace(checkout: Path) -> None:
    before = completed(checkout, '3.11')

    def fail() -> None:
        with places.new(checkout, '3.12') as place:
            (place / 'half').touch()
            raise SetupError('no connection')

    with pytest.raises(SetupError):
        fail()
    assert places.existing(checkout) == [before.path]


def test_too_little_space_is_said_before_anything_is_made(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(venv, 'NEEDED_SPACE_BYTES', 1e18)
    before = completed(checkout, '3.99').path
    monkeypatch.setenv('BPC_PYTHON', 'python3')
    (checkout / places.FOLDER / 'left by a killed one').mkdir()
    with pytest.raises(SetupError, match=r'needs 1000000000\.0 GB of disk'):
        main.set_up(checkout, None)
    assert places.existing(checkout) == [before]


def test_a_killed_set_up_leaves_nothing_running(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'fifo')
    code = (
        'import os, sys; from pathlib import Path; from bootstrap.progress import run_logged;'
        'run_logged(["sh", "-c", "(echo runs; tail -f /dev/null) > fifo; true"],'
        'Path("log").absolute(), cwd=Path.cwd(), environment=os.environ)'
    )
    with (
        subprocess.Popen(
            [sys.executable, '-c', code], cwd=tmp_path, env={**os.environ, 'PYTHONPATH': str(ROOT)}
        ) as process,
        (tmp_path / 'fifo').open() as written,
    ):
        assert written.readline() == 'runs\n'
        process.kill()
        assert written.read() == ''  # its end comes when nobody can write any more


def test_cmake_exports_name_this_python() -> None:
    export = (
        'set(dirs "${_IMPORT_PREFIX}/include/std_msgs;'
        '/opt/python/cp312-cp312/include/python3.12;'
        '/opt/python/cp312-cp312/lib/python3.12/site-packages/numpy/_core/include")\n'
    )
    assert cmake_repair.repaired(export, '/usr/include/python3.12', '/v/numpy/include') == (
        'set(dirs "${_IMPORT_PREFIX}/include/std_msgs;/usr/include/python3.12;/v/numpy/include")\n'
    )


def test_a_repaired_export_leaves_its_file_in_the_cache_as_it_is(tmp_path: Path) -> None:
    cache, export = tmp_path / 'cache', tmp_path / 'share' / 'a' / 'cmake' / 'a.cmake'
    export.parent.mkdir(parents=True)
    cache.write_text('/opt/python/cp312-cp312/include/python3.12\n')
    export.hardlink_to(cache)
    assert cmake_repair.repair_exports(tmp_path, '/usr/include/python3.12', '/numpy') == 1
    assert export.read_text() == '/usr/include/python3.12\n'
    assert cache.read_text().startswith('/opt/python')


def test_reason_of_a_failed_build() -> None:
    log = 'Starting >>> a\nFailed   <<< a [0.5s, exited with code 1]\nSummary: 0 packages\n'
    assert workspace.why_colcon_failed(log) == 'a failing'


def test_another_distribution_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SetupError, match='needs ROS 2 jazzy, found humble sourced'):
        ros.stock_rclpy({'ROS_DISTRO': 'humble'}, tmp_path)


def test_users_own_settings_stay(checkout: Path) -> None:
    given = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET', 'ROS_LOG_DIR': '/logs'}
    values = environment.variables(completed(checkout, '3.11'), given, None)
    assert values['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'SUBNET'
    assert values['ROS_LOG_DIR'] == '/logs'
    assert values['RMW_IMPLEMENTATION'] == 'rmw_fastrtps_cpp'


def test_own_packages_win_over_those_in_pythonpath(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own, foreign = str(checkout / 'bpc_perception'), '/other/numpy'
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join([foreign, own, '']))
    monkeypatch.setattr(sys, 'path', ['', foreign, own, '/lib/python3.11', '/site-packages'])
    path_order.put_last(str(checkout))
    assert sys.path == ['', own, '/lib/python3.11', '/site-packages', foreign]


def test_each_start_of_an_environment_orders_its_paths(checkout: Path) -> None:
    made = venv.Venv(checkout, None, checkout / 'made')
    packages = made.path / 'lib' / f'python{venv.own_version()}' / 'site-packages'
    packages.mkdir(parents=True)
    venv.order_paths(made)
    code = f'import site, sys; site.addsitedir({str(packages)!r}); print(sys.path[-1])'
    ended = subprocess.check_output(
        [sys.executable, '-c', code], env={'PYTHONPATH': '/other/numpy'}, text=True
    )
    assert ended == '/other/numpy\n'


def test_settings_for_other_pythons_are_left_out() -> None:
    given = {'PYTHONHOME': '/other', 'PYTHONDONTWRITEBYTECODE': '1', 'PYTHONPATH': '/mine'}
    assert progress.without_settings(given) == {'PYTHONPATH': '/mine'}
    assert environment.exports({'BPC_ROOT': '/r'}, given) == (
        'unset PYTHONDONTWRITEBYTECODE\nunset PYTHONHOME\nexport BPC_ROOT=/r\n'
    )


def test_the_home_of_another_python_does_not_keep_the_command_from_starting() -> None:
    given = {**os.environ, 'PYTHONHOME': '/nowhere', 'BPC_PYTHON': '/nowhere/python'}
    ended = subprocess.run([ROOT / 'bpc'], env=given, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (
        2, 'bpc: BPC_PYTHON should name a Python 3.10-3.13, but /nowhere/python does not run\n'
    )  # fmt: skip


def test_environment_set_twice_is_the_same(checkout: Path) -> None:
    target = built(checkout, completed(checkout, '3.11'))
    once = environment.variables(target.venv, {'PATH': '/bin', 'PYTHONPATH': '/mine'}, target.path)
    assert environment.variables(target.venv, once, target.path) == once
    assert once['PYTHONPATH'].endswith(':/mine')


def test_a_shell_with_an_earlier_environment_gets_rid_of_it(checkout: Path) -> None:
    old = built(checkout, completed(checkout, '3.11', 'old'), 'old build')
    given = environment.variables(old.venv, {'PATH': '/bin'}, old.path)
    target = built(checkout, completed(checkout, '3.11'))
    values = environment.variables(target.venv, given, target.path)
    assert not [name for name, value in values.items() if f'{places.FOLDER}/old' in value]
    assert values['PATH'].endswith(':/bin')


def test_unusable_sourced_ros_is_kept_out(checkout: Path) -> None:
    given = {'ROS_DISTRO': 'jazzy', 'PYTHONPATH': '/opt/ros/jazzy/lib/python3.12/site-packages'}
    target = built(checkout, completed(checkout, '3.11'))
    values = environment.variables(target.venv, given, target.path)
    assert '/opt/ros' not in values['PYTHONPATH']
