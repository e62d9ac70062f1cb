"""How long commands take that start, do little and end, beside the start of what they load."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
import subprocess
import sys
import tempfile

import numpy as np

from bpc_sim.benchmarks.timing import no_progress, Progress, time_interleaved

FLOOR = 'import cv2, numpy, rclpy, scipy.ndimage, scipy.spatial'
BPC = (sys.executable, '-m', 'bpc_perception')


def run(bag: Path, quick: bool, progress: Progress = no_progress) -> list[dict[str, object]]:
    """Time a start of the libraries, the help, and the measurement of a recording.

    Raises ValueError if one of them fails.
    """
    rounds, done = (1 if quick else 5), 0
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / 'out'
        commands = {
            'libraries': (sys.executable, '-c', FLOOR),
            'help': (*BPC, '--help'),
            'measure': (*BPC, 'measure', str(bag), '--out', str(out), '--quiet')}

        def run_once(command: Sequence[str]) -> None:
            nonlocal done
            ended = subprocess.run(command, capture_output=True, text=True, check=False)
            if ended.returncode:
                raise ValueError(f'bench start: expected {" ".join(command)} to end well, found '
                                 f'{ended.stderr.strip()}')
            done += 1
            progress(done, len(commands) * (1 + rounds))

        times = time_interleaved({name: partial(run_once, command)
                                  for name, command in commands.items()}, rounds, np.inf)
    return [{'what': name, 'median_s': timing.median, 'p95_s': timing.p95,
             'ratio': timing.median / times['libraries'].median}
            for name, timing in times.items()]
