"""Follows prints capture by capture: learns from each layer that is done, for the next alike."""

from __future__ import annotations

from dataclasses import dataclass, replace
import logging

import numpy as np

from bpc_perception.core.advice.planned import Planned
from bpc_perception.core.advice.rate_advice import RateAdvice, Reason
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.learning.layer_record import LayerRecord
from bpc_perception.core.learning.layer_schedule import LayerSchedule, ScheduleReason
from bpc_perception.core.learning.learner import Learner, LEAST_COVERAGE
from bpc_perception.core.learning.same_way import places_on
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.targets import WidthTargets

WAYS_KEPT = 4  # of which layers are remembered: those of a scaffold take turns
MOST_FAULTY = 0.2  # share of a layer that may be gaps, and of its captures that may be alarms
ALARMS = (Reason.GAP_DETECTED, Reason.CLOG_SUSPECTED, Reason.PATH_OFFSET, Reason.EXTRUDER_FAULT)
LEAST_TIME_S = 3.0  # that a layer takes: the lag of one that takes less is not known
SPEED_S = 0.5  # over which the present speed is taken

logger = logging.getLogger(__name__)


@dataclass
class _Layer:
    """What is kept of the layer that is being printed.

    Attributes:
        number: within its print; -1 = nothing is laid yet.
        captures, alarms: how many there were.
        since: arc length of the path from which on there is a schedule [m].
        began: arc length of the path at its first ink [m].
        further: what makes places of the layer places of the schedule [m].
    """

    number: int = -1
    captures: int = 0
    alarms: int = 0
    since: float = 0.0
    began: float = 0.0
    further: float = 0.0


