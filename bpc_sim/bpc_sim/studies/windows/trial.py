"""One ink: its sweep, the setting that is recommended, and what comes out with it."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from bpc_perception.core.window.assess import find_window, InkWindow
from bpc_perception.core.window.sweep import SweepLine, WindowError
from bpc_perception.core.window.window import Wanted
from bpc_sim.studies.windows.camera import see_sweep
from bpc_sim.studies.windows.ink_law import draw_ink, InkLaw
from bpc_sim.studies.windows.outcome import Outcome
from bpc_sim.studies.windows.printed_sweep import measure_sweep, print_sweep

LEAST_TOLERANCE, LARGEST_TOLERANCE = 0.02, 0.1
NEW_LINES = 200  # of each ink, with the recommended setting
LOOKED_AT = 20  # settings in each window
SEEN_EVERY = 10  # of the inks also through the camera


def try_ink(seed: int) -> list[Outcome]:
    """Print, measure and judge the sweep of an ink; of some, through the camera as well."""
    rng = np.random.default_rng(seed)
    ink = draw_ink(rng)
    printed = print_sweep(ink, rng)
    known = [line.width for line in printed if np.isfinite(line.width)]
    target = float(np.quantile(known, rng.uniform(0.25, 0.75)))
    wanted = Wanted(target, float(rng.uniform(LEAST_TOLERANCE, LARGEST_TOLERANCE)))
    found = [judge(ink, measure_sweep(ink, printed, rng), wanted, ink.drive.value, rng)]
    if seed % SEEN_EVERY == 0:
        found.append(judge(ink, see_sweep(ink, printed, rng), wanted, 'camera', rng))
    return found


def judge(ink: InkLaw, lines: list[SweepLine], wanted: Wanted, by: str,
          rng: np.random.Generator) -> Outcome:
    """Return what comes of a sweep."""
    try:
        window = find_window(lines, wanted)
    except WindowError as error:
        return Outcome(by, refusal=str(error))
    return outcome(ink, window, by, rng)


def outcome(ink: InkLaw, window: InkWindow, by: str, rng: np.random.Generator) -> Outcome:
    """Compare what is expected of a setting with what the law says."""
    flow = ink.flow(window.drive)
    width = ink.width(flow, window.speed)
    lines = width * np.exp(ink.scatter * rng.standard_normal(NEW_LINES))
    expected, (low, high) = window.expected['width'], window.wanted.band
    (least, largest), (mean_least, mean_largest) = expected.interval[0], expected.mean_interval[0]
    return Outcome(
        by, width / window.wanted.width - 1, bool(mean_least <= width <= mean_largest),
        float(np.mean((lines >= least) & (lines <= largest))), window.chance,
        float(np.mean((lines >= low) & (lines <= high))), *of_window(ink, window, rng))


def of_window(ink: InkLaw, window: InkWindow, rng: np.random.Generator) -> tuple[float, float]:
    """Return the true chance of settings in a window, and the share of them that break."""
    row, place = np.nonzero(window.grid.met)
    if not len(row):
        return np.nan, np.nan
    chosen = rng.integers(len(row), size=LOOKED_AT)
    chances, broken = [], []
    for speed, drive in zip(window.grid.speed[row[chosen]].tolist(),
                            window.grid.drive[place[chosen]].tolist(), strict=True):
        flow = ink.flow(drive)
        broken.append(ink.breaks(flow, speed))
        low, high = np.log(np.divide(window.wanted.band, ink.width(flow, speed))) / ink.scatter
        chances.append(float(norm.cdf(high) - norm.cdf(low)))
    return float(np.mean(chances)), float(np.mean(broken))
