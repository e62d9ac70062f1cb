"""Tests of what is installed, and how, without a network."""

# The names of the tests say what they check.
# ruff: noqa: D103

from collections.abc import Callable, Sequence
import os
from pathlib import Path
import subprocess
import sys

import pytest

from bootstrap import main, venv
from bootstrap.installing import extras, lock, packages
from bootstrap.installing.packages import Packages
from bootstrap.progress import SetupError

ROOT = Path(__file__).resolve().parents[2]
LOCKS = [ROOT / 'bootstrap' / name for name in ('requirements.lock', 'stock.lock')]
SMALL = """a==1 \\
    --hash=sha256:a
    # via -r bootstrap/run.in
b==2 ; python_full_version < '3.11' \\
    --hash=sha256:b
    # via
    #   -r bootstrap/page.in
    #   a
b==3 ; python_full_version >= '3.11' \\
    --hash=sha256:c
    # via a
c==4 \\
    --hash=sha256:d
    # via d
d==5 \\
    --hash=sha256:e
    # via
    #   -r bootstrap/page.in
"""


def test_a_part_of_a_lock_is_what_its_files_ask_for_one_way_or_another() -> None:
    assert list(lock.part(SMALL, ['run.in'])) == ['a', 'b']
    assert list(lock.part(SMALL, ['page.in'])) == ['b', 'c', 'd']
    both = lock.part(SMALL, ['run.in', 'page.in'])
    assert ''.join(both.values()) == SMALL
    assert lock.part(SMALL, ['other.in']) == {}


def test_a_package_that_says_no_reason_is_installed_at_first() -> None:
    entry = 'small @ file:///wheels/small-1.whl --hash=sha256:a\n'
    assert venv.at_first(entry) == {'small': entry}


@pytest.mark.parametrize('path', LOCKS, ids=lambda path: str(path.name))
def test_every_package_is_installed_at_first_or_is_of_an_extra(path: Path) -> None:
    text = path.read_text()
    parts = [venv.at_first(text), *(lock.part(text, [f'{name}.in']) for name in extras.EXTRAS)]
    assert set().union(*parts) == {name for name, _ in lock.entries(text)}
    assert {'numpy', 'uv', 'setuptools', 'wheel', 'typer'} <= parts[0].keys()
    assert not {'pyarrow', 'matplotlib', 'nicegui', 'mypy', 'sphinx'} & parts[0].keys()


@pytest.mark.parametrize(
    ('words', 'wanted'),
    [
        ([], set()),
        (['batch', '--help'], set()),
        (['measure', 'bag'], set()),
        (['measure', 'bag', '--figures'], {'figures'}),
        (['live', '--page'], {'page'}),
        (['batch', 'bags', '--figures'], {'batch', 'figures'}),
        (['printability', 'results', '--figures'], {'printability', 'figures'}),
        (['testprint', 'lines'], {'printability'}),
        (['compare', 'a', 'b', '--xlsx'], {'tables'}),
        (['window', 'results', '--figures'], {'window', 'figures'}),
        (['study', 'windows'], {'window'}),
        (['study', 'table1'], set()),
        (['test'], set(extras.EXTRAS)),
        (['env'], set(extras.EXTRAS)),
    ],
)
def test_commands_need_extras(words: list[str], wanted: set[str]) -> None:
    assert extras.needed(words) == wanted


@pytest.fixture
def made(tmp_path: Path) -> venv.Venv:
    """An environment without extras."""
    environment = venv.Venv(tmp_path, None, tmp_path / 'made')
    (tmp_path / 'bootstrap').mkdir()
    environment.lock.write_text(SMALL)
    site = environment.path / 'lib' / f'python{venv.own_version()}' / 'site-packages'
    site.mkdir(parents=True)
    return environment


def installer_of(module: str) -> Callable[[Packages, Path, bool], None]:
    """Return an installer that writes a module of this name."""

    def write(wanted: Packages, _: Path, __: bool) -> None:
        assert wanted.folder
        assert sorted(wanted.entries) == ['c', 'd']  # b is there
        wanted.folder.mkdir()
        (wanted.folder / f'{module}.py').write_text('')

    return write


