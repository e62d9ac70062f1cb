"""A stand-in for the vendor's Python package ``zivid``, as far as a camera back end uses it.

Shapes, units, types, errors and the order of events are those of zivid-python 2.17: the cloud in
millimetres as float32 with NaN, four bytes a colour, linear unless asked for sRGB, RuntimeError
for whatever happens to the camera, capture calls that block while the camera projects, and
frames that block until they are processed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta, timezone
from pathlib import Path
import time
from types import ModuleType, SimpleNamespace, TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray
import yaml

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture

FORMATS = ('xyz', 'z', 'rgba', 'bgra', 'rgba_srgb', 'bgra_srgb', 'snr')


@dataclass
class Acquisition:
    """Exposure of one acquisition; nothing here depends on it."""

    brightness: float = 1.8


@dataclass
class Settings2D:
    """Settings of the colour image."""

    acquisitions: list[Acquisition] = field(default_factory=list)

    Acquisition = Acquisition


@dataclass
class Settings:
    """Settings of a capture."""

    acquisitions: list[Acquisition] = field(default_factory=list)
    color: Settings2D | None = None

    Acquisition = Acquisition

    @classmethod
    def load(cls, file_name: str | Path) -> Settings:
        """From a file as Zivid Studio saves it. Raises RuntimeError for another."""
        try:
            content = yaml.safe_load(Path(file_name).read_text())['Settings']
            colour = Settings2D([Acquisition()]) if content.get('Color') else None
            return cls([Acquisition() for _ in content['Acquisitions']], colour)
        except Exception as error:
            raise RuntimeError(f'Failed to load settings: {file_name}') from error


@dataclass
class ZividDouble:
    """A camera that may be unplugged, and the package through which it is reached.

    Attributes:
        see: what is before the camera at a time of time.time() [s], in metres, its colours in
            proportion to the light.
        acquisition, processing: how long it projects, and works afterwards [s].
        plugged: whether it is there.
        fails_while_processing: the next frame ends with an error.
        intrinsics_scale: of the intrinsics told, where they belong to another resolution.
        throttling: how long a capture waits before it begins [s].
        connections: how often it was connected.
        application: which is there; a process may have one at a time.
    """

    see: Callable[[float], Capture]
    acquisition: float = 0.15
    processing: float = 0.05
    plugged: bool = True
    fails_while_processing: bool = False
    intrinsics_scale: float = 1.0
    estimate_scale: float = 1.0
    throttling: float = 0.0
    connections: int = 0
    application: Application | None = None
    serial_number: str = '2020C0DE'

    def is_plugged(self) -> bool:
        """Whether the camera is there."""
        return self.plugged

    def modules(self) -> dict[str, ModuleType]:
        """The package, by the names under which it is imported."""
        zivid, experimental = ModuleType('zivid'), ModuleType('zivid.experimental')
        calibration = ModuleType('zivid.experimental.calibration')
        vars(zivid).update(Application=lambda: Application(self), Settings=Settings,
                           Settings2D=Settings2D, __version__='2.17.1')
        vars(calibration).update(
            intrinsics=lambda camera, settings=None: camera.intrinsics(settings),
            estimate_intrinsics=lambda frame: frame.intrinsics())
        return {'zivid': zivid, 'zivid.experimental': experimental,
                'zivid.experimental.calibration': calibration}


class Application:
    """Finds cameras."""

    def __init__(self, double: ZividDouble) -> None:
        if double.application is not None:
            raise RuntimeError('There is an application already')
        double.application = self
        self._double = double
        self._released = False

    def connect_camera(self, serial_number: str | None = None) -> Camera:
        """Connect a camera."""
        if self._released:
            raise RuntimeError('The application is released')
        if not self._double.is_plugged():
            raise RuntimeError('No Zivid cameras are connected')
        if serial_number not in (None, self._double.serial_number):
            raise RuntimeError(f'Camera with serial number {serial_number} not found')
        self._double.connections += 1
        return Camera(self._double)

    def release(self) -> None:
        """Let go of the SDK."""
        self._released = True
        self._double.application = None


class Camera:
    """A connected camera."""

    def __init__(self, double: ZividDouble) -> None:
        self._double = double
        self._connected = True
        self._seen: Capture | None = None

    @property
    def info(self) -> SimpleNamespace:
        """What it is."""
        return SimpleNamespace(model_name='Zivid 2 M70', firmware_version='1.2.3',
                               serial_number=self._double.serial_number)

    @property
    def state(self) -> SimpleNamespace:
        """How it is."""
        self._check()
        return SimpleNamespace(temperature=SimpleNamespace(
            dmd=41.5, general=38.25, led=44.0, lens=36.5, pcb=46.0))

    def capture_2d_3d(self, settings: Settings) -> Frame:
        """Project and take images; returns when that is done."""
        if not isinstance(settings, Settings):
            raise TypeError(f'Unsupported type for argument settings. Got {type(settings)}, '
                            'expected Settings.')
        if settings.color is None:
            raise RuntimeError('Settings.color must be set for a 2D+3D capture')
        self._check()
        time.sleep(self._double.throttling)
        begun = time.time()
        time.sleep(self._double.acquisition)
        self._check()
        # What stands before it halfway is as good as any instant, if nothing moves.
        self._seen = self._double.see(begun + self._double.acquisition / 2)
        return Frame(self._double, self._seen)

    def intrinsics(self, settings: Settings | None) -> SimpleNamespace:
        """Its intrinsics for the resolution of the settings."""
        del settings
        self._check()
        seen = self._seen or self._double.see(time.time())
        return told(seen, self._double.intrinsics_scale)

    def disconnect(self) -> None:
        """Give it back."""
        self._connected = False

    def _check(self) -> None:
        if not (self._connected and self._double.is_plugged()):
            raise RuntimeError('Camera is not connected')


class Frame:
    """What a capture leaves; a context manager that releases it."""

    def __init__(self, double: ZividDouble, seen: Capture) -> None:
        self._double = double
        self._seen = seen
        self._ready = time.monotonic() + double.processing
        self._released = False

    @property
    def info(self) -> SimpleNamespace:
        """When and how it was taken; the time stamp has whole seconds only."""
        return SimpleNamespace(
            time_stamp=datetime.now(timezone.utc).replace(microsecond=0),
            metrics=SimpleNamespace(
                acquisition_time=timedelta(seconds=self._double.acquisition),
                capture_time=timedelta(
                    seconds=self._double.acquisition + self._double.processing),
                throttling_time=timedelta(seconds=self._double.throttling)))

    def point_cloud(self) -> PointCloud:
        """The cloud, when it is processed."""
        if self._released:
            raise RuntimeError('The frame is released')
        time.sleep(max(self._ready - time.monotonic(), 0))
        if self._double.fails_while_processing:
            self._double.fails_while_processing = False
            raise RuntimeError('Error while processing the capture')
        return PointCloud(self._seen)

    def intrinsics(self) -> SimpleNamespace:
        """As estimated from the frame."""
        return told(self._seen, self._double.estimate_scale)

    def release(self) -> None:
        """Free its memory."""
        self._released = True

    def __enter__(self) -> Frame:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.release()


class PointCloud:
    """Points and colours on the GPU."""

    def __init__(self, seen: Capture) -> None:
        self._seen = seen

    def copy_data(self, data_format: str) -> NDArray[Any]:
        """A copy as an array. Raises ValueError for a format that does not exist."""
        if data_format not in FORMATS:
            raise ValueError(f'Unsupported data format: {data_format}. Supported formats: '
                             f'{list(FORMATS)}')
        seen = self._seen
        if data_format in ('xyz', 'z'):
            xyz = (seen.cloud * np.float32(1e3)).astype(np.float32)
            return xyz if data_format == 'xyz' else np.ascontiguousarray(xyz[..., 2])
        if data_format == 'snr':
            finite = np.isfinite(seen.cloud).all(axis=2)
            return np.where(finite, 30.0, 0.0).astype(np.float32)
        rgba = np.full((*seen.image.shape[:2], 4), 255, np.uint8)
        rgba[..., :3] = srgb(seen.image) if data_format.endswith('srgb') else seen.image
        return rgba[..., (2, 1, 0, 3)] if data_format.startswith('bgra') else rgba


def linear(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An sRGB image as proportional to the light [IEC 61966-2-1]."""
    share = image / 255.0
    light: Array = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055)**2.4)
    return np.rint(255 * light).astype(np.uint8)


def srgb(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """An image in proportion to the light as sRGB [IEC 61966-2-1]."""
    light = image / 255.0
    share: Array = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light**(1 / 2.4) - 0.055)
    return np.rint(255 * share).astype(np.uint8)


def told(seen: Capture, scale: float) -> SimpleNamespace:
    """Intrinsics as the SDK has them."""
    K = seen.camera.K * scale
    k1, k2, p1, p2, k3 = (*seen.camera.distortion, 0, 0, 0, 0, 0)[:5]
    return SimpleNamespace(
        camera_matrix=SimpleNamespace(fx=K[0, 0], fy=K[1, 1], cx=K[0, 2], cy=K[1, 2]),
        distortion=SimpleNamespace(k1=k1, k2=k2, k3=k3, p1=p1, p2=p2))


def standing(capture: Capture) -> Callable[[float], Capture]:
    """A scene in which nothing moves."""
    return lambda _: replace(capture)
