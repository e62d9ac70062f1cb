"""The path recorder: takes flange poses and extruder states, publishes the path of the print."""

from __future__ import annotations

from typing import Any

import numpy as np
from rclpy.node import Node
from std_srvs.srv import Trigger

from bpc_interfaces.msg import DepositionPath, ExtrusionState
from bpc_perception.core.arrays import Array
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.geometry import transform
from bpc_perception.core.path.leaps import LEAPT
from bpc_perception.core.path.tracker import JumpError, PrintTracker
from bpc_perception.core.watch.clocks import ADVICE, SteadyClocks
from bpc_perception.messages import topics
from bpc_perception.messages.extruder import extruder_from_message
from bpc_perception.messages.path import path_to_message
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.nodes.parts.path_publisher import PathPublisher
from bpc_perception.nodes.parts.pose_source import subscribe_poses
from bpc_perception.nodes.parts.print_journal import PrintJournal
from bpc_perception.nodes.parts.single_source import subscribe_single_source
from bpc_perception.recording.atomic import atomic_bag, inside
from bpc_perception.runtime.clock import expect_not_ahead, on_jump_back, steady_clock
from bpc_perception.runtime.diagnostics import Diagnostics
from bpc_perception.runtime.parameters import NodeConfig
from bpc_perception.runtime.process import limit_cpu_use
from bpc_perception.runtime.run import run


class PathRecorderNode(Node):
    """Assembles the path of each print; see docs/reference/nodes."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('path_recorder', **kwargs)
        config = NodeConfig(self, RecorderConfig()).value
        self._config = config
        limit_cpu_use(config.process, self.get_logger())
        self._tip = np.array(config.nozzle_offset)
        self._tracker = PrintTracker(config.path)
        self._diagnostics = Diagnostics(self, watch=config.watch)
        self._diagnostics.expect(topics.EXTRUSION)
        self._clocks = SteadyClocks()
        self._publisher = PathPublisher(self, config.base_frame)
        self._journal = PrintJournal(config, self._diagnostics)
        self._resume()
        subscribe_poses(self, config.pose, config.base_frame, config.watch.maximum_lead,
                        self._diagnostics, self._on_pose)
        subscribe_single_source(self, ExtrusionState, topics.EXTRUSION, self._on_extruder,
                                topics.EXTRUSION_QOS, self._diagnostics)
        for name, answer in (('start', self._start), ('stop', self._stop),
                             ('clear', self._clear), ('save', self._save)):
            self.create_service(Trigger, f'~/{name}', answer)
        self.create_timer(1.0 / config.publish_rate, self._publish, clock=steady_clock())
        self._jump = on_jump_back(self, self._forget)

    def _on_pose(self, stamp_ns: int, T_base_flange: Array) -> None:
        leaps = self._tracker.leaps
        try:
            self._expect_one_clock('pose', stamp_ns)
            taken = self._tracker.add_pose(stamp_ns, transform(T_base_flange, self._tip))
        except (JumpError, ConversionError) as error:
            self._diagnostics.refuse(error)
            return
        if self._tracker.leaps > leaps:
            self._diagnostics.warn(LEAPT)
        if taken:
            self._diagnostics.count('poses')
        else:
            self._diagnostics.refuse('pose: expected a later stamp than the last, found it late'
                                     '; let one robot alone publish, with its own stamps')

    def _expect_one_clock(self, name: str, stamp_ns: int) -> None:
        """Raise ConversionError where robot or extruder goes by a clock behind the other's."""
        behind = self._clocks.behind(name, self.get_clock().now().nanoseconds, stamp_ns)
        if behind:
            raise ConversionError(
                f'{name}: expected stamps by the clock of the other source, found them '
                f'{behind:.1f} s behind; {ADVICE}')

    def _on_extruder(self, message: ExtrusionState) -> None:
        self._diagnostics.heard(topics.EXTRUSION)
        try:
            sample = extruder_from_message(message)
            expect_not_ahead(self, 'extrusion_state', sample.stamp_ns,
                             self._config.watch.maximum_lead)
            self._expect_one_clock('extrusion_state', sample.stamp_ns)
        except ConversionError as error:
            self._diagnostics.refuse(error)
            return
        if message.error_status:
            self._diagnostics.warn('extrusion_state: expected no error, found error_status '
                                   f'{message.error_status}; clear it at the extruder')
        if self._tracker.add_extruder(sample):
            self._diagnostics.count('extrusion states')
        else:
            self._diagnostics.refuse(
                'extrusion_state: expected a later stamp than the last, found it late'
                '; let one extruder alone publish, with its own stamps')

    def _resume(self) -> None:
        """Go on with the print before, as a rule one that ran when the node was killed."""
        now_ns = self.get_clock().now().nanoseconds
        path = self._journal.resume(now_ns)
        if path is not None:
            self._tracker.resume(path, now_ns)
            self._diagnostics.warn(f'print: {path.print_id} is resumed, without what was laid '
                                   'meanwhile')

    def _publish(self) -> None:
        growing = self._tracker.growing_path()
        if growing is not None:
            self._journal.keep(growing, self.get_clock().now().nanoseconds)
            self._publisher.publish(growing)

    def _forget(self) -> None:
        self._clocks = SteadyClocks()
        self._tracker.clear()
        self._journal.forget()
        self._publisher.clear(self.get_clock().now().nanoseconds)

    def _start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._tracker.start(self.get_clock().now().nanoseconds)
        response.success = True
        return response

    def _stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._tracker.stop(self.get_clock().now().nanoseconds)
        response.message = 'stopped' if response.success else 'no print runs'
        return response

    def _clear(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._forget()
        response.success, response.message = True, 'cleared'
        return response

    def _save(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        path = self._tracker.path()
        if path is None:
            response.message = 'expected a print, found none started; push ink out, or start one'
            return response
        try:
            target = inside(self._config.output_folder, path.print_id)
            with atomic_bag(target) as bag:
                bag.add_topic(f'/{topics.PATH}', topics.type_name(DepositionPath))
                bag.write(f'/{topics.PATH}', self.get_clock().now().nanoseconds,
                          path_to_message(path, self._config.base_frame))
        except (OSError, ValueError) as error:
            response.message = str(error)
            return response
        response.success, response.message = True, str(target.absolute())
        return response

    def end_print(self) -> None:
        """End the running print, since someone ends this node on purpose."""
        path = self._tracker.end()
        if path is not None:
            self._journal.keep(path, self.get_clock().now().nanoseconds)
            self._publisher.publish(path)

    def destroy_node(self) -> None:
        """Close the journal as well."""
        self._journal.close()
        super().destroy_node()


def main() -> None:
    """Run the node."""
    run(PathRecorderNode, fast_streams=True, on_purpose=PathRecorderNode.end_print)


if __name__ == '__main__':
    main()
