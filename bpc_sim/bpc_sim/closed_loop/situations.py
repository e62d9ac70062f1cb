"""Prints that go wrong, by name: what the advice is tried on.

Each seed is another printer: its stiffness, its noise and how far it is off differ. Unless a
name says otherwise the syringe is stiff, the width varies by 2 %, and there is a capture a second.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.arrays import Array
from bpc_sim.closed_loop.loop import Situation, SPEED, WIDTH
from bpc_sim.ink.extrusion import Behaviour, Delivery

LENGTH = 0.24  # of a print [m]
SLOW_CAMERA = 1 / 0.3  # period of the slowest camera [s]
FAULT = 0.1  # where a fault begins [m]
DEAD_TIME = 0.5  # the longest [s]

Maker = Callable[[Situation, np.random.Generator], Situation]


def situation(name: str, seed: int, length: float = LENGTH) -> Situation:
    """A print that goes wrong in the way of this name. Raises ValueError for an unknown name."""
    if name not in SITUATIONS:
        raise ValueError(f'scenario: expected one of {", ".join(SITUATIONS)}, found {name}')
    rng = np.random.default_rng((seed, *name.encode()))
    behaviour = Behaviour(lag=_between(rng, 0.05, 0.5), dead_time=float(rng.uniform(0, 0.2)),
                          seed=seed)
    stiff = Situation(name, behaviour, length=length, latency=float(rng.uniform(0.2, 0.5)),
                      acquisition=float(rng.uniform(0.15, 0.4)), seed=seed)
    return SITUATIONS[name](stiff, rng)


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number by chance, evenly on a logarithmic scale."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _behaving(situation: Situation, **changes: object) -> Situation:
    return replace(situation, behaviour=replace(situation.behaviour, **changes))  # type: ignore[arg-type]


def constant(share: float) -> Delivery:
    """The same share everywhere."""
    return lambda s: np.full(np.shape(s), share)


def drift(share: float, length: float) -> Delivery:
    """From all to this share over the print."""
    return lambda s: 1 + (share - 1) * np.clip(s / length, 0, 1)


def delivery(share: float) -> Maker:
    """A part of the ink does not arrive, or more than is commanded."""
    return lambda base, _: _behaving(base, delivery=constant(share))


def viscosity(share: float) -> Maker:
    """Less and less arrives, or more and more."""
    return lambda base, _: _behaving(base, delivery=drift(share, base.length))


def target_step(base: Situation, rng: np.random.Generator) -> Situation:
    """Another width is wanted from somewhere on; the print program knows nothing of it."""
    wanted = WIDTH * float(rng.choice((0.8, 0.85, 1.15, 1.2)))
    at = base.length * 0.4
    return replace(base, event=at, targets=WidthTargets(
        np.array((0, at, at)), np.array((WIDTH, WIDTH, wanted))))


def graded(base: Situation, rng: np.random.Generator) -> Situation:
    """The width wanted grows or shrinks along the path."""
    first = WIDTH * float(rng.choice((0.85, 1.15)))
    return replace(base, width=first, targets=WidthTargets(
        np.array((0, base.length)), np.array((first, 2 * WIDTH - first))))


def noise(variation: float) -> Maker:
    """On target but for noise."""
    return lambda base, _: _behaving(base, noise=variation)


def soft(lag: float, off: float = 0.3) -> Maker:
    """A soft syringe that takes its time, seen seldom, and off by any share up to ``off``."""
    def make(base: Situation, rng: np.random.Generator) -> Situation:
        share = float(rng.uniform(1 - off, 1 + off))
        return replace(_behaving(base, lag=lag, dead_time=DEAD_TIME, delivery=constant(share)),
                       period=SLOW_CAMERA)
    return make


def seldom(base: Situation, rng: np.random.Generator) -> Situation:
    """A stiff syringe, seen seldom."""
    return replace(delivery(float(rng.choice((0.7, 1.3))))(base, rng), period=SLOW_CAMERA)


def often(base: Situation, rng: np.random.Generator) -> Situation:
    """Seen three times a second, from capture to advice in longer than that."""
    return replace(delivery(float(rng.choice((0.7, 1.3))))(base, rng), period=1 / 3, latency=0.5,
                   acquisition=0.15)


def speed_changes(base: Situation, rng: np.random.Generator) -> Situation:
    """The robot hurries and dawdles, the flow with it, but for the lag."""
    def speed(s: Array) -> Array:
        return np.where(np.floor(s / 0.02) % 2 == 0, 2 / 3, 4 / 3) * SPEED

    share = float(rng.uniform(0.75, 1.25))
    return replace(_behaving(base, lag=_between(rng, 0.3, 1), delivery=constant(share)),
                   speed=speed)


def corners(base: Situation, rng: np.random.Generator) -> Situation:
    """The robot slows down at corners, and the nozzle drags the bead."""
    at = np.arange(0.02, base.length, 0.02)

    def speed(s: Array) -> Array:
        return SPEED * (1 - 0.5 * np.exp(-(np.abs(np.asarray(s)[..., None] - at) / 2e-3).min(-1)))

    share = float(rng.uniform(0.75, 1.25))
    return replace(_behaving(base, corners=at, delivery=constant(share)), speed=speed)


def everything(base: Situation, rng: np.random.Generator) -> Situation:
    """A soft syringe, drift, noise and corners at once."""
    share = float(rng.uniform(0.7, 1.3))
    return _behaving(corners(base, rng), lag=_between(rng, 1, 4), dead_time=0.3,
                     delivery=lambda s: share * drift(0.75, base.length)(s), noise=0.1)


def clog(base: Situation, rng: np.random.Generator) -> Situation:
    """For 40 mm only a part of the ink passes."""
    share = float(rng.uniform(0.25, 0.45))

    def passing(s: Array) -> Array:
        return np.where((s >= FAULT) & (s < FAULT + 0.04), share, 1.0)

    return replace(_off(base, rng, passing), fault=FAULT, seen=True)


def bubble(base: Situation, rng: np.random.Generator) -> Situation:
    """Air instead of ink."""
    length = float(rng.uniform(0.003, 0.01))
    return replace(_behaving(_off(base, rng), bubbles=np.array(((FAULT, FAULT + length),))),
                   fault=FAULT, seen=True)


def _off(base: Situation, rng: np.random.Generator, more: Delivery | None = None) -> Situation:
    """Off by some share, so that there is a correction when the fault comes."""
    share = float(rng.choice((0.8, 1.2)))
    return _behaving(base, delivery=(lambda s: share * more(s)) if more else constant(share))


def extruder_fault(base: Situation, rng: np.random.Generator) -> Situation:
    """The extruder stops with an error."""
    return replace(_off(base, rng), extruder_lost=FAULT, fault=FAULT)


def camera_lost(base: Situation, rng: np.random.Generator) -> Situation:
    """No more captures."""
    return replace(_off(base, rng), camera_lost=FAULT, fault=FAULT)


def path_lost(base: Situation, rng: np.random.Generator) -> Situation:
    """Captures come, but the path does not go on."""
    return replace(_off(base, rng), path_lost=FAULT, fault=FAULT)


def calibration(offset: float) -> Maker:
    """The bead lies beside the path, or seems to."""
    return lambda base, _: replace(base, offset=offset, fault=0.0, seen=True)


SITUATIONS: dict[str, Maker] = {
    'under_delivery': delivery(0.7),
    'over_delivery': delivery(1.3),
    'viscosity_rise': viscosity(0.5),
    'viscosity_fall': viscosity(1.5),
    'target_step': target_step,
    'graded_target': graded,
    'noise_07': noise(0.07),
    'noise_15': noise(0.15),
    'noise_23': noise(0.23),
    'lag_1': soft(1.0),
    'lag_3': soft(3.0),
    'lag_10': soft(10.0),
    'lag_10_on_target': soft(10.0, 0.0),
    'seldom': seldom,
    'often': often,
    'speed_changes': speed_changes,
    'corners': corners,
    'everything': everything,
    'clog': clog,
    'bubble': bubble,
    'extruder_fault': extruder_fault,
    'camera_lost': camera_lost,
    'path_lost': path_lost,
    'calibration_5_mm': calibration(5e-3),
    'calibration_2_mm': calibration(2e-3),
}
