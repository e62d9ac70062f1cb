"""``bpc live``: the nodes on a real printer's topics."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from bpc_perception import topics
from bpc_perception.cli.monitor import monitoring
from bpc_perception.cli.options import RemapOption, remappings
from bpc_perception.cli.processes import Nodes
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.flange_poses import FlangePoses
from bpc_perception.handeye import load_hand_eye
from bpc_perception.parameter_files import configure, live_recorder

PATIENCE = 5.0  # until topics that are still silent are named [s]


def live(
    hand_eye: Annotated[Path, typer.Option(
        '--handeye', metavar='FILE', help='Hand-eye calibration.')],
    parameters: Annotated[Path | None, typer.Option(
        '--params', metavar='FILE',
        help='ROS parameter file for the nodes; it has to say the nozzle_offset.')] = None,
    remap: RemapOption = None,
) -> None:
    """Measure a running print until Ctrl-C.

    Camera, robot and extruder publish by themselves.
    """
    load_hand_eye(hand_eye)
    configure(ThicknessConfig(), 'thickness', parameters)
    recorder = live_recorder(parameters)
    others = remappings(remap)
    pose_topic = FlangePoses(recorder.pose, recorder.base_frame).topic
    with monitoring() as monitor, Nodes(parameters, remappings=others) as nodes:
        nodes.start('bpc_perception.nodes.path_recorder')
        nodes.start('bpc_perception.nodes.thickness', hand_eye_file=str(hand_eye))
        print('Waiting for captures; Ctrl-C ends.')

        def ended() -> bool:
            nodes.check()
            return False

        monitor.spin_until(ended, PATIENCE)
        for name in (*topics.CAMERA, pose_topic, topics.EXTRUSION):
            topic = others.get(name, name)
            if not monitor.publishers(topic):
                print(f'  {topic}: nobody publishes it yet')
        monitor.spin_until(ended)
