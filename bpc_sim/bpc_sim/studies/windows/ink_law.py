"""Inks of known law: how much comes out of a nozzle, and how wide it lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from bpc_perception.core.arrays import Array
from bpc_perception.core.window.sweep import Drive

REFERENCE_SHEAR = 100.0  # 1/s
LEAST_ASPECT, LARGEST_ASPECT = 0.12, 0.5  # of a bead: flat, and a half circle
LARGEST_PRESSURE_PA = 1e7


@dataclass(frozen=True)
class InkLaw:
    """A Herschel-Bulkley ink in a nozzle, and the bead that it makes on the bed.

    Attributes:
        drive: what the printer commands.
        consistency: K of the ink [Pa s^n].
        index: n, below 1 where shear thins it.
        yield_stress: below which it does not flow [Pa].
        radius: of the nozzle's bore [m].
        length: of the nozzle's bore [m].
        delivered: share of a small commanded flow that comes out.
        leak: share of it that leaks past the plunger at the reference shear, where the pressure is
            higher.
        swell: by how much the strand is wider than the nozzle at the reference shear [share].
        swell_exponent: of the shear rate, in the swell.
        aspect: height / width of a bead that is laid without being pulled.
        pull_exponent: how much flatter it gets when pulled.
        breaking_pull: speed / speed of the strand, from which it breaks.
        lag: time in which the flow reaches 63 % [s].
        scatter: standard deviation of widths from line to line, as a share.
    """

    drive: Drive
    consistency: float
    index: float
    yield_stress: float
    radius: float
    length: float
    delivered: float
    leak: float
    swell: float
    swell_exponent: float
    aspect: float
    pull_exponent: float
    breaking_pull: float
    lag: float
    scatter: float

    def flow(self, command: float) -> float:
        """Return what comes out [m^3/s] with a commanded flow [m^3/s] or pressure [Pa]."""
        if self.drive == Drive.PRESSURE:
            return self._flow_at(command)
        pressure = (self.shear(command) / REFERENCE_SHEAR)**self.index
        return command * self.delivered * (1 - self.leak * pressure)

    def command(self, flow: float) -> float:
        """Return what somebody commands who wants a flow [m^3/s]: the flow, or its pressure."""
        if self.drive == Drive.FLOW:
            return flow
        return float(brentq(lambda command: self.flow(command) - flow, 1.0, LARGEST_PRESSURE_PA))

    def shear(self, flow: float) -> float:
        """Return the shear rate at the wall [1/s], after Weissenberg and Rabinowitsch."""
        newton = 4 * flow / (np.pi * self.radius**3)
        return newton * (3 * self.index + 1) / (4 * self.index)

    def pull(self, flow: float, speed: float) -> float:
        """Return the nozzle's speed / that of the swollen strand."""
        swollen = 2 * self.radius * (1 + self.swell * (
            self.shear(flow) / REFERENCE_SHEAR)**self.swell_exponent)
        return speed * np.pi * swollen**2 / (4 * flow)

    def breaks(self, flow: float, speed: float) -> bool:
        """Tell whether no line comes out: nothing flows, or the strand breaks."""
        return flow <= 0 or self.pull(flow, speed) > self.breaking_pull

    def width(self, flow: float, speed: float) -> float:
        """Return the width of the bead [m]: a segment of a circle whose area is flow / speed."""
        return 2 * self._radius_of(flow, speed) * float(np.sin(self._contact(flow, speed)))

    def height(self, flow: float, speed: float) -> float:
        """Return the height of the bead [m]."""
        contact = self._contact(flow, speed)
        return self._radius_of(flow, speed) * (1 - float(np.cos(contact)))

    def along(self, flow: float, speed: float, s: Array) -> Array:
        """Return widths (N,) of a line that begins with no flow, at arc lengths (N,) [m]."""
        reached = flow * -np.expm1(-np.maximum(s, 1e-9) / (speed * self.lag))
        return np.array([self.width(float(each), speed) for each in reached])

    def _flow_at(self, pressure: float) -> float:
        """Return the flow of a Herschel-Bulkley fluid through a tube.

        [Chhabra and Richardson 2008, ch. 3]
        """
        wall = pressure * self.radius / (2 * self.length)
        over = wall - self.yield_stress
        if over <= 0:
            return 0.0
        m = 1 / self.index
        terms = (over**2 / (m + 3) + 2 * self.yield_stress * over / (m + 2)
                 + self.yield_stress**2 / (m + 1))
        return float(np.pi * self.radius**3 * over**(m + 1) * terms
                     / (self.consistency**m * wall**3))

    def _contact(self, flow: float, speed: float) -> float:
        """Return the angle of the bead's foot [rad], from its aspect."""
        aspect = self.aspect * self.pull(flow, speed)**-self.pull_exponent
        return 2 * float(np.arctan(2 * np.clip(aspect, LEAST_ASPECT, LARGEST_ASPECT)))

    def _radius_of(self, flow: float, speed: float) -> float:
        contact = self._contact(flow, speed)
        return float(np.sqrt(flow / speed / (contact - np.sin(contact) * np.cos(contact))))


def draw_ink(rng: np.random.Generator) -> InkLaw:
    """Return an ink by chance, of the kind that laboratories print."""
    drive = Drive.FLOW if rng.random() < 0.5 else Drive.PRESSURE
    return InkLaw(
        drive, consistency=float(np.exp(rng.uniform(np.log(20), np.log(500)))),
        index=float(rng.uniform(0.2, 0.8)), yield_stress=float(rng.uniform(0, 150)),
        radius=float(rng.uniform(0.4e-3, 0.6e-3)), length=float(rng.uniform(8e-3, 20e-3)),
        delivered=float(rng.uniform(0.8, 1.0)), leak=float(rng.uniform(0, 0.1)),
        swell=float(rng.uniform(0, 0.25)), swell_exponent=float(rng.uniform(0.1, 0.5)),
        aspect=float(rng.uniform(0.25, 0.45)), pull_exponent=float(rng.uniform(0, 0.25)),
        breaking_pull=float(rng.uniform(2.5, 6)), lag=float(rng.uniform(0.03, 0.15)),
        scatter=float(rng.uniform(0.005, 0.025)))
