"""An archive of recordings of which the last ones get thinner."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from bpc_sim.printer.print_recording import record_print, START_NS
from bpc_sim.printer.scenarios import line

HOUR_NS = 3_600_000_000_000
STEADY = 10  # prints, by turns 0.02 mm above and below 2 mm; then each 0.1 mm thinner
WIDTHS_MM = [2.02 - 0.04 * (number % 2) for number in range(STEADY)] + [1.9, 1.8, 1.7, 1.6]
NAMES = [f'{chr(ord("z") - number)}_print' for number in range(len(WIDTHS_MM))]  # backwards


def record_archive(folder: Path) -> None:
    """Record prints an hour from each to the next, whose names are in another order."""
    for number, (name, width) in enumerate(zip(NAMES, WIDTHS_MM, strict=True)):
        job = replace(line(25e-3), seed=number,
                      printed_width=lambda s, width=width: np.full(np.shape(s), 1e-3 * width))
        record_print(job, folder / name, 10.0, 2e-3, first_ns=START_NS + number * HOUR_NS)
