"""The camera driver: captures of a back end out, under the topic names of the vendor's node."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event
from typing import Any

from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.capture.region import crop
from bpc_perception.core.config import CameraConfig
from bpc_perception.drivers import Camera, CameraError, prepare_camera, WARN
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages, snr_to_message
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.managed_node import ACTIVE, ManagedNode
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.process import limit_cpu_use
from bpc_perception.runtime.run import run

POLL_PERIOD = 0.02  # how late a recorded capture may come [s]
TURN = 0.5  # how long those who listen to the topics wait for the measurement at most [s]


class CameraDriverNode(ManagedNode):
    """Publishes each capture as image, camera info and cloud; see docs/reference/nodes.

    It holds the camera while inactive, and takes captures while active. With ``hand_over`` a
    capture is given to that first, and published when the event that it returns is set.
    """

    EXPECTED = (*ManagedNode.EXPECTED, CameraError)

    def __init__(self, hand_over: Callable[[Capture], Event] | None = None,
                 **kwargs: Any) -> None:
        super().__init__('camera_driver', **kwargs)
        self._hand_over = hand_over
        self._config = NodeConfig(self, CameraConfig())
        if hand_over is None:  # or else the other node of this process has a say in that
            limit_cpu_use(self._config.value.process, self.get_logger())
        self._open = prepare_camera(self._config.value.back_end, self)
        self._camera: Camera | None = None
        self._outputs = [self.create_publisher(kind, name, topics.CAMERA_QOS)
                         for name, kind in topics.CAMERA.items()]
        self._snr = self.create_publisher(Image, topics.SNR, topics.CAMERA_QOS)
        self.create_service(Trigger, 'capture', self._on_request)
        self._timer = self.create_timer(POLL_PERIOD, self._poll, clock=steady_clock())
        self._timer.cancel()
        if self._config.value.autostart:
            self.start()

    def configure(self) -> None:
        """Open the camera."""
        self._camera = self._open()
        try:
            self._camera.connect()
        except CameraError as error:
            if not self._config.value.autostart:
                self.clean_up()
                raise
            self._diagnostics.warn(str(error))  # as there is nobody else it tries again itself
        self._describe(self._camera)

    def activate(self) -> None:
        """Let captures out."""
        self._last_ns = self._now_ns()
        self._timer.reset()

    def deactivate(self) -> None:
        """Take no more captures."""
        self._timer.cancel()

    def clean_up(self) -> None:
        """Let go of the camera."""
        self._timer.cancel()
        camera, self._camera = self._camera, None
        if camera is not None:
            camera.close()

    def _poll(self) -> None:
        camera = self._camera
        # As with the vendor's node, what nobody listens to is not taken.
        if camera is None or (self._hand_over is None and not all(
                output.get_subscription_count() for output in self._outputs)):
            return
        now_ns, rate = self._now_ns(), self._config.value.rate
        if now_ns < self._last_ns:  # the clock went back
            self._last_ns = now_ns
        period_ns = round(1e9 / rate) if rate > 0 else 0
        if period_ns and now_ns - self._last_ns >= period_ns:
            # In step, however late this is, unless that is by more than a period.
            self._last_ns = max(self._last_ns + period_ns, now_ns - period_ns)
            self._capture(camera, now_ns)
        elif camera.due(now_ns):
            self._capture(camera, now_ns)

    def _capture(self, camera: Camera, now_ns: int) -> str:
        """Take and publish a capture; why not, or an empty string."""
        try:
            capture = crop(camera.capture(now_ns), self._config.value.region)
        except (CameraError, ValueError) as error:
            self._diagnostics.refuse(error)
            return str(error)
        finally:
            self._describe(camera)
        self._diagnostics.count('captures')
        if self._hand_over is not None:
            self._hand_over(capture).wait(TURN if self._listened() else 0)
        if self._listened():
            for output, message in zip(self._outputs, capture_to_messages(capture), strict=True):
                if output.get_subscription_count():
                    output.publish(message)
        if capture.snr is not None and self._snr.get_subscription_count():
            self._snr.publish(snr_to_message(capture))
        return ''

    def _listened(self) -> bool:
        return any(output.get_subscription_count() for output in self._outputs)

    def _describe(self, camera: Camera) -> None:
        for key, value in camera.notes().items():
            if key == WARN:
                self._diagnostics.warn(str(value))
            else:
                self._diagnostics.note(key, value)

    def _on_request(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._camera is None or self.state != ACTIVE:
            response.message = ('capture: expected the camera driver to be active, found it '
                                f'{self.state}')
            self._diagnostics.refuse(response.message)
        else:
            response.message = self._capture(self._camera, self._now_ns())
        response.success = not response.message
        return response

    def _now_ns(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def main() -> None:
    """Run the node."""
    run(CameraDriverNode, large_messages=True)


if __name__ == '__main__':
    main()
