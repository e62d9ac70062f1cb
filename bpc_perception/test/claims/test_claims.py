"""One suite a domain, one print a folder: who comes second is told who is there."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import subprocess
import sys

import pytest

from bpc_perception.claims import domain
from bpc_perception.claims.folder import FolderClaim
from bpc_perception.claims.holder import HeldError

# A command, and a node of it, which ends when its input does.
SUITE = """
import subprocess, sys
from bpc_perception.claims import domain
with domain.claimed(print):
    node = subprocess.Popen([sys.executable, '-c', 'import sys; sys.stdin.read()'],
                            pass_fds=domain.descriptors())
    print(node.pid, flush=True)
    node.wait()
"""
FOLDER = """
import pathlib, sys
from bpc_perception.claims.folder import FolderClaim
with FolderClaim(pathlib.Path(sys.argv[1]), 'write'):
    print('has it', flush=True)
    sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def in_domain(ros_domain: int, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    yield
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain))
    with domain.claimed(lambda _: None):
        pass  # all have ended


@contextmanager
def running(script: str, *arguments: object) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen([sys.executable, '-c', script, *map(str, arguments)], text=True,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        yield process
        process.kill()


def test_a_second_suite_in_a_domain_is_refused_and_told_of_the_first(ros_domain: int) -> None:
    with running(SUITE) as first:
        with pytest.raises(HeldError) as refused, domain.claimed(pytest.fail):
            pytest.fail('expected a refusal')
        assert domain.holder() == first.pid
    words = str(refused.value)
    assert words.startswith(f'ROS domain {ros_domain}: expected no other suite in it, '
                            f'found process {first.pid} (')
    assert f' in {Path.cwd()}; stop it, or set ROS_DOMAIN_ID to another number' in words
    assert ') since 20' in words


def test_two_suites_run_in_two_domains(monkeypatch: pytest.MonkeyPatch) -> None:
    with running(SUITE):
        monkeypatch.setenv('ROS_DOMAIN_ID', '231')
        assert domain.holder() is None
        with domain.claimed(pytest.fail):
            assert domain.holder() == os.getpid()
        assert domain.holder() is None


def test_the_nodes_of_a_killed_suite_are_waited_for() -> None:
    with running(SUITE) as first:
        first.kill()
        first.wait()
        assert domain.holder() == first.pid  # its node lives
        assert first.stdin is not None
        said: list[str] = []

        def say(text: str) -> None:
            said.append(text)
            first.stdin.close()  # type: ignore[union-attr]

        with domain.claimed(say):
            assert domain.holder() == os.getpid()
        assert len(said) == 1
        assert 'waiting for the nodes of a command that was killed' in said[0]


def test_nodes_of_a_killed_suite_that_do_not_end_are_not_waited_for_without_end(
        monkeypatch: pytest.MonkeyPatch) -> None:
    with running(SUITE) as first, monkeypatch.context() as context:
        context.setattr(domain, 'ENDING_PATIENCE_S', 0.0)
        first.kill()
        first.wait()
        with pytest.raises(HeldError, match='nodes of a command that was killed'), \
                domain.claimed(print):
            pytest.fail('expected a refusal')


def test_a_folder_is_written_by_one_process_and_the_second_is_told_of_it(tmp_path: Path) -> None:
    with running(FOLDER, tmp_path) as first:
        with pytest.raises(HeldError, match=f'{tmp_path}: expected to be the only one to write, '
                                            f'found process {first.pid} ') as refused:
            FolderClaim(tmp_path, 'write')
        assert f'in {Path.cwd()}; stop it, or name another folder' in str(refused.value)
    FolderClaim(tmp_path, 'write').release()  # nothing is left of it
    assert list(tmp_path.iterdir()) == []
