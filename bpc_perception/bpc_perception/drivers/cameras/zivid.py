"""Camera back end for a Zivid camera, through the vendor's Python package.

The package needs the vendor's SDK, so it is imported only here. Names and behaviour are those of
zivid-python 2.17; see docs/limits.md for what has been tried.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
import time
from typing import Any

import numpy as np
from rclpy.node import Node

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import Capture, PinholeCamera, pixel_deviation
from bpc_perception.core.config import ZividConfig
from bpc_perception.core.watch.back_off import BackOff
from bpc_perception.drivers.cameras import CameraError, WARN
from bpc_perception.runtime.parameters import NodeConfig

MILLIMETRE_M = np.float32(1e-3)  # the unit of the SDK
# With the right intrinsics, points of the cloud are seen this close to their own pixels.
LARGEST_DEVIATION_PX = 1.0
THROTTLING_TIME_S = 0.01  # a camera that waits longer to cool down is worth a warning


class ZividCamera:
    """A camera that is connected when it is needed, and reconnected after it was gone."""

    def __init__(self, zivid: Any, config: ZividConfig, clock_ns: Callable[[], int]) -> None:
        """Start the SDK and load the settings. Raises ValueError when that fails."""
        self._zivid = zivid
        self._config = config
        self._clock_ns = clock_ns
        self._colours = 'rgba_srgb' if config.color_space == 'srgb' else 'rgba'
        self._notes: dict[str, object] = {}
        self._back_off = BackOff(0.5, 10.0)
        self._camera: Any = None
        try:
            self._application = zivid.Application()  # a process may have one at a time
        except RuntimeError as error:
            raise ValueError(f'zivid: expected its SDK to start, found: {error}'
                             '; look at its installation') from error
        try:
            self._settings = self._load_settings()
        except ValueError:
            self.close()
            raise

    def connect(self) -> None:
        """Connect the camera, if it is not connected. Raises CameraError when it is not found."""
        if self._camera is None:
            self._connect()

    def due(self, now_ns: int) -> bool:
        """Look for a camera that is gone; return False, since captures are requested."""
        del now_ns
        if self._camera is None and not self._back_off.waiting(time.monotonic()):
            try:
                self._connect()
            except CameraError as error:
                self._notes[WARN] = error
        return False

    def capture(self, now_ns: int) -> Capture:
        """Take a capture, stamped with the middle of its acquisition."""
        del now_ns
        if self._camera is None:
            wait = self._back_off.waiting(time.monotonic())
            if wait:
                raise CameraError(f'zivid: expected a camera, found none; looked for again in '
                                  f'{wait:.1f} s; look at its cable and power')
            self._connect()
        try:
            before_ns = self._clock_ns()
            with self._camera.capture_2d_3d(self._settings) as frame:
                after_ns = self._clock_ns()
                metrics = frame.info.metrics
                cloud = frame.point_cloud()  # waits, and raises what went wrong until then
                xyz = cloud.copy_data('xyz') * MILLIMETRE_M
                image = np.ascontiguousarray(cloud.copy_data(self._colours)[..., :3])
                snr = cloud.copy_data('snr')
                camera = self._find_intrinsics(frame, xyz)
            self._describe(metrics)
        except CameraError:  # the camera is there, but the capture cannot be used
            raise
        except RuntimeError as error:  # the SDK raises it for everything
            self._drop()
            raise CameraError(f'zivid: expected a capture, found: {error}'
                              '; it is tried again with the next') from error
        # The call returns when the acquisition ends [zivid-python, Camera.capture_2d_3d].
        lasted_ns = round(metrics.acquisition_time.total_seconds() * 1e9)
        stamp_ns = max(after_ns - lasted_ns // 2, before_ns)
        return Capture(stamp_ns, self._config.frame_id, image, xyz, camera, snr)

    def notes(self) -> Mapping[str, object]:
        """Return what is new of model, serial number, temperatures and throttling."""
        notes, self._notes = self._notes, {}
        return notes

    def close(self) -> None:
        """Disconnect the camera."""
        if self._camera is not None:
            self._drop()
        if self._application is not None:
            self._application.release()
            self._application = None

    def _load_settings(self) -> Any:
        file = self._config.settings_file
        if not file:
            settings_3d, settings_2d = self._zivid.Settings, self._zivid.Settings2D
            colour = settings_2d(acquisitions=[settings_2d.Acquisition()])
            return settings_3d(acquisitions=[settings_3d.Acquisition()], color=colour)
        try:
            settings = self._zivid.Settings.load(file)
        except RuntimeError as error:
            raise ValueError(f'settings_file: expected capture settings of Zivid, '
                             f'found {file}: {error}; save them anew in Zivid Studio') from error
        if settings.color is None:
            raise ValueError(f'settings_file: expected settings of the colour image as well, '
                             f'found none in {file}; add them in Zivid Studio')
        return settings

    def _connect(self) -> None:
        try:
            serial_number = self._config.serial_number
            self._camera = self._application.connect_camera(
                **({'serial_number': serial_number} if serial_number else {}))
            info = self._camera.info
        except RuntimeError as error:
            self._camera = None
            self._back_off.failed(time.monotonic())
            raise CameraError(f'zivid: expected to connect a camera, found: {error}'
                              '; end other programs that use it') from error
        self._back_off.succeeded()
        self._notes |= {'model': info.model_name, 'serial number': info.serial_number,
                        'firmware': info.firmware_version}

    def _drop(self) -> None:
        camera, self._camera = self._camera, None
        self._back_off.failed(time.monotonic())
        try:
            camera.disconnect()
        except RuntimeError as error:
            self._notes['disconnected'] = error

    def _describe(self, metrics: Any) -> None:
        temperature = self._camera.state.temperature
        throttled = metrics.throttling_time.total_seconds()
        self._notes |= {
            'temperature, general [degrees C]': f'{temperature.general:.1f}',
            'temperature, lens [degrees C]': f'{temperature.lens:.1f}',
            'acquisition time [s]': f'{metrics.acquisition_time.total_seconds():.3f}',
            'capture time [s]': f'{metrics.capture_time.total_seconds():.3f}',
            'throttling time [s]': f'{throttled:.3f}'}
        if throttled > THROTTLING_TIME_S:
            self._notes[WARN] = (f'zivid: expected to capture at once, found that the camera '
                                 f'waited for {throttled:.2f} s to cool down; capture less often')

    def _find_intrinsics(self, frame: Any, xyz: Array) -> PinholeCamera:
        """Return the intrinsics that put the cloud (H, W, 3) [m] onto its own pixels.

        The intrinsics of the camera may belong to another resolution (zivid-ros, pull request
        154). So they are checked, and if they do not fit they are estimated from the capture.
        """
        calibration = import_module('zivid.experimental.calibration')
        height, width = xyz.shape[:2]
        tried = []
        if self._config.intrinsics == 'camera':
            tried.append(lambda: calibration.intrinsics(self._camera, self._settings))
        tried.append(lambda: calibration.estimate_intrinsics(frame))
        for attempt in tried:
            camera = _pinhole(attempt(), width, height)
            deviation = pixel_deviation(xyz, camera)
            if not deviation > LARGEST_DEVIATION_PX:
                return camera
        raise CameraError('zivid: expected intrinsics that put the cloud onto its pixels, found '
                          f'it {deviation:.1f} pixels beside them'
                          '; do settings and camera belong together?')


def _pinhole(intrinsics: Any, width: int, height: int) -> PinholeCamera:
    matrix, lens = intrinsics.camera_matrix, intrinsics.distortion
    K = np.array(((matrix.fx, 0, matrix.cx), (0, matrix.fy, matrix.cy), (0, 0, 1.0)))
    return PinholeCamera(K, np.array((lens.k1, lens.k2, lens.p1, lens.p2, lens.k3)),
                         width, height)


def prepare(node: Node) -> Callable[[], ZividCamera]:
    """Return a function that opens the camera that the node's parameters name.

    Raises ValueError when the vendor's package is not installed.
    """
    try:
        zivid = import_module('zivid')
    except ImportError as error:
        raise ValueError('back_end: expected the package zivid and the SDK of the same version '
                         f'to be installed, found: {error}; install both') from error
    config = NodeConfig(node, ZividConfig()).value
    return lambda: ZividCamera(zivid, config, lambda: int(node.get_clock().now().nanoseconds))