def test_modules_of_an_extra_are_found_once_it_is_there(
    made: venv.Venv, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    site = str(made.path / 'lib' / f'python{venv.own_version()}' / 'site-packages')
    find = f'import site; site.addsitedir({site!r}); import bpc_only_here'
    command = [sys.executable, '-c', find]
    assert extras.missing(made, ['live', '--page']) == ['page']
    monkeypatch.setattr(packages, 'install', installer_of('bpc_only_here'))
    extras.add(made, ['page'], tmp_path / 'log')
    assert extras.missing(made, ['live', '--page']) == []
    assert subprocess.run(command, check=False).returncode == 0


def test_an_extra_that_cannot_be_had_leaves_no_trace_and_is_said(
    made: venv.Venv, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def fail(wanted: Packages, _: Path, __: bool) -> None:
        assert wanted.folder
        wanted.folder.mkdir()
        (wanted.folder / 'half').touch()
        raise SetupError('expected packages, found: no connection')

    killed = made.path / extras.FOLDER / f'{extras.UNFINISHED}killed'
    killed.mkdir(parents=True)
    monkeypatch.setattr(packages, 'install', fail)
    with pytest.raises(SetupError, match=r'^for --page: .* no connection'):
        main.add_extras(tmp_path, made, ['live', '--page'])
    assert list((made.path / extras.FOLDER).iterdir()) == []
    main.add_extras(tmp_path, made, ['env'])  # a shell does without them
    (tmp_path / 'file').touch()
    monkeypatch.setattr(main, 'LOGS', Path('file', 'setup'))  # somebody else's checkout
    main.add_extras(tmp_path, made, ['env'])
    main.add_extras(tmp_path, made, ['measure'])


def installed_by(monkeypatch: pytest.MonkeyPatch, tmp_path: Path,
                 works: Callable[[Sequence[str]], bool]) -> list[str]:  # fmt: skip
    """Install SMALL where commands work or do not; return which installer each command was of."""
    called = []

    def run(command: Sequence[str], log: Path, **_: object) -> bool:
        log.touch()
        called.append('uv' if Path(command[0]).name == 'uv' else 'pip')
        return works(command)

    python = tmp_path / 'bin' / 'python'
    python.parent.mkdir()
    (python.parent / 'uv').touch()
    monkeypatch.setattr(packages, 'run_logged', run)
    monkeypatch.setattr(packages, 'pip_settings', lambda _: {})
    wanted = {**lock.part(SMALL, ['run.in']), 'uv': 'uv==1\n'}
    packages.install(Packages(wanted, 'small.lock', python), tmp_path / 'log')
    return called


def test_uv_installs_and_pip_only_uv(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert installed_by(monkeypatch, tmp_path, lambda _: True) == ['pip', 'uv']


def test_where_uv_fails_pip_installs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    called = installed_by(monkeypatch, tmp_path, lambda command: Path(command[0]).name != 'uv')
    assert called == ['pip', 'uv', 'pip']


def test_where_neither_works_that_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(SetupError, match=r'expected the packages of bootstrap/small\.lock'):
        installed_by(monkeypatch, tmp_path, lambda _: False)


def test_uv_takes_packages_from_where_pip_does() -> None:
    given = packages.read_settings(
        "global.index-url='https://mirror/simple'\n"
        ":env:.find-links='/wheels /more'\n"
        "global.find-links='/other'\n"
        "install.trusted-host='\\nmirror'\n"
        "download.find-links='/not here'\n"
        ":env:.no-index='1'\n"
    )
    assert packages.uv_variables(given) == {
        'UV_DEFAULT_INDEX': 'https://mirror/simple', 'UV_FIND_LINKS': '/wheels,/more',
        'UV_INSECURE_HOST': 'mirror',
    }  # fmt: skip
    assert given['no-index'] == '1'


def test_users_settings_of_uv_are_left_out_and_passwords_not_in_the_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv('UV_TARGET', '/elsewhere')
    monkeypatch.setenv('UV_CACHE_DIR', '/cache')
    given = {'index-url': 'https://me:secret@mirror/simple', 'no-index': 'y'}
    (tmp_path / 'uv').touch()
    calls = []

    def run(command: Sequence[str], *_: object, environment: dict[str, str], **__: object) -> bool:
        calls.append((command, environment))
        return True

    monkeypatch.setattr(packages, 'pip_settings', lambda _: given)
    monkeypatch.setattr(packages, 'run_logged', run)
    wanted = Packages({}, 'small.lock', tmp_path / 'python')
    assert packages.with_uv(wanted, tmp_path, tmp_path / 'log', packages.HASTY)
    ((command, environment),) = calls
    assert not [word for word in command if 'secret' in word]
    assert {'--no-config', '--no-index'} <= set(command)
    assert {name for name in environment if name.startswith('UV_')} == {
        'UV_DEFAULT_INDEX', 'UV_CACHE_DIR', 'UV_HTTP_TIMEOUT', 'UV_HTTP_RETRIES',
    }  # fmt: skip


def test_pip_says_how_it_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('PIP_FIND_LINKS', f'{os.sep}wheels')
    assert packages.pip_settings(Path(sys.executable))['find-links'] == f'{os.sep}wheels'


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
        ('error: Failed to fetch\n  Caused by: error sending request for url\n', 'no connection'),
        ('killed\n', 'an error'),
    ],
)
def test_reason_of_a_failed_installation(log: str, reason: str) -> None:
    assert packages.why_it_failed(log) == reason
