"""Lines at many flows and speeds: how wide and high an ink gets, and how late it comes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bpc_perception.core.testprints.plan import Part, TestPrint
from bpc_perception.core.testprints.setup import (
    ENDS_M,
    expect,
    FASTEST_M_S,
    Pattern,
    round_width,
    Setup,
    SLOWEST_M_S,
    SPREADING,
)

STEPS = tuple(2.0**(power / 2) for power in (-1.5, -0.5, 0.5, 1.5))  # of the usual, by default
SETTLING_S = 1.0  # after which flow through a compliant syringe is steady
STEADY_M = 10e-3  # of a line, at least, that is judged
# Before and behind a line the nozzle goes on alike without ink, so that it is at speed when the
# extruder is told, and what comes late lies beside nothing.
EMPTY_S, EMPTY_M = 0.5, 2e-3
CLEAR = 1.5  # nozzle diameters of bed between two lines, at least
MOST_LINES = 400
LEAST_FLOW, LARGEST_FLOW = 1e-13, 1e-5  # [m^3/s]


def lines(setup: Setup, flows: Sequence[float] = (), speeds: Sequence[float] = (),
          length: float = np.nan) -> TestPrint:
    """Return a line for each pair of flow and speed, and the middle pair before and after all.

    Neighbours differ by one step of one of both: within a row of the same flow the speed goes up
    and down in turn. So the pressure in the syringe, which follows a flow slowly, has little to
    settle, where a random order would leave each line with what the one before made. That ink
    changes with time is told by the middle pair, which a random order would only blur.

    Args:
        setup: what they are for.
        flows: [m^3/s]; none = about the usual one.
        speeds: [m/s]; none = about the usual one.
        length: of each line [m]; NaN = as short as can be judged.

    Raises:
        ValueError: a value is out of range, or the lines do not fit the bed.
    """
    flows = sorted(flows) or [setup.rate * step for step in STEPS]
    speeds = sorted(speeds) or [setup.pace * step for step in STEPS]
    _check(flows, speeds)
    least = 2 * ENDS_M + SETTLING_S * speeds[-1] + STEADY_M
    if np.isnan(length):
        length = least
    elif length < least:
        raise ValueError(f'--length-mm: expected {1e3 * least:.4g} or more, so that a line at '
                         f'{1e3 * speeds[-1]:.4g} mm/s is steady, found {1e3 * length:g}'
                         '; make it longer, or lower the speed')
    middle = flows[(len(flows) - 1) // 2], speeds[(len(speeds) - 1) // 2]
    order = [(flow, speed) for row, flow in enumerate(flows)
             for speed in (speeds if row % 2 == 0 else speeds[::-1])]
    pitch = SPREADING * round_width(flows[-1], speeds[0]) + CLEAR * setup.nozzle
    pattern = Pattern(setup)
    for number, (flow, speed) in enumerate((middle, *order, middle)):
        empty = max(EMPTY_M, EMPTY_S * speed)
        pattern.add(np.array([(0.0, number * pitch), (length, number * pitch)]),
                    Part.REPEAT if number in (0, len(order) + 1) else Part.LINE,
                    flow=flow, speed=speed, judged_from=ENDS_M + SETTLING_S * speed,
                    lead_in=empty, run_out=empty)
    return pattern.finish('lines')


def _check(flows: Sequence[float], speeds: Sequence[float]) -> None:
    """Raise ValueError unless these can be printed."""
    if len(flows) * len(speeds) > MOST_LINES:
        raise ValueError(f'lines: expected up to {MOST_LINES}, found {len(flows)} flows times '
                         f'{len(speeds)} speeds; leave some out')
    for speed in (speeds[0], speeds[-1]):
        expect('--speeds-mm-s', speed, SLOWEST_M_S, FASTEST_M_S, 'mm/s')
    for flow in (flows[0], flows[-1]):
        if not LEAST_FLOW <= flow <= LARGEST_FLOW:
            raise ValueError(f'--flows-mm3-s: expected {1e9 * LEAST_FLOW:g} to '
                             f'{1e9 * LARGEST_FLOW:g} mm3/s, found {1e9 * flow:g}'
                             '; is it in cubic millimetres, which are microlitres, a second?')
