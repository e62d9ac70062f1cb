"""A small print as its messages: cheap enough to be printed a hundred thousand times."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from geometry_msgs.msg import Point, Pose, PoseStamped
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.special import ndtr
from std_msgs.msg import Header

from bpc_interfaces.msg import ExtrusionState
from bpc_perception.core.arrays import Array, Index
from bpc_perception.core.config import AdviceConfig, RecorderConfig, ThicknessConfig
from bpc_perception.core.robot.hand_eye import HandEye
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages
from bpc_perception.messages.stamps import ns_to_stamp
from bpc_perception.recording.bag import BagMessage
from bpc_sim.scene.planar_capture import planar_capture

START_NS = 1_750_000_000 * 10**9
SIZE_PX = (160, 120)
PIXEL_M = 4e-4
TARGET_M = 2e-3  # reached where all ink arrives
FLOW_M3_PER_S, PLUNGER_M_PER_S = 1.2e-8, 1e-4
POSE_PERIOD_S, STATE_PERIOD_S = 0.02, 0.04
STEP_M = 2e-4  # between the places of a path at which ink is drawn
DELAY_NS = 5_000_000  # from stamp to recording
BED, INK = np.array((190.0, 188.0, 180.0)), np.array((60.0, 80.0, 150.0))
BLUR_PX, NOISE = 0.7, 1.5
# Corners of paths [pixels].
SHAPES: dict[str, tuple[tuple[float, float], ...]] = {
    'line': ((15, 60), (145, 60)),
    'corner': ((20, 100), (90, 100), (90, 20)),
    'u-turn': ((20, 45), (120, 45), (120, 75), (30, 75)),
    'zigzag': ((20, 90), (60, 30), (100, 90), (140, 30))}

CONFIG = ThicknessConfig(advice=AdviceConfig(target_thickness=TARGET_M))
RECORDER = RecorderConfig()


@dataclass(frozen=True)
class SmallPrint:
    """A print on a plane bed, seen from above.

    Attributes:
        shape: name of its path.
        speed: of the nozzle [m/s].
        delivery: share of the commanded ink that arrives, from the start on.
        period: from capture to capture [s].
        seed: of the noise of the images.
    """

    shape: str
    speed: float
    delivery: float
    period: float
    seed: int

    @property
    def allowed_scale(self) -> float:
        """The factor on the flow that would reach the target."""
        return 1 / self.delivery

    @property
    def duration(self) -> float:
        """Of the print [s]."""
        return float(len(places(self.shape)) * STEP_M / self.speed)

    def messages(self) -> list[BagMessage]:
        """Return all messages in the order of recording."""
        states = [self._state(t) for t in np.arange(-0.2, self.duration + 0.3, STATE_PERIOD_S)]
        captures = [message for t in np.arange(self.period, self.duration + 0.2, self.period)
                    for message in self._capture(t)]
        return sorted((*self._poses(), *states, *captures), key=lambda message: message.log_ns)

    def _poses(self) -> list[BagMessage]:
        times = np.arange(-0.2, self.duration + 0.3, POSE_PERIOD_S)
        place = places(self.shape)
        step = np.clip(times * self.speed / STEP_M, 0, len(place) - 1)
        x, y, z = (np.interp(step, np.arange(len(place)), axis).tolist() for axis in place.T)
        return [_recorded(topics.POSE, time, PoseStamped(
            header=Header(stamp=ns_to_stamp(_stamp_ns(time)), frame_id=RECORDER.base_frame),
            pose=Pose(position=Point(x=x[each], y=y[each], z=z[each]))))
            for each, time in enumerate(times.tolist())]

    def _state(self, time: float) -> BagMessage:
        pushing = bool(0 <= time < self.duration)
        return _recorded(topics.EXTRUSION, time, ExtrusionState(
            header=Header(stamp=ns_to_stamp(_stamp_ns(time))), extruding=pushing,
            plunger_velocity=PLUNGER_M_PER_S * pushing, flow_rate=FLOW_M3_PER_S * pushing))

    def _capture(self, time: float) -> list[BagMessage]:
        number = round(time / self.period)
        rng = np.random.default_rng((self.seed, number))
        capture, _ = planar_capture(self.image(time, rng), PIXEL_M, _stamp_ns(time))
        return [_recorded(name, time, message) for name, message in zip(
            topics.CAMERA, capture_to_messages(capture), strict=True)]

    def image(self, time: float, rng: np.random.Generator) -> NDArray[np.uint8]:
        """Return what the camera sees at a time [s]: ink up to the nozzle."""
        nearest, distance = nearest_places(self.shape)
        half = TARGET_M * np.sqrt(self.delivery) / 2
        share = ndtr((half - distance) / (BLUR_PX * PIXEL_M))
        share[nearest * STEP_M > time * self.speed] = 0
        colour = BED + share[..., None] * (INK - BED) + rng.normal(0, NOISE, (*share.shape, 3))
        return np.clip(np.rint(colour), 0, 255).astype(np.uint8)


def random_print(rng: np.random.Generator) -> SmallPrint:
    """Return a print like others."""
    return SmallPrint(str(rng.choice(list(SHAPES))), float(rng.uniform(0.006, 0.015)),
                      float(rng.uniform(0.6, 1.4)), float(rng.uniform(0.7, 1.5)),
                      int(rng.integers(2**31)))


@cache
def hand_eye() -> HandEye:
    """Return where the camera is."""
    width, height = SIZE_PX
    return HandEye(True, planar_capture(np.zeros((height, width, 3), np.uint8), PIXEL_M)[1])


@cache
def places(shape: str) -> Array:
    """Return places (S, 3) along a path, ``STEP_M`` apart, in the base frame [m]."""
    centre = (np.array(SIZE_PX) - 1) / 2
    corners = (np.array(SHAPES[shape]) - centre) * (PIXEL_M, -PIXEL_M)
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
    along = np.arange(0, arc[-1], STEP_M)
    return np.column_stack((*(np.interp(along, arc, axis) for axis in corners.T), 0 * along))


@cache
def nearest_places(shape: str) -> tuple[Index, Array]:
    """Return for each pixel (H, W) the nearest place of a path, and how far it is [m]."""
    width, height = SIZE_PX
    v, u = np.mgrid[0:height, 0:width]
    pixels = np.stack(((u - (width - 1) / 2) * PIXEL_M, (v - (height - 1) / 2) * -PIXEL_M), -1)
    distance, nearest = cKDTree(places(shape)[:, :2]).query(pixels)
    return nearest, distance


def _recorded(topic: str, time: float, message: object) -> BagMessage:
    return BagMessage(f'/{topic}', _stamp_ns(time) + DELAY_NS, message)


def _stamp_ns(time: float) -> int:
    return START_NS + round(time * 1e9)
