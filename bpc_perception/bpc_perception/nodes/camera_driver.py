"""The camera driver: publishes the captures of a back end on the topics of the vendor's node."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event
from typing import Any

from sensor_msgs.msg import Image
from std_srvs.srv import Trigger

from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.capture.region import crop
from bpc_perception.core.config import CameraConfig
from bpc_perception.drivers.cameras import Camera, CameraError, prepare_camera, WARN
from bpc_perception.messages import topics
from bpc_perception.messages.capture import capture_to_messages, snr_to_message
from bpc_perception.runtime.clock import steady_clock
from bpc_perception.runtime.diagnostics import in_words
from bpc_perception.runtime.managed_node import ACTIVE, ManagedNode
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.process import limit_cpu_use
from bpc_perception.runtime.run import run

POLL_PERIOD_S = 0.02  # a recorded capture may come this much late
LONGEST_TURN_S = 0.5  # subscribers of the topics wait for the measurement no longer


class CameraDriverNode(ManagedNode):
    """Publishes each capture as image, camera info and cloud; see docs/reference/nodes.

    The node holds the camera while inactive, and takes captures while active. A capture is first
    given to ``hand_over``, if there is one, and published when the event that it returns is set.
    """

    EXPECTED = (*ManagedNode.EXPECTED, CameraError)

    def __init__(self, hand_over: Callable[[Capture], Event] | None = None,
                 **kwargs: Any) -> None:
        super().__init__('camera_driver', **kwargs)
        self._hand_over = hand_over
        self._config = NodeConfig(self, CameraConfig())
        if hand_over is None:  # otherwise the other node of this process does that
            limit_cpu_use(self._config.value.process, self.get_logger())
        self._open = prepare_camera(self._config.value.back_end, self)
        self._camera: Camera | None = None
        self._outputs = [self.create_publisher(kind, name, topics.CAMERA_QOS)
                         for name, kind in topics.CAMERA.items()]
        self._snr = self.create_publisher(Image, topics.SNR, topics.CAMERA_QOS)
        self.create_service(Trigger, 'capture', self._on_request)
        self._timer = self.create_timer(POLL_PERIOD_S, self._poll, clock=steady_clock())
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
            self._diagnostics.warn(str(error))  # no manager tries again, so the node does
        self._describe(self._camera)

    def activate(self) -> None:
        """Take captures from now on."""
        self._last_ns = self._now_ns()
        self._timer.reset()

    def deactivate(self) -> None:
        """Take no more captures."""
        self._timer.cancel()

    def clean_up(self) -> None:
        """Close the camera."""
        self._timer.cancel()
        camera, self._camera = self._camera, None
        if camera is not None:
            camera.close()

    def _poll(self) -> None:
        if self._camera is None or not self._has_audience():
            return
        now_ns = self._now_ns()
        if self._is_time(now_ns) or self._camera.due(now_ns):
            self._capture(self._camera, now_ns)

    def _has_audience(self) -> bool:
        """Return whether someone takes captures: if not, none are made, as by the vendor."""
        return self._hand_over is not None or all(
            output.get_subscription_count() for output in self._outputs)

    def _is_time(self, now_ns: int) -> bool:
        """Return whether the next capture of a set rate is due, and note it as taken."""
        if now_ns < self._last_ns:  # the clock went back
            self._last_ns = now_ns
        rate = self._config.value.rate
        period_ns = round(1e9 / rate) if rate > 0 else 0
        if not period_ns or now_ns - self._last_ns < period_ns:
            return False
        # Keep in step when this call is late, but not by more than a period.
        self._last_ns = max(self._last_ns + period_ns, now_ns - period_ns)
        return True

    def _capture(self, camera: Camera, now_ns: int) -> str:
        """Take and publish a capture; return why not, or an empty string."""
        try:
            capture = crop(camera.capture(now_ns), self._config.value.region)
        except (CameraError, ValueError, MemoryError) as error:
            self._diagnostics.refuse(in_words(error))
            return in_words(error)
        finally:
            self._describe(camera)
        self._diagnostics.count('captures')
        if self._hand_over is not None:
            self._hand_over(capture).wait(LONGEST_TURN_S if self._has_subscribers() else 0)
        self._publish(capture)
        return ''

    def _publish(self, capture: Capture) -> None:
        if self._has_subscribers():
            for output, message in zip(self._outputs, capture_to_messages(capture), strict=True):
                if output.get_subscription_count():
                    output.publish(message)
        if capture.snr is not None and self._snr.get_subscription_count():
            self._snr.publish(snr_to_message(capture))

    def _has_subscribers(self) -> bool:
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
