"""Many recordings on a cluster of two processes: one dies, and nothing is lost or done twice."""

from __future__ import annotations

from collections.abc import Iterator
import csv
import json
import os
from pathlib import Path
import re
import shutil
import signal
from typing import Any

from distributed import Client
from pyarrow import parquet
import pytest

from bpc_perception.batch.cluster import cluster, run as run_batch
from bpc_perception.batch.finding import find_bags
from bpc_perception.batch.jobs import find_jobs, measure_one
from bpc_system_tests.parts.command_line import run

pytestmark = pytest.mark.system

PRINT_COUNT = 4
BROKEN = 'b/broken.mcap'


@pytest.fixture(scope='module')
def prints(short_bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with recordings at several depths, and a file that is no recording."""
    folder = tmp_path_factory.mktemp('prints')
    for number in range(PRINT_COUNT):
        shutil.copytree(short_bag, folder / 'ab'[number % 2] / f'print_{number}')
    (folder / BROKEN).write_text('no recording, whatever its name says\n')
    return folder


@pytest.fixture(scope='module')
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder for the results of all batches."""
    return tmp_path_factory.mktemp('results')


@pytest.fixture(scope='module')
def client() -> Iterator[Client]:
    """A cluster of two processes on this computer."""
    with cluster(None, 2) as client:
        yield client


@pytest.fixture(scope='module')
def survived(client: Client, prints: Path, out: Path) -> tuple[list[dict[str, Any]], list[bool]]:
    """The rows of a batch during which a busy process was killed, and which rows were new."""
    processes = client.run(os.getpid)
    news: list[bool] = []

    def on_progress(_: dict[str, Any], new: bool) -> None:
        news.append(new)
        if len(news) == 1:
            # One process has just finished a job; the other is in the middle of one.
            busy = [address for address, keys in client.processing().items() if keys]
            os.kill(processes[busy[0]], signal.SIGKILL)

    rows = run_batch(client, find_jobs(prints, out, None, None), on_progress)
    assert set(client.run(os.getpid).values()) != set(processes.values())
    return rows, news


def write_times(out: Path) -> dict[str, int]:
    """Return when each result was written."""
    return {str(file.relative_to(out)): file.stat().st_mtime_ns
            for file in out.rglob('profile.csv')}


def test_nothing_is_lost_and_nothing_comes_twice(
        survived: tuple[list[dict[str, Any]], list[bool]], out: Path) -> None:
    rows, news = survived
    assert [row['bag'] for row in rows] == [
        'a/print_0', 'a/print_2', BROKEN, 'b/print_1', 'b/print_3']
    assert len(news) == PRINT_COUNT + 1
    broken = rows.pop(2)
    assert broken['exit_status'] == 2
    assert 'broken.mcap: expected an MCAP file with messages, found none' in broken['reason']
    assert all((row['exit_status'], row['captures']) == (0, 3) for row in rows)
    profiles = {(out / row['bag'] / 'profile.csv').read_bytes() for row in rows}
    assert len(profiles) == 1  # they are copies
    assert not list(out.rglob('.bpc-*'))


@pytest.mark.usefixtures('survived')
def test_what_is_done_is_not_done_again(client: Client, prints: Path, out: Path) -> None:
    before = write_times(out)
    news: dict[str, bool] = {}
    os.utime(prints / 'a' / 'print_2' / 'line_0.mcap', (1, 1))  # as if it were recorded anew
    run_batch(client, find_jobs(prints, out, None, None),
              lambda row, new: news.update({row['bag']: new}))
    assert {name for name, new in news.items() if new} == {'a/print_2', BROKEN}
    after = write_times(out)
    assert {name for name in after if after[name] != before[name]} == {'a/print_2/profile.csv'}


@pytest.mark.usefixtures('survived')
def test_command_on_a_running_cluster(client: Client, prints: Path, out: Path) -> None:
    assert client.scheduler is not None
    ended = run('batch', prints, '--out', out, '--scheduler', client.scheduler.address, '--json')
    assert (ended.returncode, ended.stderr) == (1, '')
    events = [json.loads(line) for line in ended.stdout.splitlines()]
    assert [event['event'] for event in events] == ['print'] * (PRINT_COUNT + 1) + ['file'] * 7
    assert sum(event.get('measured', False) for event in events) <= 2
    with (out / 'prints.csv').open(newline='') as stream:
        rows = list(csv.DictReader(stream))
    table = parquet.read_table(out / 'prints.parquet').to_pylist()
    assert [row['bag'] for row in rows] == [row['bag'] for row in table]
    assert [row['exit_status'] for row in table] == [0, 0, 2, 0, 0]
    for text, number in zip(rows, table, strict=True):
        if number['thickness_mean_mm'] is None:
            assert (text['thickness_mean_mm'], text['exit_status']) == ('', '2')
        else:
            assert float(text['thickness_mean_mm']) == number['thickness_mean_mm']


def test_cluster_is_reached_from_this_computer_only(client: Client) -> None:
    addresses = [client.scheduler_info()['address'], *client.scheduler_info()['workers']]
    assert all(address.startswith('tcp://127.0.0.1:') for address in addresses)
    listening = {line.split()[1].split(':')[0]
                 for process in (os.getpid(), *client.run(os.getpid).values())
                 for line in _sockets(process)}
    assert listening == {'0100007F'}  # 127.0.0.1 in the byte order of x86


def _sockets(process: int) -> list[str]:
    """Return the lines of proc(5) about TCP sockets on which a process listens."""
    own = {os.readlink(file)[8:-1] for file in Path(f'/proc/{process}/fd').iterdir()
           if file.is_symlink() and os.readlink(file).startswith('socket:')}
    lines = [line for name in ('tcp', 'tcp6')
             for line in Path(f'/proc/net/{name}').read_text().splitlines()[1:]]
    return [line for line in lines if line.split()[3] == '0A' and line.split()[9] in own]


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match='expected recordings in it or below, found none'):
        find_jobs(tmp_path, tmp_path / 'out', None, None)


