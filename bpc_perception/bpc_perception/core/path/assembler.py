"""From poses and extruder states to the path of a print, while it grows.

The same inputs give the same path to the last bit, however they are split into calls: live and
offline measurements have to agree. So a path point is only given out when nothing that arrives
later can change it.
"""

from __future__ import annotations

import math

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import PathConfig
from bpc_perception.core.extruder.sample import ExtruderSample
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.growing_path import GrowingPath
from bpc_perception.core.path.joiner import ExtruderJoiner
from bpc_perception.core.path.resampler import PathPoint, PathResampler
from bpc_perception.core.path.smoother import PoseSmoother


class PathAssembler:
    """The path of one print: smoothed, resampled, joined with the extruder's state.

    Times inside are in seconds after the start of the print.
    """

    def __init__(self, path: GrowingPath, config: PathConfig) -> None:
        """Append to a path: an empty one, or one that was left off."""
        self.start_ns = path.start_ns
        self._path = path
        self._extrusion_timeout = config.extrusion_timeout
        self._stop = math.inf
        self._smoother = PoseSmoother(config.smoothing_time)
        self._resampler = PathResampler(config, _last_point(path))
        self._joiner = ExtruderJoiner(config.extrusion_timeout)

    def add_pose(self, stamp_ns: int, tip: Array, leap: bool = False) -> None:
        """Add a position (3,) of the nozzle tip in the robot base frame [m]; stamps must increase.

        Behind a leap the way from the pose before is not known. Nothing happens where the path is
        complete already.
        """
        time = self._time(stamp_ns)
        if not self._path.finished and time > self._path.complete_until:
            self._smoother.add(time, tip, leap)

    def add_extruder(self, sample: ExtruderSample) -> None:
        """Add a state of the extruder; stamps must increase."""
        if self._path.finished:
            return
        time = self._time(sample.stamp_ns)
        if time < self._smoother.latest - self._extrusion_timeout:
            # Too late for points given up by now, whether or not anyone has asked for them.
            self._advance()
        self._joiner.add_state(time, sample)

    def stop(self, stamp_ns: int) -> None:
        """Let the path end at this time, or where it is complete if that is later."""
        self._advance()
        self._stop = max(self._time(stamp_ns), self._path.complete_until)

    def path(self) -> DepositionPath:
        """Return the path as far as it is certain by now."""
        return self.growing_path().path()

    def growing_path(self) -> GrowingPath:
        """Return the same as a path that grows, from which later calls can take what is new."""
        self._advance()
        return self._path

    def _advance(self) -> None:
        """Give out what is certain by now."""
        if self._path.finished:
            return
        known_until = self._joiner.known_until(self._smoother.latest)
        self._joiner.add_points(self._resampler.add(self._smoother.take(
            known_until, self._joiner.switches(self._smoother.needed_since))))
        complete = min(self._resampler.complete_until,
                       self._joiner.known_until(self._smoother.latest))
        until = min(complete, self._stop)
        self._joiner.join(until, self._path)
        # A path left off may be complete until later than the first poses heard since.
        self._path.complete_until = max(self._path.complete_until, until)
        self._path.finished = complete >= self._stop

    def _time(self, stamp_ns: int) -> float:
        return (stamp_ns - self.start_ns) * 1e-9


def _last_point(path: GrowingPath) -> PathPoint | None:
    if len(path) == 0:
        return None
    last = path.last()
    return PathPoint(last[0], last[1], last[2:])
