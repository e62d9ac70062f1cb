"""How large profile messages of a long print are: the whole, and what changed with a capture."""

from __future__ import annotations

from time import perf_counter

import numpy as np
from rclpy.serialization import serialize_message

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.growing_profile import change_between, GrowingProfile, OF_EACH_SAMPLE
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.measure import measure
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.messages.profile import change_to_message, profile_to_message
from bpc_sim.benchmarks.core_prints import long_print
from bpc_sim.benchmarks.timing import no_progress, Progress

CAPTURES = (20, 200)  # of the print, after which messages are told
SPACING_M = 2e-4  # of path points
ADDED_POINTS = 30  # with each capture: 3 mm/s and 2 s
PERIOD_S = 2.0  # of captures, for which the size of an hour is told
LOOKED_AT = 10  # captures, of which the medians are told


def run(quick: bool, progress: Progress = no_progress) -> list[dict[str, object]]:
    """Print a meander within sight of the camera; verify that the parts make the whole.

    The camera sees all of the print in each capture: of a larger print less changes.
    """
    told = CAPTURES[:1] if quick else CAPTURES
    memory, known, before = PrintMemory(), GrowingProfile(), None
    sizes: list[tuple[float, ...]] = []
    rows: list[dict[str, object]] = []
    for number in range(1, told[-1] + 1):
        profile = measured(number, memory)
        sizes.append(sent(before, profile, known))
        before = profile
        progress(number, told[-1])
        if number in told:
            whole, part, whole_s, part_s = np.median(sizes[-LOOKED_AT:], axis=0).tolist()
            rows.append({
                'length_m': len(profile) * SPACING_M, 'samples': len(profile),
                'whole_mb': whole / 1e6, 'part_mb': part / 1e6, 'share': part / whole,
                'whole_ms': whole_s * 1e3, 'part_ms': part_s * 1e3,
                'whole_gb_an_hour': whole / 1e9 * 3600 / PERIOD_S,
                'part_gb_an_hour': part / 1e9 * 3600 / PERIOD_S})
    return rows


def measured(number: int, memory: PrintMemory) -> ThicknessProfile:
    """Return the profile of the print at a capture, from a picture of its own."""
    s = np.arange(number * ADDED_POINTS) * np.float64(SPACING_M)
    drawn = long_print(s[-1], number)
    return measure(drawn.capture, drawn.path(s), drawn.T_base_camera, ThicknessConfig(), number,
                   memory)


def sent(before: ThicknessProfile | None, profile: ThicknessProfile,
         known: GrowingProfile) -> tuple[float, ...]:
    """Return bytes of the whole and of the change, and the times to make each [s].

    Raises ValueError unless the change makes the whole for who knows the one before.
    """
    begin = perf_counter()
    whole = serialize_message(profile_to_message(profile, 'base'))
    middle = perf_counter()
    change = change_between(before, profile) if before is not None else None
    part = (serialize_message(change_to_message(change, profile, 'base')) if change is not None
            else whole)
    end = perf_counter()
    found = known.set_whole(profile) if change is None else known.add_change(change)
    if not (len(found) == 1 and all(np.array_equal(
            getattr(found[0], name), getattr(profile, name), equal_nan=True)
            for name in OF_EACH_SAMPLE)):
        raise ValueError('bench profiles: expected the parts to make the whole, found another')
    return len(whole), len(part), middle - begin, end - middle
