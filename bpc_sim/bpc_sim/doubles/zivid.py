"""A stand-in for the vendor's Python package ``zivid``, as far as a camera back end uses it.

Shapes, units, types, errors and the order of events are those of zivid-python 2.17:

- The cloud is in millimetres, float32 with NaN.
- A colour has four bytes and is linear, unless sRGB is asked for.
- Whatever happens to the camera raises RuntimeError.
- Capture calls block while the camera projects, and frames block until they are processed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime, timedelta, timezone
from functools import cache, partial
import time
from types import ModuleType, SimpleNamespace, TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.capture.capture import Capture
from bpc_sim.doubles.srgb import linear_to_srgb
from bpc_sim.doubles.zivid_settings import Settings, Settings2D

DATA_FORMATS = ('xyz', 'z', 'rgba', 'bgra', 'rgba_srgb', 'bgra_srgb', 'snr')


@dataclass
class ZividDouble:
    """A camera that may be unplugged, and the package through which it is reached.

    Attributes:
        see: what is in front of the camera at a time of time.time() [s], in metres, with colours
            in proportion to the light.
        acquisition, processing: how long it projects, and how long it computes afterwards [s].
        plugged: whether it is connected to the computer.
        fails_while_processing: whether the next frame ends with an error.
        intrinsics_scale: scale of the reported intrinsics, as if of another resolution.
        estimate_scale: scale of the intrinsics estimated from a frame.
        throttling: how long a capture waits before it begins [s].
        connections: how often the camera was connected.
        application: the present application; a process may have one at a time.
        serial_number: serial number of the camera.
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
        """Tell whether the camera is connected to the computer."""
        return self.plugged

    def modules(self) -> dict[str, ModuleType]:
        """Return the modules of the package by their names."""
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
        """Connect a camera. Raises RuntimeError if there is none with this serial number."""
        if self._released:
            raise RuntimeError('The application is released')
        if not self._double.is_plugged():
            raise RuntimeError('No Zivid cameras are connected')
        if serial_number not in (None, self._double.serial_number):
            raise RuntimeError(f'Camera with serial number {serial_number} not found')
        self._double.connections += 1
        return Camera(self._double)

    def release(self) -> None:
        """Release the SDK."""
        self._released = True
        self._double.application = None


class Camera:
    """A connected camera."""

    def __init__(self, double: ZividDouble) -> None:
        self._double = double
        self._connected = True
        self._seen: Callable[[], Capture] | None = None

    @property
    def info(self) -> SimpleNamespace:
        """Model, firmware and serial number."""
        return SimpleNamespace(model_name='Zivid 2 M70', firmware_version='1.2.3',
                               serial_number=self._double.serial_number)

    @property
    def state(self) -> SimpleNamespace:
        """Temperatures of the camera. Raises RuntimeError if it is unplugged."""
        self._check()
        return SimpleNamespace(temperature=SimpleNamespace(
            dmd=41.5, general=38.25, led=44.0, lens=36.5, pcb=46.0))

    def capture_2d_3d(self, settings: Settings) -> Frame:
        """Project and take images; return when that is done."""
        if not isinstance(settings, Settings):
            raise TypeError(f'Unsupported type for argument settings. Got {type(settings)}, '
                            'expected Settings.')
        if settings.color is None:
            raise RuntimeError('Settings.color must be set for a 2D+3D capture')
        self._check()
        time.sleep(self._double.throttling)
        time.sleep(self._double.acquisition)
        self._check()
        # If nothing moves, the middle of the acquisition is as good as any other time.
        middle = time.time() - self._double.acquisition / 2
        # It is drawn when asked for: the call returns when the acquisition ends, as a camera's.
        self._seen = cache(partial(self._double.see, middle))
        return Frame(self._double, self._seen)

    def intrinsics(self, settings: Settings | None) -> SimpleNamespace:
        """Return the intrinsics for the resolution of the settings."""
        del settings
        self._check()
        seen = self._seen() if self._seen else self._double.see(time.time())
        return sdk_intrinsics(seen, self._double.intrinsics_scale)

    def disconnect(self) -> None:
        """Disconnect the camera."""
        self._connected = False

    def _check(self) -> None:
        """Raise RuntimeError unless the camera is connected."""
        if not (self._connected and self._double.is_plugged()):
            raise RuntimeError('Camera is not connected')


class Frame:
    """The result of a capture; a context manager that releases it."""

    def __init__(self, double: ZividDouble, seen: Callable[[], Capture]) -> None:
        self._double = double
        self._seen = seen
        self._ready = time.monotonic() + double.processing
        self._released = False

    @property
    def info(self) -> SimpleNamespace:
        """When and how the frame was taken; the time stamp has whole seconds only."""
        return SimpleNamespace(
            time_stamp=datetime.now(timezone.utc).replace(microsecond=0),
            metrics=SimpleNamespace(
                acquisition_time=timedelta(seconds=self._double.acquisition),
                capture_time=timedelta(
                    seconds=self._double.acquisition + self._double.processing),
                throttling_time=timedelta(seconds=self._double.throttling)))

    def point_cloud(self) -> PointCloud:
        """Wait for the processing, and return the cloud."""
        if self._released:
            raise RuntimeError('The frame is released')
        time.sleep(max(self._ready - time.monotonic(), 0))
        if self._double.fails_while_processing:
            self._double.fails_while_processing = False
            raise RuntimeError('Error while processing the capture')
        return PointCloud(self._seen())

    def intrinsics(self) -> SimpleNamespace:
        """Return the intrinsics as estimated from the frame."""
        return sdk_intrinsics(self._seen(), self._double.estimate_scale)

    def release(self) -> None:
        """Release the memory."""
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
        """Return a copy as an array. Raises ValueError for a format that does not exist."""
        if data_format not in DATA_FORMATS:
            raise ValueError(f'Unsupported data format: {data_format}. Supported formats: '
                             f'{list(DATA_FORMATS)}')
        seen = self._seen
        if data_format in ('xyz', 'z'):
            xyz = (seen.cloud * np.float32(1e3)).astype(np.float32)
            return xyz if data_format == 'xyz' else np.ascontiguousarray(xyz[..., 2])
        if data_format == 'snr':
            finite = np.isfinite(seen.cloud).all(axis=2)
            return np.where(finite, 30.0, 0.0).astype(np.float32)
        rgba = np.full((*seen.image.shape[:2], 4), 255, np.uint8)
        rgba[..., :3] = linear_to_srgb(seen.image) if data_format.endswith('srgb') else seen.image
        return rgba[..., (2, 1, 0, 3)] if data_format.startswith('bgra') else rgba


def sdk_intrinsics(seen: Capture, scale: float) -> SimpleNamespace:
    """Return the intrinsics of a capture, scaled, in the form of the SDK."""
    K = seen.camera.K * scale
    k1, k2, p1, p2, k3 = (*seen.camera.distortion, 0, 0, 0, 0, 0)[:5]
    return SimpleNamespace(
        camera_matrix=SimpleNamespace(fx=K[0, 0], fy=K[1, 1], cx=K[0, 2], cy=K[1, 2]),
        distortion=SimpleNamespace(k1=k1, k2=k2, k3=k3, p1=p1, p2=p2))


def still_scene(capture: Capture) -> Callable[[float], Capture]:
    """Return a scene in which nothing moves."""
    return lambda _: replace(capture)
