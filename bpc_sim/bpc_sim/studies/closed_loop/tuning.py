"""The search for the constants of the controllers that advice and learning are compared with."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from bpc_sim.closed_loop.controllers import ProportionalIntegral
from bpc_sim.closed_loop.model import ClosedLoopModel
from bpc_sim.closed_loop.situations import make_situation, SITUATIONS
from bpc_sim.studies.closed_loop.outcome import rms
from bpc_sim.studies.closed_loop.trial import LAYERS, print_layers, run_print

PROPORTIONAL_GAINS = (0.0, 0.1, 0.2, 0.4, 0.6, 0.8)
INTEGRAL_GAINS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
LEARNING_GAINS = (0.3, 0.5, 0.7, 1.0)
LEADS_M = (0.0, 1e-3, 2e-3)
WINDOWS_M = (1e-3, 3e-3, 1e-2)
TUNING_SEEDS = range(1000, 1010)  # that no study uses


@dataclass(frozen=True)
class Gains:
    """Gains of the PI controller, and how good they are.

    Attributes:
        proportional, integral: gains.
        cost: mean of (rms / rms without feedback)^2 over all prints.
    """

    proportional: float
    integral: float
    cost: float


def tune(seeds: range = TUNING_SEEDS) -> list[Gains]:
    """Try all gains on the scenarios without a fault; the best come first."""
    prints = [make_situation(name, seed) for name in SITUATIONS for seed in seeds]
    prints = [print_ for print_ in prints if np.isinf(print_.fault)]
    none = np.array([rms(run_print(print_, 'none').error) for print_ in prints])
    found = []
    for proportional in PROPORTIONAL_GAINS:
        for integral in INTEGRAL_GAINS:
            mine = np.array([rms(ClosedLoopModel(print_, ProportionalIntegral(
                print_.targets, proportional, integral)).run().error) for print_ in prints])
            found.append(Gains(proportional, integral, float(np.mean((mine / none)**2))))
    return sorted(found, key=lambda gains: gains.cost)


@dataclass(frozen=True)
class LearningLaw:
    """Constants of the P-type learning law, and how good they are.

    Attributes:
        gain, lead, window: of ``PTypeLearner``.
        cost: mean of (rms / rms without feedback)^2 over the third layers of all prints.
    """

    gain: float
    lead: float
    window: float
    cost: float


def tune_learning(seeds: range = TUNING_SEEDS) -> list[LearningLaw]:
    """Try all constants on the scenarios without a fault; the best come first."""
    prints = [make_situation(name, seed) for name in SITUATIONS for seed in seeds]
    prints = [print_ for print_ in prints if np.isinf(print_.fault)]
    none = np.array([rms(run_print(print_.in_layer(LAYERS), 'none').error) for print_ in prints])
    found = []
    for law in product(LEARNING_GAINS, LEADS_M, WINDOWS_M):
        mine = np.array([rms(print_layers(print_, 'p_type', law=law)[-1].error)
                         for print_ in prints])
        found.append(LearningLaw(*law, float(np.mean((mine / none)**2))))
    return sorted(found, key=lambda law: law.cost)
