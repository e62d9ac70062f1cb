"""The path recorder: flange poses and extruder states in, the print's path out."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any

from nav_msgs.msg import Path
import numpy as np
from rclpy.node import Node
from std_srvs.srv import Trigger

from bpc_interfaces.msg import DepositionPath, DepositionPathUpdate, ExtrusionState
from bpc_perception import topics
from bpc_perception.bag import BagWriter
from bpc_perception.conversions import (
    extruder_from_message,
    path_to_message,
    path_to_nav,
)
from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.geometry import Array, transform
from bpc_perception.core.path_assembly import PrintTracker
from bpc_perception.nodes.allowance import Allowance
from bpc_perception.nodes.clock import on_jump_back, steady_clock
from bpc_perception.nodes.diagnostics import Diagnostics
from bpc_perception.nodes.parameters import NodeConfig
from bpc_perception.nodes.pose_source import subscribe_poses
from bpc_perception.nodes.process import be_a_good_neighbour
from bpc_perception.nodes.run import run
from bpc_perception.nodes.silence import Silence

State = tuple[str, float, bool]  # of a path: print, complete until, finished
PATH_SHARE = 0.05  # of the time that sending the whole path may take, however long it is


class PathRecorderNode(Node):
    """Assembles the path of each print; see the README for its interface."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('path_recorder', **kwargs)
        config = NodeConfig(self, RecorderConfig()).value
        self._config = config
        be_a_good_neighbour(config.process, self.get_logger())
        self._tip = np.array(config.nozzle_offset)
        self._tracker = PrintTracker(config.path)
        self._diagnostics = Diagnostics(self)
        self._silences = {name: Silence(name, self._diagnostics)
                          for name in ('robot', 'extruder')}
        # The state of the path when the update, the whole, and that for viewers were published.
        self._updated: State | None = None
        self._published: State | None = None
        self._viewed: State | None = None
        self._points_sent = 0
        self._whole, self._view = Allowance(PATH_SHARE), Allowance(PATH_SHARE)
        self._updates = self.create_publisher(
            DepositionPathUpdate, topics.PATH_UPDATE, topics.PATH_UPDATE_QOS)
        self._paths = self.create_publisher(DepositionPath, topics.PATH, topics.PATH_QOS)
        self._nav_paths = self.create_publisher(Path, topics.NAV_PATH, topics.PATH_QOS)
        subscribe_poses(self, config.pose, config.base_frame, self._diagnostics, self._on_pose)
        self.create_subscription(ExtrusionState, topics.EXTRUSION, self._on_extruder,
                                 topics.EXTRUSION_QOS)
        for name, answer in (('start', self._start), ('stop', self._stop),
                             ('clear', self._clear), ('save', self._save)):
            self.create_service(Trigger, f'~/{name}', answer)
        self.create_timer(1.0 / config.publish_rate, self._publish, clock=steady_clock())
        self._jump = on_jump_back(self, self._tracker.clear)

    def _on_pose(self, stamp_ns: int, T_base_flange: Array) -> None:
        self._silences['robot'].broken()
        if self._tracker.add_pose(stamp_ns, transform(T_base_flange, self._tip)):
            self._diagnostics.count('poses')
        else:
            self._diagnostics.refuse('pose: expected a later stamp than the last, found it late')

    def _on_extruder(self, message: ExtrusionState) -> None:
        self._silences['extruder'].broken()
        if self._tracker.add_extruder(extruder_from_message(message)):
            self._diagnostics.count('extrusion states')
        else:
            self._diagnostics.refuse(
                'extrusion_state: expected a later stamp than the last, found it late')

    def _publish(self) -> None:
        for silence in self._silences.values():
            silence.check()
        growing = self._tracker.growing_path()
        if growing is None:
            return
        state = (growing.print_id, growing.complete_until, growing.finished)
        new_print = self._updated is None or self._updated[0] != growing.print_id
        if state != self._updated:
            first = 0 if new_print else self._points_sent
            self._updated, self._points_sent = state, len(growing)
            self._updates.publish(DepositionPathUpdate(
                first=first, path=path_to_message(growing.path(first), self._config.base_frame)))
        if state != self._published and (new_print or self._whole.due()):
            self._published = state
            with self._whole.spent():
                self._paths.publish(path_to_message(growing.path(), self._config.base_frame))
        if (state != self._viewed and self._nav_paths.get_subscription_count()
                and self._view.due()):
            self._viewed = state
            with self._view.spent():
                self._nav_paths.publish(path_to_nav(growing.path(), self._config.base_frame))

    def _start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._tracker.start(self.get_clock().now().nanoseconds)
        response.success = True
        return response

    def _stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._tracker.stop(self.get_clock().now().nanoseconds)
        response.message = 'stopped' if response.success else 'no print runs'
        return response

    def _clear(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._tracker.clear()
        response.success, response.message = True, 'cleared'
        return response

    def _save(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        path = self._tracker.path()
        if path is None:
            response.message = 'expected a print, found none started'
            return response
        target = FilePath(self._config.output_folder) / path.print_id
        try:
            with BagWriter(target) as bag:
                bag.add_topic(f'/{topics.PATH}', topics.type_name(DepositionPath))
                bag.write(f'/{topics.PATH}', self.get_clock().now().nanoseconds,
                          path_to_message(path, self._config.base_frame))
        except (OSError, ValueError) as error:
            response.message = str(error)
            return response
        response.success, response.message = True, str(target)
        return response


def main() -> None:
    """Run the node."""
    run(PathRecorderNode, fast_streams=True)


if __name__ == '__main__':
    main()
