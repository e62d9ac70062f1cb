"""A print as a function of time: pose of the robot, state of the extruder, laid ink.

Time t is in seconds since the job's start. The robot waits above the start of the path, lowers the
nozzle, follows the path at constant speed while ink flows, stops, lifts the nozzle, and waits
again. Between strokes it travels.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.geometry import transform
from bpc_sim.ink.deposit import Deposit, WidthProfile
from bpc_sim.printer.motion import Motion, Travel
from bpc_sim.scene.camera import View
from bpc_sim.scene.render import render
from bpc_sim.scene.scene import Nozzle, Scene, Sensor
from bpc_sim.scene.surfaces import Plane, Surface

Times = Array | float

SYRINGE_BORE_M = 26.7e-3  # inner diameter of a 50 ml syringe
PLUNGER_AREA_M2 = np.pi / 4 * SYRINGE_BORE_M**2
PLUNGER_NODES = 10001  # arc lengths at which the plunger's position is tabulated


@dataclass(frozen=True, eq=False)
class PrintJob:
    """A print; all poses are in the robot base frame.

    Attributes:
        commanded: the complete print as the controller commands it: path, width and gaps.
        T_base_surface: (4, 4) pose of the surface frame.
        view: the camera and its pose.
        printed_width: width that really comes out; None for the commanded one.
        faults: (F, 2) intervals of arc length in which the extruder runs but no ink comes, as
            when a bubble passes [m].
        speed: speed of the nozzle along the path [m/s].
        travels: ways between strokes, on which no ink is commanded, in the order of the path.
        motion: along the path, where strokes have speeds of their own; None = by speed and
            travels.
        ink: what is laid, where it differs from the commanded print by more than its width and
            faults, as ink that runs on; None = it does not.
        layers: (L, 2) intervals of arc length in which the layers are laid [m]; empty = one.
        filament: cross-section of the commanded filament over its width squared; a round one as
            wide as the bead is meant by default.
        surface: shape of the bed.
        dwell_before: time from the job's start until the nozzle moves along the path [s]; in its
            second half the nozzle is lowered.
        dwell_after: time from the path's end to the job's end [s]; in its first half the nozzle
            is lifted.
        tip_height: height of the nozzle tip above the bed while printing [m].
        lift: how far above that height the robot waits [m].
        nozzle_offset: (3,) nozzle tip in the flange frame [m].
        R_surface_flange: (3, 3) orientation of the flange; its z axis is the tool's direction.
        nozzle: shape of the nozzle, as the camera sees it.
        sensor: imperfections of the camera.
        seed: seed of the noise in the captures.
    """

    commanded: Deposit
    T_base_surface: Array
    view: View
    printed_width: WidthProfile | None = None
    faults: Array = field(default_factory=lambda: np.empty((0, 2)))
    speed: float = 3e-3
    travels: tuple[Travel, ...] = ()
    motion: Motion | None = None
    ink: Deposit | None = None
    layers: Array = field(default_factory=lambda: np.empty((0, 2)))
    filament: float = np.pi / 4
    surface: Surface = field(default_factory=Plane)
    dwell_before: float = 1.0
    dwell_after: float = 1.0
    tip_height: float = 1e-3
    lift: float = 0.08
    nozzle_offset: Array = field(default_factory=lambda: np.array((0.0, 0.0, 0.15)))
    R_surface_flange: Array = field(default_factory=lambda: np.diag((1.0, -1.0, -1.0)))
    nozzle: Nozzle = field(default_factory=Nozzle)
    sensor: Sensor = field(default_factory=Sensor)
    seed: int = 0

    @property
    def length(self) -> float:
        """Arc length of the path [m]."""
        return self.commanded.curve.length

    @property
    def end_of_path(self) -> float:
        """Time at which the nozzle reaches the end of the path [s]."""
        return self.dwell_before + (self.length / self.speed if self._motion is None
                                    else self._motion.duration)

    @property
    def duration(self) -> float:
        """Time from the job's start to its end [s]."""
        return self.end_of_path + self.dwell_after

    @cached_property
    def deposit(self) -> Deposit:
        """Ink of the complete print, in the surface frame."""
        return self.ink or replace(
            self.commanded, profile=self.printed_width or self.commanded.profile,
            gaps=np.concatenate((self.commanded.gaps, self.faults)))

    def laid(self, t: Times) -> Array:
        """Return the arc length (...) that the nozzle has covered at times t (...) [m]."""
        since = np.asarray(t) - self.dwell_before
        if self._motion is not None:
            return self._motion.arc_length(since)
        return np.clip(since * self.speed, 0.0, self.length)

    def tip(self, t: Times) -> Array:
        """Return the nozzle tip (..., 3) at times t (...) in the base frame [m]."""
        s = self.laid(t)
        planar = self.commanded.curve.points(s.ravel()).reshape(*s.shape, 2)
        height = self.tip_height + self.lift * self._lifted(np.asarray(t))
        if self._motion is not None:
            height += self._motion.height(np.asarray(t) - self.dwell_before)
        points = self.surface.points(planar.reshape(-1, 2), height.ravel())
        return transform(self.T_base_surface, points.reshape(*s.shape, 3))

    def flange_pose(self, t: Times) -> Array:
        """Return T_base_flange (..., 4, 4) at times t (...)."""
        tip = self.tip(t)
        R_base_flange = self.T_base_surface[:3, :3] @ self.R_surface_flange
        pose = np.zeros((*tip.shape[:-1], 4, 4))
        pose[..., :3, :3] = R_base_flange
        pose[..., :3, 3] = tip - R_base_flange @ self.nozzle_offset
        pose[..., 3, 3] = 1.0
        return pose

    def extruding(self, t: Times) -> NDArray[np.bool_]:
        """Tell whether the plunger is commanded to push at times t (...).

        It lays ink, or makes up for a retraction.
        """
        return np.asarray(self.plunger_velocity(t) > 0)

    def flow_rate(self, t: Times) -> Array:
        """Return the commanded volume of ink per time (...) at times t (...) [m^3/s].

        Along strokes it follows from the mass balance of a filament of the commanded width:
        filament width^2 speed. It is below 0 in a retraction.
        """
        t = np.asarray(t)
        s = self.laid(t)
        laying = (t >= self.dwell_before) & (t < self.end_of_path) & self.commanded.inked(s)
        retracting: Array | float = 0.0
        if self._motion is not None:
            since = t - self.dwell_before
            laying &= self._motion.on_stroke(since)
            retracting = self._motion.pushing(since) * PLUNGER_AREA_M2
        speed = self.speed if self.motion is None else self.motion.speed(t - self.dwell_before)
        width = self.commanded.profile(s)
        return np.where(laying, self.filament * width**2 * speed, retracting)

    def plunger_velocity(self, t: Times) -> Array:
        """Return the velocity (...) of the syringe's plunger at times t (...) [m/s]."""
        return self.flow_rate(t) / PLUNGER_AREA_M2

    def plunger_position(self, t: Times) -> Array:
        """Return how far the plunger has moved (...) at times t (...) [m]."""
        s = self.laid(t)
        nodes, moved = self._plunger_table
        position = np.zeros(s.shape)
        for start, end in self.commanded.runs:
            position += (np.interp(np.clip(s, start, end), nodes, moved)
                         - np.interp(start, nodes, moved))
        if self._motion is not None:
            position -= self._motion.retracted(np.asarray(t) - self.dwell_before)
        return position

    def truth(self, s: Array) -> Array:
        """Return the true width (N,) of the complete print at arc lengths (N,) [m]; 0 in gaps."""
        return self.deposit.width(s)

    def capture(self, t: float, number: int, stamp_ns: int = 0) -> Capture:
        """Return the capture of a number at time t [s], with the robot where it is then.

        The number seeds the noise, so that a capture can be made again.
        """
        return render(self.scene(t), self.view, self.sensor,
                      np.random.default_rng((self.seed, number)), stamp_ns)

    def scene(self, t: float) -> Scene:
        """Return what stands before the camera at time t [s]."""
        T_flange_tip = np.eye(4)
        T_flange_tip[:3, 3] = self.nozzle_offset
        first, *above = self.laid_layers(t)
        return Scene(first, self.T_base_surface, self.flange_pose(t) @ T_flange_tip, self.nozzle,
                     self.surface, tuple(above))

    def laid_layers(self, t: float) -> list[Deposit]:
        """Return the ink of each layer at time t [s], as far as it is begun; the first always."""
        laid = float(self.laid(t))
        deposit = replace(self.deposit, laid=laid)
        if not len(self.layers):
            return [deposit]
        return [deposit.within(start, end) for number, (start, end) in enumerate(
            self.layers.tolist()) if start < laid or number == 0]

    @cached_property
    def _motion(self) -> Motion | None:
        if self.motion is None and self.travels:
            return Motion.with_travel(self.length, self.speed, self.travels)
        return self.motion

    @cached_property
    def _plunger_table(self) -> tuple[Array, Array]:
        """Arc lengths (K,), and how far the plunger would move up to there without gaps [m]."""
        nodes = self.commanded.curve.uniform(PLUNGER_NODES)
        squared = self.commanded.profile((nodes[1:] + nodes[:-1]) / 2)**2
        moved = np.cumsum(squared * np.diff(nodes)) * self.filament / PLUNGER_AREA_M2
        return nodes, np.concatenate(([0.0], moved))

    def _lifted(self, t: Array) -> Array:
        """Return the height (...) above the printing height as a fraction of ``lift``.

        Motion starts and stops softly.
        """
        lowering = (t - self.dwell_before / 2) / (self.dwell_before / 2)
        lifting = (t - self.end_of_path) / (self.dwell_after / 2)
        part = np.clip(np.where(t < self.dwell_before, 1 - lowering, lifting), 0.0, 1.0)
        return part**2 * (3 - 2 * part)
