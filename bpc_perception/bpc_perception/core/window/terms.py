"""The terms of which a model of a sweep may consist."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.window.sweep import Drive

# By name, what is beside the constant, in d = ln(drive) and v = ln(speed), both about their mean.
# Lines of one shape whose volume is that of the flow: 'd-v' alone. The area is flow / speed then,
# and the width its root.
CANDIDATES = {
    'ratio': ('d-v',),
    'powers': ('d', 'v'),
    'bent ratio': ('d-v', '(d-v)²'),
    'powers, bent by drive': ('d', 'v', 'd²'),
    'powers, bent by speed': ('d', 'v', 'v²'),
    'powers, bent by both': ('d', 'v', 'd²', 'v²'),
    'quadratic': ('d', 'v', 'd²', 'v²', 'd·v'),
}
BY_PRESSURE = tuple(name for name in CANDIDATES if 'ratio' not in name)
PER_K = 1e3  # 1/T in 1/kK is of the order of 1


@dataclass(frozen=True)
class Scale:
    """Where the logarithms of settings are nought.

    Attributes:
        drive: geometric mean of flow [m^3/s] or pressure [Pa].
        speed: geometric mean [m/s].
        temperature: about which it varies [K]; NaN = it does not count.
    """

    drive: float
    speed: float
    temperature: float

    def terms(self, names: tuple[str, ...], drive: Array, speed: Array,
              temperature: Array) -> Array:
        """Return the terms (N, P) of settings (N,), with the constant first.

        Args:
            names: of a candidate.
            drive: flow [m^3/s] or pressure [Pa].
            speed: of the nozzle [m/s].
            temperature: of the ink [K]; it counts, after Arrhenius, where the scale has one.
        """
        d, v = np.log(drive / self.drive), np.log(speed / self.speed)
        made = {'d': d, 'v': v, 'd-v': d - v, '(d-v)²': (d - v)**2, 'd²': d**2, 'v²': v**2,
                'd·v': d * v}
        columns = [np.ones(len(d)), *(made[name] for name in names)]
        if np.isfinite(self.temperature):
            columns.append(PER_K * (1 / temperature - 1 / self.temperature))
        return np.column_stack(columns)


def candidates(drive: Drive) -> dict[str, tuple[str, ...]]:
    """Return the candidates for a drive: pressure over speed is no area."""
    return {name: terms for name, terms in CANDIDATES.items()
            if drive == Drive.FLOW or name in BY_PRESSURE}
