"""Prints that go wrong, by name: the test cases of the advice.

Each seed is another printer: stiffness, noise and deviation differ. Unless a name says otherwise,
the syringe is stiff, the width varies by 2 %, and there is a capture each second.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.targets import WidthTargets
from bpc_sim.closed_loop.situation import NOMINAL_SPEED_M_PER_S, NOMINAL_WIDTH_M, Situation
from bpc_sim.ink.extrusion import Delivery, ExtruderBehaviour
from bpc_sim.ink.unevenness import MeasuredUnevenness

PRINT_LENGTH_M = 0.24
SLOW_CAMERA_PERIOD_S = 1 / 0.3  # of the slowest camera
FAULT_START_M = 0.1  # arc length at which a fault begins
CLOG_LENGTH_M = 0.04
LONGEST_DEAD_TIME_S = 0.5
SPEED_CHANGE_LENGTH_M = 0.02  # from change to change
CORNER_SPACING_M = 0.02
STROKE_SPACING_M, STROKE_LENGTH_M = 0.03, 0.024
CORNER_SLOWDOWN_M = 2e-3  # over which the robot slows down

Maker = Callable[[Situation, np.random.Generator], Situation]


def make_situation(name: str, seed: int, length: float = PRINT_LENGTH_M) -> Situation:
    """Return the situation of a name, on a printer that the seed chooses.

    Raises:
        ValueError: there is no situation of that name.
    """
    if name not in SITUATIONS:
        raise ValueError(f'scenario: expected one of {", ".join(SITUATIONS)}, found {name}')
    rng = np.random.default_rng((seed, *name.encode()))
    behaviour = ExtruderBehaviour(lag=_log_uniform(rng, 0.05, 0.5),
                                  dead_time=float(rng.uniform(0, 0.2)), seed=seed)
    stiff = Situation(name, behaviour, length=length, latency=float(rng.uniform(0.2, 0.5)),
                      acquisition=float(rng.uniform(0.15, 0.4)), seed=seed)
    return SITUATIONS[name](stiff, rng)


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a random number that is uniform on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _with_behaviour(situation: Situation, **changes: object) -> Situation:
    """Return a situation whose extruder behaves differently."""
    behaviour = replace(situation.behaviour, **changes)  # type: ignore[arg-type]
    return replace(situation, behaviour=behaviour)


def constant(share: float) -> Delivery:
    """Deliver the same share everywhere."""
    return lambda s: np.full(np.shape(s), share)


def drift(share: float, length: float) -> Delivery:
    """Deliver all at first, and linearly up to this share at the end of a length [m]."""
    return lambda s: 1 + (share - 1) * np.clip(s / length, 0, 1)


def delivery(share: float) -> Maker:
    """Deliver less or more ink than is commanded."""
    return lambda base, _: _with_behaviour(base, delivery=constant(share))


def viscosity(share: float) -> Maker:
    """Deliver less and less ink, or more and more."""
    return lambda base, _: _with_behaviour(base, delivery=drift(share, base.length))


def target_step(base: Situation, rng: np.random.Generator) -> Situation:
    """Want another width from a place on, which the print program does not know."""
    wanted = NOMINAL_WIDTH_M * float(rng.choice((0.8, 0.85, 1.15, 1.2)))
    at = base.length * 0.4
    return replace(base, event=at, targets=WidthTargets(
        np.array((0, at, at)), np.array((NOMINAL_WIDTH_M, NOMINAL_WIDTH_M, wanted))))


def graded_target(base: Situation, rng: np.random.Generator) -> Situation:
    """Want a width that grows or shrinks along the path."""
    first = NOMINAL_WIDTH_M * float(rng.choice((0.85, 1.15)))
    return replace(base, width=first, targets=WidthTargets(
        np.array((0, base.length)), np.array((first, 2 * NOMINAL_WIDTH_M - first))))


def noise(variation: float) -> Maker:
    """Print on target, with noise of this coefficient of variation."""
    return lambda base, _: replace(_with_behaviour(base, noise=variation), noise_repeats=False)


def measured_noise(base: Situation, _: np.random.Generator) -> Situation:
    """Print on target, as uneven as lines of a real ink were."""
    return _with_behaviour(base, unevenness=MeasuredUnevenness())


def soft_syringe(lag: float, off: float = 0.3) -> Maker:
    """Use a soft syringe of a lag [s], a slow camera, and a delivery off by up to ``off``."""
    def make(base: Situation, rng: np.random.Generator) -> Situation:
        share = float(rng.uniform(1 - off, 1 + off))
        soft = _with_behaviour(base, lag=lag, dead_time=LONGEST_DEAD_TIME_S,
                               delivery=constant(share))
        return replace(soft, period=SLOW_CAMERA_PERIOD_S)
    return make


def seldom(base: Situation, rng: np.random.Generator) -> Situation:
    """Use a stiff syringe and a slow camera."""
    return replace(delivery(float(rng.choice((0.7, 1.3))))(base, rng), period=SLOW_CAMERA_PERIOD_S)


def often(base: Situation, rng: np.random.Generator) -> Situation:
    """Take three captures a second, with a longer time from capture to advice."""
    return replace(delivery(float(rng.choice((0.7, 1.3))))(base, rng), period=1 / 3, latency=0.5,
                   acquisition=0.15)


def speed_changes(base: Situation, rng: np.random.Generator) -> Situation:
    """Change the robot's speed and the flow with it; the lag remains."""
    def speed(s: Array) -> Array:
        slow = np.floor(s / SPEED_CHANGE_LENGTH_M) % 2 == 0
        return np.where(slow, 2 / 3, 4 / 3) * NOMINAL_SPEED_M_PER_S

    share = float(rng.uniform(0.75, 1.25))
    return replace(_with_behaviour(base, lag=_log_uniform(rng, 0.3, 1), delivery=constant(share)),
                   speed=speed)