class LayerLearner:
    """Makes a schedule for each layer whose path was printed before, and watches that it fits.

    Args:
        kept: what was learned in prints before; None = nothing.

    Attributes:
        told: the newest schedule.
    """

    def __init__(self, kept: LayerSchedule | None = None) -> None:
        self._kept = kept
        # One for each way, that of the newest layer last, and what it makes of its layers.
        self._ways: list[tuple[Learner, LayerSchedule]] = []
        self._first: LayerSchedule | None = None  # for a layer as the first of the print
        self._refusal = ScheduleReason.NOTHING_LEARNED  # of the newest layer that is done
        self._print_id, self._layer, self._over = '', _Layer(), False
        self._next = kept or LayerSchedule.none(0)  # for the next print
        self.told = self._next

    def forget_print(self) -> None:
        """Forget the print that was going on; what was learned before is for the next."""
        self._print_id, self._layer, self._over = '', _Layer(), False
        self.told = self._next

    def look(self, profile: ThicknessProfile, path: DepositionPath,
             targets: WidthTargets | None, gain: float, config: ThicknessConfig) -> None:
        """Take note of a capture, before there is advice on it.

        Args:
            profile: what was measured in it.
            path: of the print.
            targets: widths wanted along the print; None = none, nothing is learned.
            gain: logarithm of w^2 per volume that the print was set up with; NaN = not known.
            config: limits on the factors, and whether they are followed.
        """
        if not config.learning.enabled:
            return
        try:
            self._look(profile, path, targets, gain, config)
        except Exception:  # a defect of ours must not end a print's feedback
            logger.exception('learning failed; please report it with the log')
            self._over = True
            self.told = LayerSchedule.none(profile.stamp_ns, self._print_id)

    def _look(self, profile: ThicknessProfile, path: DepositionPath,
              targets: WidthTargets | None, gain: float, config: ThicknessConfig) -> None:
        if profile.print_id != self._print_id:
            self._print_id, self._layer, self._over = profile.print_id, _Layer(), False
            self._first = None
        laid = profile.layer[profile.layer >= 0]
        if not len(laid) or self._over:
            return
        stamp_ns, number = profile.stamp_ns, int(laid[-1])
        if number < self._layer.number:  # as of the next of several objects: which layer is whose?
            self._over = True
            self.told = LayerSchedule.none(stamp_ns, self._print_id, number)
            return
        if number > self._layer.number:
            if self._layer.number >= 0:
                self._take(profile, path, targets, gain, config)
            self._layer = _Layer(number)
            self._begin(profile, path)
        elif self.told.valid:
            further = self._place_on(self.told, profile, path)
            if further is None:
                self.told = LayerSchedule.none(stamp_ns, self._print_id, number,
                                               ScheduleReason.OTHER_PATH)
            else:
                self._layer.further = further
        if path.finished and len(profile) == len(path):
            self._take(profile, path, targets, gain, config)
            self._over = True
            self.told = (LayerSchedule.none(stamp_ns, reason=self._refusal)
                         if self._first is None else
                         replace(self._first, stamp_ns=stamp_ns, print_id='', layer=0))
            self._next = self.told

    def planned(self, path: DepositionPath, config: ThicknessConfig) -> Planned | None:
        """Return what is scheduled along a path that goes on, if the controller follows it."""
        schedule, layer = self.told.schedule, self._layer
        if (schedule is None or not config.learning.followed or self._over or layer.number < 0
                or len(path) < 2):
            return None
        arc, further = path.arc_length, layer.further - layer.began
        first = min(int(np.searchsorted(path.time, path.time[-1] - SPEED_S)), len(path) - 2)
        speed = (arc[-1] - arc[first]) / (path.time[-1] - path.time[first])
        reach = np.linspace(arc[-1], arc[-1] + speed * config.advice.lifetime, 200)
        ahead = schedule.at(reach + further)
        factor = np.where(arc >= layer.since, schedule.at(arc + further), 1.0)
        return Planned(factor, layer.since, (float(ahead.min()), float(ahead.max())),
                       schedule.level_sigma)

    def hear(self, advice: RateAdvice) -> None:
        """Take note of the advice after a capture: what comes with alarms is not learned from."""
        self._layer.captures += 1
        self._layer.alarms += advice.reason in ALARMS

    def _take(self, profile: ThicknessProfile, path: DepositionPath,
              targets: WidthTargets | None, gain: float, config: ThicknessConfig) -> None:
        """Learn from the layer that is done."""
        record = (None if targets is None else
                  LayerRecord.of(path, profile, targets, self._layer.number))
        self._refusal = self._refused(record, np.isnan(gain) or targets is None)
        if record is None or self._refusal != ScheduleReason.LEARNED:
            return
        followed = self.told.schedule if config.learning.followed else None
        learner = next((one for one, made in reversed(self._ways)
                        if _same_way(made, record) and one.take(record, followed)), None)
        if learner is None:
            learner = Learner(config.advice, gain)
            learner.take(record, followed)
        made = _made(learner, profile.stamp_ns)
        self._ways = [*(way for way in self._ways if way[0] is not learner),
                      (learner, made)][-WAYS_KEPT:]
        if self._layer.number == 0:
            self._first = made

    def _refused(self, record: LayerRecord | None, aimless: bool) -> ScheduleReason:
        """Return why nothing is learned from a record; LEARNED = it is."""
        if aimless:
            return ScheduleReason.NOTHING_LEARNED
        if record is None:
            return ScheduleReason.NOT_RECORDED
        pushing = np.nan_to_num(record.rate) > 0
        gaps = float((record.width[pushing] == 0).mean()) if pushing.any() else 1.0
        alarms = self._layer.alarms / max(self._layer.captures, 1)
        if max(gaps, alarms) > MOST_FAULTY:
            return ScheduleReason.FAULTS
        if (record.coverage < LEAST_COVERAGE or record.usable.mean() < LEAST_COVERAGE / 2
                or record.time[-1] - record.time[0] < LEAST_TIME_S):
            return ScheduleReason.NOT_ENOUGH_SEEN
        return ScheduleReason.LEARNED

    def _begin(self, profile: ThicknessProfile, path: DepositionPath) -> None:
        """Tell the schedule for a layer that begins: of the ways that fit the least recent.

        Layers of a scaffold take turns, and at their begin several may fit.
        """
        number, stamp_ns = self._layer.number, profile.stamp_ns
        known = self.told.valid and not self.told.print_id  # told before the print began
        made = [one for _, one in self._ways] + ([self._kept] if self._kept else [])
        for one in filter(lambda one: one.valid, made):
            further = self._place_on(one, profile, path)
            if further is not None:
                self.told = replace(one, stamp_ns=stamp_ns, print_id=self._print_id, layer=number)
                self._layer.further = further
                self._layer.since = self._layer.began if known else float(path.arc_length[-1])
                return
        reason = self._refusal or ScheduleReason.NOTHING_LEARNED
        if any(one.valid for one in made):
            reason = ScheduleReason.OTHER_PATH
        self.told = LayerSchedule.none(stamp_ns, self._print_id, number, reason)

    def _place_on(self, told: LayerSchedule, profile: ThicknessProfile,
                  path: DepositionPath) -> float | None:
        """Return what makes places of this layer those of a schedule [m]; None = it leaves it."""
        mine = profile.time[np.argmax(profile.layer == self._layer.number)]
        path = path.where(path.time >= mine)
        assert told.schedule is not None
        if not path.extruding.any():
            return 0.0
        path = path.where(np.arange(len(path)) >= np.argmax(path.extruding))
        self._layer.began = float(path.arc_length[0])
        return places_on(told.schedule.place, told.points, path.arc_length - self._layer.began,
                         path.points)


def _same_way(made: LayerSchedule, record: LayerRecord) -> bool:
    """Return whether a layer went the way of a schedule."""
    if made.schedule is None:
        return False
    ink = slice(record.strokes[0, 0], record.strokes[-1, 1])
    return places_on(made.schedule.place, made.points, record.place[ink],
                     record.points[ink]) is not None


def _made(learner: Learner, stamp_ns: int) -> LayerSchedule:
    """Return what a learner makes of its layers."""
    schedule = learner.schedule()
    schedule = schedule and schedule.until(learner.end)
    if schedule is None or len(schedule.place) < 2 or not np.isfinite(schedule.factor).all():
        return LayerSchedule.none(stamp_ns)
    return LayerSchedule(stamp_ns, '', 0, ScheduleReason.LEARNED, schedule,
                         learner.points(schedule.place), learner.based_on)
