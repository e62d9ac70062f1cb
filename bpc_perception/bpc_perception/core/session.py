"""One print that is measured: captures wait here until path and poses reach their stamp."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import replace
import logging

from bpc_perception.core.advice.advisor import Advisor
from bpc_perception.core.advice.rate_advice import Reason
from bpc_perception.core.advice.setup import Setup
from bpc_perception.core.arrays import Array
from bpc_perception.core.calibration.misfits import what_would_fit
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.capture.exposure import around, Exposure
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.design.comparison import DesignComparison, DesignFollower, WantedDesign
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.inspection.verdict import judge, PrintVerdict
from bpc_perception.core.learning.layer_learner import LayerLearner
from bpc_perception.core.learning.layer_schedule import LayerSchedule
from bpc_perception.core.measurement.cross_section.incremental import PrintMemory
from bpc_perception.core.measurement.ground import Ground
from bpc_perception.core.measurement.measure import (
    measure,
    MeasurementError,
    TooEarlyError,
)
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.path.leaps import LEAPT, Whereabouts
from bpc_perception.core.profile import ThicknessProfile
from bpc_perception.core.repair.planner import plan_repair
from bpc_perception.core.result import Result
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.core.robot.poses import PoseBuffer
from bpc_perception.core.targets import WidthTargets
from bpc_perception.core.watch.extruder_flag import extruder_contradiction

STANDING_S = 0.5  # without a path point, for which ink is laid no longer
BEGINNING_S = 5.0  # around the begin of a print, in which captures may come too early
MOST_CLIPPED = 0.2  # share of the picture around the path that may be overexposed

logger = logging.getLogger(__name__)


class Session:
    """Measures captures in order, each as soon as path and flange poses cover its stamp.

    Live and offline runs both go through here, so that they give the same numbers.

    Attributes:
        config: how to measure, from now on.
    """

    MAXIMUM_WAITING = 4  # captures that may wait live for the path; each may be 46 MB

    def __init__(self, config: ThicknessConfig, hand_eye: HandEye,
                 setup: Setup | None = None, design: WantedDesign | None = None,
                 learned: LayerSchedule | None = None) -> None:
        """Begin, perhaps with the setup of the prints before, their design and schedule."""
        self.config = config
        self._hand_eye = hand_eye
        self._poses, self._whereabouts = PoseBuffer(), Whereabouts()
        self._path: DepositionPath | None = None
        self._waiting: deque[tuple[Capture, int]] = deque()  # and when each was received [ns]
        self._newest = ('', 0)  # print and stamp of the newest capture that had its turn
        self._counts: Counter[str] = Counter()  # of each print, measured so far
        targets = config.advice.target_file
        self._targets = WidthTargets.read(targets) if targets else None
        self._advisor = Advisor(setup=setup)
        self._design = DesignFollower(design) if design else None
        self._learner = LayerLearner(learned)
        self._memory, self._ground = PrintMemory(), Ground()

    @property
    def setup(self) -> Setup:
        """What the newest print was set up with."""
        return self._advisor.setup

    @property
    def schedule(self) -> LayerSchedule:
        """The factors for the layer that is printed, or the next."""
        return self._learner.told

    def add_capture(self, capture: Capture, received_ns: int = 0) -> None:
        """Queue a capture, received at this time of the caller's clock [ns]."""
        self._waiting.append((capture, received_ns))

    def add_flange_pose(self, stamp_ns: int, T_base_flange: Array) -> bool:
        """Add a pose (4, 4) of the flange [m]; return False if it is refused, see PoseBuffer."""
        taken = self._poses.add(stamp_ns, T_base_flange)
        if taken:
            self._whereabouts.add(stamp_ns, T_base_flange[:3, 3])
        return taken

    def set_path(self, path: DepositionPath) -> None:
        """Replace the print's path by what is known of it now."""
        self._path = path

    @property
    def waiting(self) -> int:
        """Number of captures not measured yet."""
        return len(self._waiting)

    def skip_overtaken(self) -> int:
        """Forget captures that are no longer worth measuring live; return how many.

        Forgotten are all but the newest of those that can be measured by now, and the oldest if
        more than ``MAXIMUM_WAITING`` wait.
        """
        waiting = list(self._waiting)
        ready = [index for index, (capture, _) in enumerate(waiting) if self._ready(capture)]
        overtaken = {*ready[:-1], *range(len(waiting) - self.MAXIMUM_WAITING)}
        self._waiting = deque(entry for index, entry in enumerate(waiting)
                              if index not in overtaken)
        return len(overtaken)

    def clear(self) -> None:
        """Forget everything received, as is needed when the clock jumps back."""
        self._poses, self._whereabouts = PoseBuffer(), Whereabouts()
        self._path = None
        self._waiting.clear()
        self._newest = ('', 0)
        self._counts.clear()
        self._advisor = Advisor(setup=self.setup)
        self._design = DesignFollower(self._design.wanted) if self._design else None
        self._learner.forget_print()
        self._memory, self._ground = PrintMemory(), Ground()

    def results(self, now_ns: int = 0, finish: bool = False) -> Iterator[Result]:
        """Yield the results of all captures that are ready or have waited too long.

        Args:
            now_ns: by the caller's clock [ns]; ``config.patience`` later than it was received a
                capture is measured with the path there is.
            finish: nothing more will come, so measure all captures.
        """
        patience_ns = self.config.patience * 1e9
        while self._waiting:
            capture, received_ns = self._waiting[0]
            if not (finish or self._ready(capture) or now_ns - received_ns > patience_ns):
                return
            self._waiting.popleft()
            yield self._measure(capture)

    def _ready(self, capture: Capture) -> bool:
        posed = self._hand_eye.on_base or self._whereabouts.certain_ns >= capture.stamp_ns
        return posed and self._path is not None and self._path.covers(capture.stamp_ns)

    def _measure(self, capture: Capture) -> Result:
        path = self._path
        if path is None or not path.print_id:
            self._see_ground(capture)
            return Result(capture, refusal='path: expected a print, found none started'
                                           '; push ink out, or call path_recorder/start',
                          premature=True)
        refusal = self._untimely(capture, path)
        if refusal:
            return Result(capture, refusal=refusal, premature=just_begun(capture, path))
        self._newest = (path.print_id, capture.stamp_ns)
        T_base_camera = self._hand_eye.camera_pose(self._poses, capture.stamp_ns,
                                                   self.config.maximum_pose_gap)
        if not self._hand_eye.on_base and not self._whereabouts.known_at(capture.stamp_ns):
            return Result(capture, refusal=LEAPT)
        if T_base_camera is None:
            return Result(capture, refusal='end_effector_pose: expected poses around the '
                                           'capture, found none near enough in time'
                                           '; see that they come evenly, or raise '
                                           'maximum_pose_gap')
        return self._profile_and_advice(capture, path, T_base_camera)

    def _untimely(self, capture: Capture, path: DepositionPath) -> str:
        """Return why a capture of this stamp is not measured; empty = it is."""
        if capture.stamp_ns < path.start_ns:
            self._see_ground(capture)
            return (f'path: expected a print begun before the capture, found '
                    f'{path.print_id}; do the clocks agree?')
        newest_print, newest_ns = self._newest
        if path.print_id == newest_print and capture.stamp_ns <= newest_ns:
            return ('capture: expected a later stamp than the last, found it late or twice; let '
                    'one camera alone publish, with a stamp for each capture')
        return ''

    def _see_ground(self, capture: Capture) -> None:
        """Remember what lies on the bed before a print."""
        T_base_camera = self._hand_eye.camera_pose(self._poses, capture.stamp_ns,
                                                   self.config.maximum_pose_gap)
        if T_base_camera is not None:
            self._ground.see(View(capture, T_base_camera))

    def _profile_and_advice(self, capture: Capture, path: DepositionPath,
                            T_base_camera: Array) -> Result:
        number = self._counts[path.print_id]
        try:
            profile = measure(capture, path, T_base_camera, self.config, number, self._memory,
                              self._ground)
            off_path = profile.off_path(self.config.maximum_offset)
            extruder = extruder_contradiction(path.until(capture.stamp_ns))
            design = self._design.compare(profile, path) if self._design else None
            targets = self._targets_of(profile, design)
            advising = (self.config.advice if targets is not None else
                        replace(self.config.advice, target_thickness=0.0))
            self._learner.look(profile, path, targets, self.setup.gain, self.config)
            advice = self._advisor.advise(
                profile, path, advising, Reason.EXTRUDER_FAULT if extruder else
                Reason.PATH_OFFSET if off_path else None, targets,
                self._learner.planned(path, self.config))
            self._learner.hear(advice)
            verdict = self._judge(profile, path, capture.stamp_ns, targets, design)
            repair = plan_repair(profile, verdict, advice.reason, targets, self.config.tolerance,
                                 self.config.repair)
            # Without strokes ink seems to lie anywhere; beside its path, to be of another print.
            warnings = (extruder or off_path or self._ground.warning,
                        overexposed(capture, T_base_camera, profile),
                        design.warning(profile) if design else '',
                        self._hand_eye.contradiction(self.config.base_frame, capture.frame_id))
        except MeasurementError as error:
            flange = self._poses.at(capture.stamp_ns, self.config.maximum_pose_gap)
            early = isinstance(error, TooEarlyError) and just_begun(capture, path)
            hint = '' if early else what_would_fit(
                capture, path.until(capture.stamp_ns).points, self._hand_eye, T_base_camera,
                flange)
            return Result(capture, T_base_camera, refusal=str(error) + hint, premature=early)
        except Exception as error:  # a defect of ours must not end a print's feedback
            logger.exception('measurement failed')
            return Result(capture, T_base_camera,
                          refusal=f'measurement: expected a result, found {error!r}'
                                  '; please report it with the log')
        self._counts[path.print_id] += 1  # a capture that was refused has no number
        return Result(capture, T_base_camera, profile, advice, verdict, design, repair,
                      self._learner.told, warning='; '.join(filter(None, warnings)))

    def _targets_of(self, profile: ThicknessProfile,
                    design: DesignComparison | None) -> WidthTargets | None:
        """Return the widths wanted along a print: the design's, where it tells them."""
        others = WidthTargets.wanted(self._targets, self.config.advice.target_thickness)
        return design.targets(profile.arc_length, others) if design else others

    def _judge(self, profile: ThicknessProfile, path: DepositionPath, stamp_ns: int,
               targets: WidthTargets | None, design: DesignComparison | None) -> PrintVerdict:
        """Judge what is known of a print; it ended where all of its path was laid by then."""
        laid = path.until(stamp_ns)
        ended = path.finished and len(laid) == len(path)
        age = (stamp_ns - path.start_ns) * 1e-9 - laid.time[-1:]
        laying = bool((laid.extruding[-1:] & (age < STANDING_S)).any())
        return judge(profile, targets, self.config.tolerance, ended, laying, design)


def just_begun(capture: Capture, path: DepositionPath) -> bool:
    """Return whether a capture is from shortly before or after the begin of a print.

    Then it is no fault that nothing is laid yet.
    """
    return abs(capture.stamp_ns - path.start_ns) < BEGINNING_S * 1e9


def overexposed(capture: Capture, T_base_camera: Array, profile: ThicknessProfile) -> str:
    """Return a warning if much of the picture around the path is overexposed; empty = not."""
    uv = capture.camera.pixels(transform(invert(T_base_camera), profile.points))
    clipped = Exposure.of(around(capture, uv)).clipped
    if not clipped > MOST_CLIPPED:
        return ''
    return (f'image: expected ink and bed within its range, found {clipped:.0%} of the pixels '
            'around the path overexposed: what is beside them is not measured; expose it less')
