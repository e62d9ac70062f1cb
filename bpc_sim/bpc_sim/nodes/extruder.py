"""The synthetic extruder."""

from __future__ import annotations

from typing import Any

from bpc_perception.messages import topics
from bpc_perception.runtime.run import run
from bpc_sim.nodes.message_stream import MessageStreamNode
from bpc_sim.printer.messages import extruder_message, EXTRUDER_RATE_HZ


class SyntheticExtruderNode(MessageStreamNode):
    """Publishes ``extrusion_state`` of a simulated print."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('synthetic_extruder', topics.EXTRUSION, EXTRUDER_RATE_HZ,
                         extruder_message, **kwargs)


def main() -> None:
    """Run the node."""
    run(SyntheticExtruderNode, fast_streams=True)


if __name__ == '__main__':
    main()
