"""Prints at full rate for long, with faults of camera, robot and extruder, into running nodes.

As a script: ``python -m bpc_system_tests.robustness.soak --minutes 30 --seed 1``. The output lists
the faults with their times.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
import sys
import tempfile

import numpy as np

from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.isolated_graph import Graph
from bpc_perception.runtime.transport.dds_profiles import choose_profile
from bpc_sim.printer.settings import write_settings
from bpc_system_tests.parts.ros_graph import own_domain
from bpc_system_tests.robustness.soak_printer import (
    CAPTURE_PATIENCE_S,
    Load,
    make_job,
    PRINT_PAUSE_S,
    Sample,
    SoakPrinter,
)

TARGET_M = 2e-3  # wanted thickness


@contextmanager
def soaking(load: Load, seed: int, log: Callable[[str], None]) -> Iterator[SoakPrinter]:
    """Run the nodes, and a printer that has begun."""
    with tempfile.TemporaryDirectory() as folder, own_domain() as domain:
        settings = write_settings(make_job(load), TARGET_M, Path(folder))
        graph = Graph(domain)
        try:
            with Nodes(settings.parameters) as nodes:
                nodes.start('bpc_perception.nodes.path_recorder',
                            **{'path.auto_stop_after': PRINT_PAUSE_S / 2})
                nodes.start('bpc_perception.nodes.thickness',
                            hand_eye_file=str(settings.hand_eye), patience=CAPTURE_PATIENCE_S)
                printer = SoakPrinter(graph, nodes, load, seed, log)
                printer.begin()
                yield printer
        finally:
            graph.close()


def growth(samples: list[Sample], quantity: str) -> tuple[float, float]:
    """Return the medians of a quantity in the second and in the last quarter of the run."""
    values = np.array([getattr(sample, quantity) for sample in samples])
    quarter = len(values) // 4
    return float(np.median(values[quarter:2 * quarter])), float(np.median(values[-quarter:]))


def main() -> None:
    """Print for long, and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=30.0)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--small', action='store_true', help='small captures, four times as many')
    given = parser.parse_args()
    choose_profile(captures=True)
    load = Load(full_size=False, capture_rate=10.0) if given.small else Load()
    with soaking(load, given.seed, lambda line: print(line, flush=True)) as soak:
        soak.run(given.minutes * 60)
        outcomes = soak.finish()
        print(f'seed {given.seed}, {given.minutes:g} minutes; faults: {dict(soak.faults)}')
        total = sum(outcomes.values())
        print(f'captures: {soak.least} to {soak.most}; outcomes {total}: {outcomes}')
        print(f'poses sent: {soak.poses_sent}')
        for name, samples in soak.samples.items():
            for quantity in ('memory_mb', 'threads', 'files'):
                print(name, quantity, *growth(samples, quantity))
        sys.exit(0 if soak.least <= total <= soak.most else 1)


if __name__ == '__main__':
    main()
