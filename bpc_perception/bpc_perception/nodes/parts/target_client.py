"""Ask the thickness node for its target, which its parameters hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.srv import GetParameters
from rclpy.node import Node

from bpc_perception.core.targets import WidthTargets
from bpc_perception.page.board import TargetBand

PARAMETER_NAMES = ['advice.target_thickness', 'advice.target_file', 'advice.dead_band']


class TargetClient:
    """Asks the thickness node for the target and the dead band around it.

    Args:
        node: the node that asks.
        on_target: gets the answer; None = no target is set.
        on_refusal: gets the reason why a target file cannot be read.
    """

    def __init__(self, node: Node, on_target: Callable[[TargetBand | None], None],
                 on_refusal: Callable[[str], None]) -> None:
        self._on_target = on_target
        self._on_refusal = on_refusal
        self._client = node.create_client(GetParameters, 'thickness/get_parameters')

    def ask(self) -> None:
        """Ask, if there is a thickness node."""
        if self._client.service_is_ready():
            self._client.call_async(
                GetParameters.Request(names=PARAMETER_NAMES)).add_done_callback(self._answered)

    def _answered(self, future: Any) -> None:
        values = future.result().values
        if len(values) != len(PARAMETER_NAMES):
            return  # another node of that name
        thickness, file, dead_band = values
        try:
            targets = (WidthTargets.read(file.string_value) if file.string_value
                       else WidthTargets.constant(thickness.double_value))
        except (OSError, ValueError) as error:
            self._on_refusal(str(error))
            return
        wanted = bool((targets.thickness > 0).all())
        self._on_target(TargetBand(targets, dead_band.double_value) if wanted else None)
