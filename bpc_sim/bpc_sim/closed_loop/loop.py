"""A print whose rate is corrected while it runs, as numbers alone: no images, no nodes.

The printer is that of the nodes (``extrusion``, ``rate_control``); only the camera is simpler. It
gives the profile that the default method would: true widths with an error of their sigma,
gaps, and nothing where the nozzle hides the bead.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bpc_perception.core.advice.advisor import Advisor
from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.closed_loop.rate_control import Controller
from bpc_sim.ink.deposit import WidthProfile
from bpc_sim.ink.extrusion import Behaviour, Extrusion
from bpc_sim.printer.print_job import SYRINGE_BORE

STEP = 0.02  # of time, that of the extruder's states [s]
SPACING = 2e-4  # of path points [m]
WIDTH = 2e-3  # nominal [m]
SPEED = 3e-3  # nominal, the paper's [m/s]
HIDDEN = 3e-3  # behind the nozzle, where the camera does not see the bead [m]
UNSEEN = 0.03  # share of samples without an answer otherwise
SIGMA = (1e-5, 3e-5)  # of measured widths [m]
PATIENCE = 2.0  # for the path, before a capture is measured without it [s]
PLUNGER_AREA = np.pi / 4 * SYRINGE_BORE**2  # [m^2]
REACH = 4e-3  # from the path in which a bead is looked for [m]


def constant_speed(s: Array) -> Array:
    """The nominal speed everywhere [m/s]."""
    return np.full(np.shape(s), SPEED)


@dataclass(frozen=True, eq=False)
class Situation:
    """A print and what goes wrong with it.

    Attributes:
        name: of the scenario.
        behaviour: of the extruder.
        targets: width wanted along the path.
        length: of the path [m].
        speed: nominal speed over arc length [m/s].
        width: for which the nominal flow is right [m].
        period: from capture to capture [s].
        acquisition: of a capture, whose stamp is its end [s].
        latency: from the stamp until advice arrives [s].
        event: arc length at which what is to be corrected begins [m].
        fault: arc length from which on an alarm is due [m].
        seen: whether the fault shows in the bead only, and not before that is seen.
        camera_lost, path_lost, extruder_lost: arc lengths from which on there is none [m].
        offset: of the bead from the path, as by a wrong calibration [m].
        seed: of the camera's noise.
    """

    name: str
    behaviour: Behaviour
    targets: WidthTargets = field(default_factory=lambda: WidthTargets.constant(WIDTH))
    length: float = 0.3
    speed: WidthProfile = constant_speed
    width: float = WIDTH
    period: float = 1.0
    acquisition: float = 0.25
    latency: float = 0.3
    event: float = 0.0
    fault: float = np.inf
    seen: bool = False
    camera_lost: float = np.inf
    path_lost: float = np.inf
    extruder_lost: float = np.inf
    offset: float = 0.0
    seed: int = 0


@dataclass(frozen=True)
class Look:
    """A capture that was due, and what came of it.

    Attributes:
        time: its stamp [s].
        arc: where the nozzle was then [m].
        seen: how far the bead could be seen [m].
        advice: after it; None = no capture, or none asked for.
    """

    time: float
    arc: float
    seen: float
    advice: RateAdvice | None


@dataclass(frozen=True, eq=False)
class Trace:
    """What came of a print.

    Attributes:
        s: (N,) arc lengths [m].
        width, target: (N,) as laid and as wanted [m].
        scale: (N,) factor on the nominal rate in force.
        looks: captures in order.
    """

    s: Array
    width: Array
    target: Array
    scale: Array
    looks: list[Look]

    @property
    def error(self) -> Array:
        """Relative deviation (N,) of the width from the target."""
        return self.width / self.target - 1


class ClosedLoop:
    """One print under one controller.

    Args:
        situation: what is printed, and what goes wrong.
        controller: sets the factor on the nominal rate.
        actuator: flow, or speed.
        config: of the advice.
    """

    def __init__(self, situation: Situation, controller: Controller, actuator: str = 'flow',
                 config: AdviceConfig | None = None) -> None:
        self._situation = situation
        self._controller = controller
        self._actuator = actuator
        self._config = config or AdviceConfig()
        self._advisor = Advisor(situation.targets)
        self._extrusion = Extrusion(situation.behaviour, situation.length)
        self._rng = np.random.default_rng((situation.seed, 1))
        # Time, arc length, flow from then on, and factor in force, step by step.
        self._log = np.empty((1000, 4))
        self._steps = 0
        self._time = np.empty(0)  # of path points
        self._flow = np.empty(0)

    def run(self) -> Trace:
        """Print to the end."""
        situation = self._situation
        s, before, captures = 0.0, 0.0, 0
        looks: list[Look] = []
        due: list[tuple[float, ThicknessProfile, RateAdvice | None]] = []
        while s < situation.length:
            t = self._steps * STEP
            while due and due[0][0] <= t:
                self._controller.take(*due.pop(0)[1:], round(t * 1e9))
            scale = self._controller.scale(round(t * 1e9))
            speed, flow = self._commanded(s, scale)
            self._extrusion.advance(t, s, before)
            self._note(t, s, flow, scale)
            if t >= (captures + 1) * situation.period:
                captures += 1
                look, came = self._look(t, s)
                looks.append(look)
                due += came
            s, before = s + speed * STEP, flow
        grid = np.arange(SPACING / 2, s - 2 * speed * STEP, SPACING)
        log = self._log[:self._steps]
        return Trace(grid, self._extrusion.width(grid), situation.targets.at(grid),
                     np.interp(grid, log[:, 1], log[:, 3]), looks)

    def _commanded(self, s: float, scale: float) -> tuple[float, float]:
        """Speed [m/s] and flow [m^3/s] at an arc length [m]."""
        situation = self._situation
        speed = float(situation.speed(np.array(s)))
        flow = situation.behaviour.flow_for(situation.width, speed)
        if s >= situation.extruder_lost:
            flow = 0.0
        return (speed, flow * scale) if self._actuator == 'flow' else (speed * scale, flow)

    def _note(self, *values: float) -> None:
        if self._steps == len(self._log):
            self._log = np.concatenate((self._log, np.empty_like(self._log)))
        self._log[self._steps] = values
        self._steps += 1

    def _look(self, t: float, s: float) -> tuple[
            Look, list[tuple[float, ThicknessProfile, RateAdvice | None]]]:
        """A capture at time t [s], and what comes of it when."""
        situation, log = self._situation, self._log[:self._steps]
        seen = float(np.interp(t - situation.acquisition, log[:, 0], log[:, 1])) - HIDDEN
        if s >= situation.camera_lost:
            return Look(t, s, seen, None), []
        path = self._path(t)
        profile = self._profile(t, path, seen)
        advice = (self._advisor.advise(profile, path, self._config)
                  if self._controller.follows_advice else None)
        waited = PATIENCE if s >= situation.path_lost else 0.0
        return Look(t, s, seen, advice), [(t + situation.latency + waited, profile, advice)]

    def _profile(self, t: float, path: DepositionPath, seen: float) -> ThicknessProfile:
        """What the default method would measure."""
        situation, count = self._situation, len(path)
        width = self._extrusion.width(path.arc_length)
        sigma = self._rng.uniform(*SIGMA, count)
        # A part of the error is that of the whole capture.
        error = sigma * (0.3 * self._rng.standard_normal()
                         + np.sqrt(1 - 0.3**2) * self._rng.standard_normal(count))
        missed = self._rng.random(count) < UNSEEN
        status = np.where(width > 0, Status.MEASURED, Status.GAP).astype(np.uint8)
        if abs(situation.offset) > REACH:
            status[:] = Status.GAP
        status[missed] = Status.NO_DATA
        status[path.arc_length > seen] = Status.OCCLUDED
        measured = status == Status.MEASURED
        thickness = np.where(measured, width + error, np.where(status == Status.GAP, 0, np.nan))
        half = np.where(measured, thickness / 2, np.nan)
        return ThicknessProfile(
            stamp_ns=round(t * 1e9), print_id='print', print_start_ns=0, capture=0, method='',
            time=path.time, arc_length=path.arc_length, points=path.points,
            extruding=path.extruding, status=status, thickness=thickness,
            sigma=np.where(measured, sigma, np.nan), left=half + situation.offset,
            right=half - situation.offset, left_points=path.points, right_points=path.points,
            processing_time=0.0)

    def _path(self, t: float) -> DepositionPath:
        """The path as recorded at time t [s]."""
        situation, log = self._situation, self._log[:self._steps]
        reach = min(log[-1, 1], situation.path_lost)
        arc = np.arange(int(reach / SPACING) + 1, dtype=np.float64) * SPACING
        new = np.interp(arc[len(self._time):], log[:, 1], log[:, 0])
        held = np.searchsorted(log[:, 0], new, side='right') - 1
        self._flow = np.concatenate((self._flow, log[held, 2]))
        self._time = np.concatenate((self._time, new))
        # What an extruder in error does is not known.
        lost = arc >= situation.extruder_lost
        flow = np.where(lost, np.nan, self._flow)
        return DepositionPath(
            print_id='print', start_ns=0,
            complete_until=t + STEP if reach < situation.path_lost else float(self._time[-1]),
            finished=False, time=self._time, arc_length=arc,
            points=np.column_stack((arc, np.zeros((len(arc), 2)))),
            plunger_velocity=flow / PLUNGER_AREA, flow_rate=flow, extruding=~lost)
