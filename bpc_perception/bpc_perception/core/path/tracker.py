"""Where prints begin and end."""

from __future__ import annotations

from collections import deque
import math

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path.assembler import PathAssembler
from bpc_perception.core.path.continuation import goes_on
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.core.path.leaps import contradicts, LeapFinder, Step, Trust
from bpc_perception.core.path.print_id import print_id_of
from bpc_perception.core.robot.poses import JITTER_M


class JumpError(ValueError):
    """The nozzle tip cannot have moved to where a pose puts it."""


class PrintTracker:
    """Starts and stops prints, on request or by itself when ink is pushed out.

    A print that stopped by itself goes on when ink is pushed out beside or above what was laid: it
    was a pause. One that was stopped on request does not.

    A little history is kept, so that a print starts and stops at the stamps that say so, and
    not with the messages that happened to have arrived.

    Attributes:
        leaps: how many poses were wrong, or such that the way to them is not known, see ``leaps``.
    """

    HISTORY_S = 5.0

    def __init__(self, config: PathConfig) -> None:
        self._config = config
        self._poses: deque[Step] = deque()
        self._finder, self._trust = LeapFinder(), Trust()
        self._lost_way = False  # since the last pose that was taken
        self.leaps = 0
        self._newest: tuple[int, Array] | None = None  # stamp and position of the tip
        self._states: deque[ExtruderSample] = deque()
        self._print: PathAssembler | None = None
        self._running = False
        self._last_extruding_ns = 0
        self._may_go_on = False
        # When ink came after a pause, until it is known where.
        self._undecided_ns: int | None = None
        self._flows_on = False  # since a stop on request

    def add_pose(self, stamp_ns: int, tip: Array) -> bool:
        """Add a position (3,) of the nozzle tip in the robot base frame [m].

        Return False, and add nothing, unless it is later than the last.

        Raises JumpError if the tip would have been faster than it can. A jump that lasts is
        believed as soon as there was time enough to get there.
        """
        if self._newest is not None:
            last_ns, last = self._newest
            if stamp_ns <= last_ns:
                # Of one stamp the first counts: others publish zeros for joints they do not know.
                self._lost_way |= stamp_ns < last_ns and contradicts(self._poses, stamp_ns, tip)
                return False
            reach = self._config.maximum_speed * (stamp_ns - last_ns) * 1e-9 + JITTER_M
            if math.dist(tip.tolist(), last.tolist()) > reach:
                raise JumpError('pose: expected a tip that moves no faster than '
                                f'{self._config.maximum_speed:g} m/s, found a jump'
                                '; let one robot alone publish, or raise path.maximum_speed')
        self._newest = stamp_ns, tip
        for step in self._finder.add(stamp_ns, tip):
            self._take(step)
        self._decide()
        return True

    def _take(self, step: Step) -> None:
        """Take a pose whose step is certain."""
        believed = self._trust.add(step.stamp_ns, step.leap or step.wrong)
        step = step._replace(leap=step.leap or self._lost_way)
        self.leaps += step.leap or step.wrong
        self._lost_way = (step.wrong and self._lost_way) or not believed
        if step.wrong or not believed:
            return
        self._poses.append(step)
        while step.stamp_ns - self._poses[0].stamp_ns > self.HISTORY_S * 1e9:
            self._poses.popleft()
        # A state that arrives early starts a print before poses from before its start arrive.
        if self._print is not None and step.stamp_ns >= self._print.start_ns:
            self._print.add_pose(step.stamp_ns, step.tip, step.leap)

    def add_extruder(self, sample: ExtruderSample) -> bool:
        """Add a state of the extruder; return False unless it is later than the last."""
        if self._states and sample.stamp_ns <= self._states[-1].stamp_ns:
            return False
        self._states.append(sample)
        while sample.stamp_ns - self._states[0].stamp_ns > self.HISTORY_S * 1e9:
            self._states.popleft()
        if self._config.auto:
            # Before the print takes the state, which would make it complete beyond its end.
            self._stop_after_pause(sample.stamp_ns)
        if self._print is not None:
            self._print.add_extruder(sample)
        self._flows_on &= sample.extruding
        if self._config.auto and sample.extruding:
            self._take_note_of_extrusion(sample.stamp_ns)
        return True

    def _stop_after_pause(self, stamp_ns: int) -> None:
        """Stop the print if by this time no ink was pushed out for ``auto_stop_after``."""
        pause_ns = round(self._config.auto_stop_after * 1e9)
        if stamp_ns - self._last_extruding_ns > pause_ns:
            self._stop(self._last_extruding_ns + pause_ns)

    def _take_note_of_extrusion(self, stamp_ns: int) -> None:
        """Remember when ink was pushed out last, and start a print unless one is running."""
        self._last_extruding_ns = max(self._last_extruding_ns, stamp_ns)
        if self._running or self._undecided_ns is not None or self._flows_on:
            return
        if self._may_go_on:
            self._undecided_ns = stamp_ns
            self._decide()
        else:
            self.start(stamp_ns)

    def _decide(self) -> None:
        """Go on with the print or start another, once it is known where ink came after a pause."""
        stamp_ns = self._undecided_ns
        if stamp_ns is None:
            return
        tip = next((step.tip for step in self._poses if step.stamp_ns >= stamp_ns), None)
        if tip is None:
            return
        self._undecided_ns = None
        assert self._print is not None
        path = self._print.growing_path()
        if not goes_on(path.path(), stamp_ns, tip):
            self.start(stamp_ns)
            return
        self.resume(path, stamp_ns)

    def start(self, stamp_ns: int) -> str:
        """Start a new print at this time and return its id; a running one is given up."""
        print_id = print_id_of(stamp_ns)
        self.resume(GrowingPath(print_id, stamp_ns), stamp_ns)
        return print_id

    def resume(self, path: GrowingPath, stamp_ns: int) -> None:
        """Go on with a print from this time on, with what is remembered of poses and states.

        What was laid since it was left off is not known. The pause that ends a print by itself
        counts from this time.
        """
        path.finished = False
        self._print = PathAssembler(path, self._config)
        for sample in self._states:  # before the poses, for which they were not too late
            self._print.add_extruder(sample)
        for step in self._poses:
            if step.stamp_ns >= stamp_ns:
                self._print.add_pose(step.stamp_ns, step.tip, step.leap)
        self._running = self._may_go_on = True
        self._undecided_ns, self._flows_on = None, False
        self._last_extruding_ns = max(self._last_extruding_ns, stamp_ns)

    def stop(self, stamp_ns: int) -> bool:
        """Let the running print end at this time, for good; return False if none runs.

        Ink that flows on meanwhile starts no other.
        """
        stopped = self._stop(stamp_ns)
        at_stop = [sample.extruding for sample in self._states if sample.stamp_ns <= stamp_ns][-1:]
        later = [sample.extruding for sample in self._states if sample.stamp_ns > stamp_ns]
        self._flows_on = stopped and bool(at_stop) and all(at_stop + later)
        self._may_go_on = False
        self._undecided_ns = None
        return stopped

    def follow(self, path: DepositionPath) -> None:
        """Take from a path as it was recorded what the recorder was told: start, stop or clear.

        What it did by itself is not taken: that follows from poses and states.
        """
        if not path.print_id:
            self.clear()
            return
        by_itself = any(sample.stamp_ns == path.start_ns and sample.extruding
                        for sample in self._states)
        if self._print is None or path.start_ns > self._print.start_ns:
            if not by_itself:
                self.start(path.start_ns)
        elif path.start_ns == self._print.start_ns and path.finished and self._running:
            self.stop(path.start_ns + round(path.complete_until * 1e9))

    def end(self) -> GrowingPath | None:
        """End the running print for good, with what is known of it by now; None = none runs."""
        if self._print is None or not self._running:
            return None
        path = self._print.growing_path()
        path.finished = True
        self._running = self._may_go_on = False
        return path

    def _stop(self, stamp_ns: int) -> bool:
        """Let the running print end at this time; return False if none runs."""
        if self._print is None or not self._running:
            return False
        self._print.stop(stamp_ns)
        self._running = False
        return True

    def clear(self) -> None:
        """Forget the print and all history, as is needed when the clock jumps back."""
        self._poses.clear()
        self._newest, self._finder, self._trust = None, LeapFinder(), Trust()
        self._lost_way = False
        self._states.clear()
        self._print = None
        self._running = self._may_go_on = self._flows_on = False
        self._undecided_ns = None

    def path(self) -> DepositionPath | None:
        """Return the path of the running or last print; None before the first."""
        return self._print.path() if self._print is not None else None

    def growing_path(self) -> GrowingPath | None:
        """Return the same as a path that grows, from which later calls can take what is new."""
        return self._print.growing_path() if self._print is not None else None
