"""Starts and stops the whole suite many times, and looks for what is left behind.

``python -m bpc_system_tests.robustness.cycles --count 200``: in each cycle the synthetic printer,
a live run with another process as camera, and a recorder start together. They are ended by SIGINT
or SIGTERM at a random moment of their first seconds; in each tenth cycle a node is killed before.
Whatever is left of processes, shared memory, temporary files and logs is named, and counts as a
failure.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from dataclasses import dataclass
import os
from pathlib import Path
import random
import signal
import subprocess
import sys
import tempfile
import time

import yaml

from bpc_perception.runtime.isolated_graph import free_domain
from bpc_perception.runtime.transport.shared_memory import (
    clean,
    NAME,
    SETTLING_TIME_S,
    SHARED_MEMORY,
    unused,
    used_by,
)
from bpc_system_tests.parts.command_line import SAMPLE
from bpc_system_tests.parts.process_tree import alive, descendants

RUN_TIME_S = (0.2, 8.0)  # shortest and longest, before the suite is ended
PAUSE_AFTER_KILL_S = (0.0, 2.0)
PATIENCE_S = 20.0  # until a process counts as one that does not end
KILL_PERIOD = 10  # a node is killed in each tenth cycle
PROGRAMS = ('sim', 'live', 'record')


@dataclass(frozen=True)
class Cycle:
    """How a cycle ended.

    Attributes:
        took: how long the suite took to end [s].
        faults: what went wrong or was left, in words.
    """

    took: float
    faults: list[str]


def environment(folder: Path, domain: int) -> dict[str, str]:
    """Return the variables of one cycle: all that it leaves is in the folder."""
    return os.environ | {
        'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'TMPDIR': str(folder / 'tmp'), 'ROS_LOG_DIR': str(folder / 'logs'),
        'XDG_STATE_HOME': str(folder / 'state')}


def commands(folder: Path) -> list[list[str]]:
    """Return the commands of a printer, of a live run, and of a recorder."""
    settings = folder / 'cell.yaml'
    settings.write_text(yaml.safe_dump({'path_recorder': {'ros__parameters': {
        'nozzle_offset': [0.0, 0.0, 0.15]}}}))
    bpc = [sys.executable, '-m', 'bpc_perception']
    return [
        [*bpc, 'sim', '--rate', '2', '--separate', '--out', str(folder / 'simulated')],
        [*bpc, 'live', '--handeye', str(SAMPLE / 'hand_eye.calib'), '--params', str(settings),
         '--out', str(folder / 'prints')],
        [*bpc, 'record', '--out', str(folder / 'recorded')]]


def run_cycle(number: int, domain: int, chance: random.Random) -> Cycle:
    """Start and stop the suite once, and look for what is left."""
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        (folder / 'tmp').mkdir()
        shared_before = {file.name for file in SHARED_MEMORY.iterdir()}
        suite = [stack.enter_context(subprocess.Popen(
            line, env=environment(folder, domain), stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True))
            for line in commands(folder)]
        programs = [process.pid for process in suite]
        time.sleep(chance.uniform(*RUN_TIME_S))
        nodes = descendants(programs)
        used = set().union(*map(used_by, [*nodes, *programs]))
        killed = bool(nodes) and number % KILL_PERIOD == KILL_PERIOD - 1
        if killed:
            os.kill(chance.choice(nodes), signal.SIGKILL)
            time.sleep(chance.uniform(*PAUSE_AFTER_KILL_S))
            nodes = sorted({*nodes, *descendants(programs)})
        order, begun = chance.choice((signal.SIGINT, signal.SIGTERM)), time.monotonic()
        faults = end_suite(suite, order)
        took = time.monotonic() - begun
        faults += [f'process {pid}' for pid in nodes if alive(pid)]
        if killed:
            time.sleep(SETTLING_TIME_S)
            clean()  # as the next start does
        faults += left_in_shared_memory(used, shared_before)
        faults += left_in_folder(folder, order, killed)
    return Cycle(took, faults)


def end_suite(suite: list[subprocess.Popen[str]], order: signal.Signals) -> list[str]:
    """Send a signal to all processes, and wait for their end; return what went wrong."""
    faults = []
    for process in suite:
        process.send_signal(order)
    for process, name in zip(suite, PROGRAMS, strict=True):
        try:
            _, complaints = process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            faults.append(f'{name} did not end')
            continue
        if 'Traceback' in complaints:
            faults.append(f'{name}: {complaints.strip().splitlines()[-1]}')
    return faults


def left_in_shared_memory(used: set[str], before: set[str]) -> list[str]:
    """Return the files in shared memory that a cycle left.

    Args:
        used: names of the segments that the suite used.
        before: names of the files that were there before.
    """
    left = [str(file) for file in unused(settled=0.0)
            if (match := NAME.search(file.name)) and match[1] in used - before]
    left += [str(file) for file in SHARED_MEMORY.iterdir()
             if file.name not in before and 'fastrtps' not in file.name]
    return left


def left_in_folder(folder: Path, order: signal.Signals, killed: bool) -> list[str]:
    """Return the temporary files, logs and torn recordings that a cycle left.

    Where a node was killed, some of that is allowed.
    """
    left = [str(file.relative_to(folder)) for file in (folder / 'state').rglob('*.tmp')]
    if killed:
        return left
    left += [f'{file.relative_to(folder)} ({order.name})' for part in ('tmp', 'logs')
             for file in (folder / part).rglob('*')]
    recordings = [folder / 'recorded', *folder.glob('*/*/recording*')]
    left += [f'{recording.relative_to(folder)} without metadata.yaml' for recording in recordings
             if recording.exists() and not (recording / 'metadata.yaml').exists()]
    return left


def main() -> None:
    """Run the cycles."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--count', type=int, default=200)
    parser.add_argument('--seed', type=int, default=0)
    given = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    chance = random.Random(given.seed)
    times, failed = [], 0
    for number in range(given.count):
        with free_domain() as domain:
            cycle = run_cycle(number, domain, chance)
        times.append(cycle.took)
        failed += bool(cycle.faults)
        print(f'{number}: ended in {cycle.took:.2f} s; '
              f'left: {", ".join(cycle.faults) or "nothing"}', flush=True)
    ordered = sorted(times)
    print(f'{given.count} cycles, seed {given.seed}: {failed} left something; ended in '
          f'{ordered[len(ordered) // 2]:.2f} s in the median, {ordered[-1]:.2f} s at most')
    sys.exit(failed > 0)


if __name__ == '__main__':
    main()