def test_results_do_not_get_into_recordings(tmp_path: Path) -> None:
    for recording in ('bag', 'print/recording'):
        folder = tmp_path / recording
        folder.mkdir(parents=True)
        (folder / f'{folder.name}_0.mcap').touch()
        found = re.escape(f'{recording}/{folder.name}_0.mcap')
        with pytest.raises(ValueError, match='expected a folder apart from the recordings, found '
                                             f'{found} in it'):
            find_jobs(tmp_path, tmp_path, None, None)
        shutil.rmtree(folder)


def test_recordings_are_found_as_they_are_left(tmp_path: Path) -> None:
    for file in ('whole/metadata.yaml', 'whole/x_0.mcap', 'whole/x_1.mcap', 'killed/killed_0.mcap',
                 'print/recording/recording_0.mcap', 'print/recording_2/recording_2_0.mcap',
                 'print/summary.json', 'loose/a.mcap', 'loose/b.db3', 'loose/notes.txt',
                 'deep/er/er_0.db3'):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
    assert [str(bag.relative_to(tmp_path)) for bag in find_bags(tmp_path)] == [
        'deep/er', 'killed', 'loose/a.mcap', 'loose/b.db3', 'print', 'whole']
    only, = find_jobs(tmp_path / 'whole', tmp_path / 'out', None, None)
    assert only.out == tmp_path / 'out' / 'whole'


def test_a_recording_takes_no_place_of_another_of_its_name(short_bag: Path,
                                                           tmp_path: Path) -> None:
    job, = find_jobs(short_bag, tmp_path, None, None)
    job.out.mkdir()
    (job.out / 'summary.json').write_text('{"bag": "/monday/line", "fingerprint": ""}')
    (row,), _ = measure_one(job)
    assert row['exit_status'] == 2
    assert f'those of {short_bag}, found those of /monday/line; name another' in row['reason']
