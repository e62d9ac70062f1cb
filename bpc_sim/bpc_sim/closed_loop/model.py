"""A print whose rate is corrected while it runs, in numbers alone: no images, no nodes.

The printer is that of the nodes (``extrusion``, ``controllers``); only the camera is simpler. It
gives the profile that the default method would give: true widths with an error of their sigma,
gaps, and nothing where the nozzle hides the bead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.advice.advisor import Advisor
from bpc_perception.core.advice.planned import Planned
from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.advice.setup import Setup
from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.config import AdviceConfig
from bpc_perception.core.learning.layer_record import LayerRecord
from bpc_perception.core.learning.rate_schedule import RateSchedule
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.closed_loop.controllers import Controller
from bpc_sim.closed_loop.situation import NOMINAL_SPEED_M_PER_S, Situation
from bpc_sim.ink.extrusion import Extrusion
from bpc_sim.printer.print_job import PLUNGER_AREA_M2

TIME_STEP_S = 0.02  # that of the extruder's states
PATH_SPACING_M = 2e-4
HIDDEN_LENGTH_M = 3e-3  # behind the nozzle, where the camera does not see the bead
UNANSWERED_SHARE = 0.03  # of the other samples
WIDTH_SIGMA_M = (1e-5, 3e-5)  # smallest and largest, of measured widths
SHARED_ERROR = 0.3  # part of a width's error that all samples of a capture share
PATH_PATIENCE_S = 2.0  # how long a capture waits for the path before it is measured without it
SEARCH_REACH_M = 4e-3  # from the path: a bead farther away is not found


@dataclass(frozen=True)
class Look:
    """A capture that was due, and what followed from it.

    Attributes:
        time: stamp [s].
        nozzle_at: arc length of the nozzle at the stamp [m].
        visible_to: arc length up to which the bead could be seen [m].
        advice: the advice after it; None = no capture, or no advice asked for.
    """

    time: float
    nozzle_at: float
    visible_to: float
    advice: RateAdvice | None


@dataclass(frozen=True)
class Delivery:
    """What a controller receives from a capture.

    Attributes:
        time: when it arrives [s].
        profile: the measured profile.
        advice: the advice; None = the controller does not use it.
    """

    time: float
    profile: ThicknessProfile
    advice: RateAdvice | None


@dataclass(frozen=True, eq=False)
class Trace:
    """The course of a print.

    Attributes:
        s: (N,) arc lengths [m].
        width, target: (N,) widths as laid and as wanted [m].
        scale: (N,) factor on the nominal rate in force.
        wanted: (N,) whether ink is wanted.
        looks: captures in order.
    """

    s: Array
    width: Array
    target: Array
    scale: Array
    wanted: Flags
    looks: list[Look]

    @property
    def error(self) -> Array:
        """Deviation (N,) of the width from what is wanted there, relative to the target."""
        return self.width / self.target - self.wanted


class ClosedLoopModel:
    """One print under one controller.

    Args:
        situation: the print, and what goes wrong with it.
        controller: sets the factor on the nominal rate.
        actuator: what the factor acts on, ``flow`` or ``speed``.
        config: parameters of the advice.
        schedule: factors on the flow along the path; None = there is none.
        setup: of the layers before.
    """

    def __init__(self, situation: Situation, controller: Controller, actuator: str = 'flow',
                 config: AdviceConfig | None = None, schedule: RateSchedule | None = None,
                 setup: Setup | None = None) -> None:
        self._situation = situation
        self._controller = controller
        self._actuator = actuator
        self._config = config or AdviceConfig()
        self._schedule = schedule
        self._advisor = Advisor(situation.targets, setup)
        self._extrusion = Extrusion(situation.behaviour, situation.length)
        self._rng = np.random.default_rng((situation.seed, 1))
        # Time, arc length, flow from then on, and factor in force, step by step.
        self._log_rows = np.empty((1000, 4))
        self._steps = 0
        self._path_time = np.empty(0)
        self._path_flow = np.empty(0)

    def run(self) -> Trace:
        """Print to the end."""
        situation = self._situation
        s, flow_before, captures = 0.0, 0.0, 0
        standing = self._switching[0] if situation.wanted(np.zeros(1))[0] else 0.0
        looks: list[Look] = []
        pending: list[Delivery] = []
        while s < situation.length:
            t = self._steps * TIME_STEP_S
            while pending and pending[0].time <= t:
                delivery = pending.pop(0)
                self._controller.take(delivery.profile, delivery.advice, round(t * 1e9))
            scale = self._controller.scale(round(t * 1e9), s)
            speed, flow = self._commanded(s, scale)
            speed = 0.0 if t < standing else speed
            self._extrusion.advance(t, s, flow_before)
            self._append(t, s, flow, scale)
            if t >= (captures + 1) * situation.period:
                captures += 1
                look, delivered = self._capture(t, s)
                looks.append(look)
                pending += delivered
            s, flow_before = s + speed * TIME_STEP_S, flow
        grid = np.arange(PATH_SPACING_M / 2, s - 2 * speed * TIME_STEP_S, PATH_SPACING_M)
        return Trace(grid, self._extrusion.width(grid), situation.targets.at(grid),
                     np.interp(grid, self._log[:, 1], self._log[:, 3]),
                     situation.wanted(grid), looks)

    def record(self) -> LayerRecord | None:
        """Return what is known of the finished print."""
        path = self._path(self._log[-1, 0])
        profile = self._measure(self._log[-1, 0], path, np.inf)
        return LayerRecord.of(path, profile, self._situation.targets)

    @property
    def setup(self) -> Setup:
        """What the print was set up with."""
        return self._advisor.setup

    @property
    def _switching(self) -> tuple[float, float]:
        """How much earlier the extruder is switched on and off [s]."""
        schedule = self._schedule
        return (schedule.advance, schedule.retreat) if schedule else (0.0, 0.0)

    def _pushing(self, s: float, speed: float) -> bool:
        """Return whether the extruder is on, with the nozzle at arc length s [m]."""
        advance, retreat = (speed * one for one in self._switching)
        strokes = self._situation.strokes
        return strokes is None or bool(
            ((s >= strokes[:, 0] - advance) & (s < strokes[:, 1] - retreat)).any())

    def _planned(self, path: DepositionPath) -> Planned | None:
        """Return the schedule as the advice needs it."""
        if self._schedule is None:
            return None
        s, reach = path.arc_length, self._config.lifetime * NOMINAL_SPEED_M_PER_S
        ahead = self._schedule.at(np.arange(s[-1], s[-1] + reach, PATH_SPACING_M))
        return Planned(self._schedule.at(s), 0.0, (float(ahead.min()), float(ahead.max())),
                       self._schedule.level_sigma)

    def _commanded(self, s: float, scale: float) -> tuple[float, float]:
        """Return speed [m/s] and flow [m^3/s] at an arc length [m]."""
        situation = self._situation
        speed = float(situation.speed(np.array(s)))
        flow = situation.behaviour.flow_for(situation.width, speed)
        if s >= situation.extruder_lost or not self._pushing(s, speed):
            flow = 0.0
        return (speed, flow * scale) if self._actuator == 'flow' else (speed * scale, flow)

    @property
    def _log(self) -> Array:
        """Rows (K, 4) of all steps so far."""
        return self._log_rows[:self._steps]

    def _append(self, *values: float) -> None:
        """Add a row to the log."""
        if self._steps == len(self._log_rows):
            self._log_rows = np.concatenate((self._log_rows, np.empty_like(self._log_rows)))
        self._log_rows[self._steps] = values
        self._steps += 1

    def _capture(self, t: float, s: float) -> tuple[Look, list[Delivery]]:
        """Take a capture at time t [s] with the nozzle at arc length s [m]."""
        situation = self._situation
        began_at = float(np.interp(t - situation.acquisition, self._log[:, 0], self._log[:, 1]))
        visible_to = began_at - HIDDEN_LENGTH_M
        if s >= situation.camera_lost:
            return Look(t, s, visible_to, None), []
        path = self._path(t)
        profile = self._measure(t, path, visible_to)
        advice = (self._advisor.advise(profile, path, self._config,
                                       planned=self._planned(path))
                  if self._controller.follows_advice else None)
        waited = PATH_PATIENCE_S if s >= situation.path_lost else 0.0
        delivery = Delivery(t + situation.latency + waited, profile, advice)
        return Look(t, s, visible_to, advice), [delivery]

    def _measure(self, t: float, path: DepositionPath, visible_to: float) -> ThicknessProfile:
        """Return the profile that the default method would measure."""
        situation, count = self._situation, len(path)
        width = self._extrusion.width(path.arc_length)
        sigma = self._rng.uniform(*WIDTH_SIGMA_M, count)
        error = sigma * (SHARED_ERROR * self._rng.standard_normal()
                         + np.sqrt(1 - SHARED_ERROR**2) * self._rng.standard_normal(count))
        missed = self._rng.random(count) < UNANSWERED_SHARE
        status = np.where(width > 0, Status.MEASURED, Status.GAP).astype(np.uint8)
        if abs(situation.offset) > SEARCH_REACH_M:
            status[:] = Status.GAP
        status[missed] = Status.NO_DATA
        status[path.arc_length > visible_to] = Status.OCCLUDED
        stroke = 1 + np.cumsum(np.diff(path.extruding.astype(int), prepend=1) > 0)
        travel = ~path.extruding & path.extruder_known
        status[travel & (status == Status.MEASURED)] = Status.OOZE
        status[travel & (status == Status.GAP)] = Status.BARE
        measured = status == Status.MEASURED
        thickness = np.where(measured, width + error, np.where(status == Status.GAP, 0, np.nan))
        half = np.where(measured, thickness / 2, np.nan)
        blank, first = np.full(count, np.nan), np.zeros(count, np.intp)
        return ThicknessProfile(
            stamp_ns=round(t * 1e9), print_id='print', print_start_ns=0, capture=0, method='',
            time=path.time, arc_length=path.arc_length, points=path.points,
            extruding=path.extruding, extruder_known=path.extruder_known,
            stroke=np.where(travel, 0, stroke), status=status, thickness=thickness,
            sigma=np.where(measured, sigma, np.nan), left=half + situation.offset,
            right=half - situation.offset, left_points=path.points, right_points=path.points,
            layer=np.where(travel, -1, 0), height=blank,
            height_sigma=blank, area=blank, area_sigma=blank,
            seen_in=first, commanded_area=blank, cause=np.zeros(count, np.uint8),
            shift=np.full(3, np.nan), tip_height=np.nan, processing_time=0.0)

    def _path(self, t: float) -> DepositionPath:
        """Return the path as recorded at time t [s]."""
        situation, log = self._situation, self._log
        reach = min(log[-1, 1], situation.path_lost)
        arc = np.arange(int(reach / PATH_SPACING_M) + 1, dtype=np.float64) * PATH_SPACING_M
        new_time = np.interp(arc[len(self._path_time):], log[:, 1], log[:, 0])
        step = np.searchsorted(log[:, 0], new_time, side='right') - 1
        self._path_flow = np.concatenate((self._path_flow, log[step, 2]))
        self._path_time = np.concatenate((self._path_time, new_time))
        # What an extruder in error does is not known.
        lost = arc >= situation.extruder_lost
        flow = np.where(lost, np.nan, self._path_flow)
        complete_until = (t + TIME_STEP_S if reach < situation.path_lost
                          else float(self._path_time[-1]))
        return DepositionPath(
            print_id='print', start_ns=0, complete_until=complete_until, finished=False,
            time=self._path_time, arc_length=arc,
            points=np.column_stack((arc, np.zeros((len(arc), 2)))),
            plunger_velocity=flow / PLUNGER_AREA_M2, flow_rate=flow, extruding=~lost & (flow > 0),
            extruder_known=~lost)
