"""Starts and stops the whole suite many times, and looks for what is left behind.

``python -m bpc_system_tests.robustness.cycles --count 200``: in turn the synthetic printer, a live
run with another process as camera, and a recorder are started together, and ended by SIGINT or
SIGTERM at a random moment of their first seconds; each tenth time a node is killed before.
Whatever is left then of processes, shared memory, temporary files and logs is named, and counts as
a failure.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
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
    SETTLED,
    SHARED_MEMORY,
    unused,
    used_by,
)
from bpc_system_tests.parts.process_tree import alive, descendants

SAMPLE = Path(__file__).resolve().parents[3] / 'bags' / 'spiral_gaps'
LONGEST = 8.0  # in which the suite is ended at a random moment [s]
PATIENCE = 20.0  # until it counts as one that does not end [s]


def environment(folder: Path, domain: int) -> dict[str, str]:
    """The variables of one cycle: whatever it leaves, it leaves in the folder."""
    return os.environ | {
        'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'TMPDIR': str(folder / 'tmp'), 'ROS_LOG_DIR': str(folder / 'logs'),
        'XDG_STATE_HOME': str(folder / 'state')}


def commands(folder: Path) -> list[list[str]]:
    """A printer, what measures it live, and a recorder."""
    settings = folder / 'cell.yaml'
    settings.write_text(yaml.safe_dump({'path_recorder': {'ros__parameters': {
        'nozzle_offset': [0.0, 0.0, 0.15]}}}))
    bpc = [sys.executable, '-m', 'bpc_perception']
    return [
        [*bpc, 'sim', '--rate', '2', '--separate'],
        [*bpc, 'live', '--handeye', str(SAMPLE / 'hand_eye.calib'), '--params', str(settings)],
        [*bpc, 'record', '--out', str(folder / 'recorded')]]


def cycle(number: int, domain: int, chance: random.Random) -> tuple[float, list[str]]:
    """Start and stop all once; how long they took to end [s], and what is amiss."""
    amiss: list[str] = []
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        (folder / 'tmp').mkdir()
        shared = {file.name for file in SHARED_MEMORY.iterdir()}  # ports that were there before
        suite = [stack.enter_context(subprocess.Popen(
            line, env=environment(folder, domain), stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True))
            for line in commands(folder)]
        time.sleep(chance.uniform(0.2, LONGEST))
        nodes = descendants(process.pid for process in suite)
        used = set().union(*map(used_by, [*nodes, *(process.pid for process in suite)]))
        killed = bool(nodes) and number % 10 == 9
        if killed:
            os.kill(chance.choice(nodes), signal.SIGKILL)
            time.sleep(chance.uniform(0.0, 2.0))
            nodes = sorted({*nodes, *descendants(process.pid for process in suite)})
        told, begun = chance.choice((signal.SIGINT, signal.SIGTERM)), time.monotonic()
        for process in suite:
            process.send_signal(told)
        for process, what in zip(suite, ('sim', 'live', 'record'), strict=True):
            try:
                _, complaints = process.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                amiss.append(f'{what} did not end')
                continue
            if 'Traceback' in complaints:
                amiss.append(f'{what}: {complaints.strip().splitlines()[-1]}')
        took = time.monotonic() - begun
        amiss += [f'process {pid}' for pid in nodes if alive(pid)]
        if killed:
            time.sleep(SETTLED)
            clean()  # as the next start does
        amiss += [str(file) for file in unused(settled=0.0)
                  if (match := NAME.search(file.name)) and match[1] in used - shared]
        amiss += [str(file) for file in SHARED_MEMORY.iterdir()
                  if file.name not in shared and 'fastrtps' not in file.name]
        amiss += [f'{file.relative_to(folder)} ({told.name})' for part in ('tmp', 'logs')
                  for file in (folder / part).rglob('*') if not killed]
        amiss += [str(file.relative_to(folder)) for file in (folder / 'state').rglob('*.tmp')]
        recorded = folder / 'recorded'
        if recorded.exists() and not (recorded / 'metadata.yaml').exists() and not killed:
            amiss.append('a recording without metadata.yaml')
    return took, amiss


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
            took, amiss = cycle(number, domain, chance)
        times.append(took)
        failed += bool(amiss)
        print(f'{number}: ended in {took:.2f} s; left: {", ".join(amiss) or "nothing"}',
              flush=True)
    ordered = sorted(times)
    print(f'{given.count} cycles, seed {given.seed}: {failed} left something; ended in '
          f'{ordered[len(ordered) // 2]:.2f} s in the median, {ordered[-1]:.2f} s at most')
    sys.exit(failed > 0)


if __name__ == '__main__':
    main()
