"""Camera driver and thickness node in one process, where a capture is handed over uncopied.

Between processes a full frame is copied six times on its way, which takes 40 ms in all.
"""

from __future__ import annotations

from rclpy.node import Node

from bpc_perception.nodes.camera_driver import CameraDriverNode
from bpc_perception.nodes.thickness import ThicknessNode
from bpc_perception.runtime.run import run


def composed() -> tuple[Node, Node]:
    """Make both nodes, with their own names and parameters."""
    thickness = ThicknessNode(camera_topics=False)
    return thickness, CameraDriverNode(thickness.hand_over)


def main() -> None:
    """Run the nodes."""
    run(composed, large_messages=True)


if __name__ == '__main__':
    main()