def corners(base: Situation, rng: np.random.Generator) -> Situation:
    """Slow the robot down at corners, where the nozzle drags the bead."""
    at = np.arange(CORNER_SPACING_M, base.length, CORNER_SPACING_M)

    def speed(s: Array) -> Array:
        away = (np.abs(np.asarray(s)[..., None] - at) / CORNER_SLOWDOWN_M).min(-1)
        return NOMINAL_SPEED_M_PER_S * (1 - 0.5 * np.exp(-away))

    share = float(rng.uniform(0.75, 1.25))
    return replace(_with_behaviour(base, corners=at, delivery=constant(share)), speed=speed)


def strokes(base: Situation, rng: np.random.Generator) -> Situation:
    """Print strokes with travel between: the extruder is switched on and off."""
    begin = np.arange(0.0, base.length, STROKE_SPACING_M)
    share = float(rng.uniform(0.75, 1.25))
    return replace(_with_behaviour(base, delivery=constant(share)),
                   strokes=np.column_stack((begin, begin + STROKE_LENGTH_M)))


def fresh(make: Maker) -> Maker:
    """Print with noise that is another in each layer."""
    return lambda base, rng: replace(make(base, rng), noise_repeats=False)


def other_ink(base: Situation, rng: np.random.Generator) -> Situation:
    """Print the third layer with another ink, and tell nobody."""
    share = float(rng.uniform(0.7, 1.3))
    return replace(_with_behaviour(base, lag=_log_uniform(rng, 0.2, 2), delivery=constant(share)),
                   other_ink=(_log_uniform(rng, 0.5, 2), _log_uniform(rng, 0.5, 2)))


def everything(base: Situation, rng: np.random.Generator) -> Situation:
    """Combine a soft syringe, drift, noise and corners."""
    share = float(rng.uniform(0.7, 1.3))
    return _with_behaviour(corners(base, rng), lag=_log_uniform(rng, 1, 4), dead_time=0.3,
                     delivery=lambda s: share * drift(0.75, base.length)(s), noise=0.1)


def clog(base: Situation, rng: np.random.Generator) -> Situation:
    """Let only a part of the ink pass for 40 mm."""
    share = float(rng.uniform(0.25, 0.45))

    def passing(s: Array) -> Array:
        return np.where((s >= FAULT_START_M) & (s < FAULT_START_M + CLOG_LENGTH_M), share, 1.0)

    return replace(_off_target(base, rng, passing), fault=FAULT_START_M, fault_shows_in_bead=True)


def bubble(base: Situation, rng: np.random.Generator) -> Situation:
    """Deliver air instead of ink for a few millimetres."""
    length = float(rng.uniform(0.003, 0.01))
    bubbles = np.array(((FAULT_START_M, FAULT_START_M + length),))
    return replace(_with_behaviour(_off_target(base, rng), bubbles=bubbles), fault=FAULT_START_M,
                   fault_shows_in_bead=True)


def _off_target(base: Situation, rng: np.random.Generator,
                more: Delivery | None = None) -> Situation:
    """Set the delivery off, so that a correction is in force when the fault comes."""
    share = float(rng.choice((0.8, 1.2)))
    return _with_behaviour(base, delivery=(lambda s: share * more(s)) if more else constant(share))


def extruder_fault(base: Situation, rng: np.random.Generator) -> Situation:
    """Stop the extruder with an error."""
    return replace(_off_target(base, rng), extruder_lost=FAULT_START_M, fault=FAULT_START_M)


def camera_lost(base: Situation, rng: np.random.Generator) -> Situation:
    """Deliver no more captures."""
    return replace(_off_target(base, rng), camera_lost=FAULT_START_M, fault=FAULT_START_M)


def path_lost(base: Situation, rng: np.random.Generator) -> Situation:
    """Deliver captures, but no more path."""
    return replace(_off_target(base, rng), path_lost=FAULT_START_M, fault=FAULT_START_M)


def wrong_calibration(offset: float) -> Maker:
    """Put the bead beside the path, or seemingly so, by an offset [m]."""
    return lambda base, _: replace(base, offset=offset, fault=0.0, fault_shows_in_bead=True)


SITUATIONS: dict[str, Maker] = {
    'under_delivery': delivery(0.7),
    'over_delivery': delivery(1.3),
    'viscosity_rise': viscosity(0.5),
    'viscosity_fall': viscosity(1.5),
    'target_step': target_step,
    'graded_target': graded_target,
    'noise_07': noise(0.07),
    'noise_15': noise(0.15),
    'noise_23': noise(0.23),
    'measured_noise': measured_noise,
    'lag_1': soft_syringe(1.0),
    'lag_3': soft_syringe(3.0),
    'lag_10': soft_syringe(10.0),
    'lag_10_on_target': soft_syringe(10.0, 0.0),
    'seldom': seldom,
    'often': often,
    'speed_changes': speed_changes,
    'corners': corners,
    'everything': everything,
    'strokes': strokes,
    'fresh_under_delivery': fresh(delivery(0.7)),
    'fresh_over_delivery': fresh(delivery(1.3)),
    'other_ink': other_ink,
    'clog': clog,
    'bubble': bubble,
    'extruder_fault': extruder_fault,
    'camera_lost': camera_lost,
    'path_lost': path_lost,
    'calibration_5_mm': wrong_calibration(5e-3),
    'calibration_2_mm': wrong_calibration(2e-3),
}
