"""``bpc live``: the nodes on a real printer's topics."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.live_page import PageOption, serving
from bpc_perception.cli.parts.monitor import Monitor, monitoring
from bpc_perception.cli.parts.options import JsonOption, QuietOption, RemapOption
from bpc_perception.cli.parts.saved_prints import (
    NoSaveOption,
    PrintsOption,
    SavedPrints,
    saving,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import RecorderConfig, ThicknessConfig
from bpc_perception.drivers.cameras import check_back_end
from bpc_perception.files.design.wanted import wanted_design
from bpc_perception.files.hand_eye_file import load_hand_eye
from bpc_perception.files.parameter_file import configure, live_recorder, name_other_sections
from bpc_perception.messages import topics
from bpc_perception.messages.poses.flange_poses import FlangePoses
from bpc_perception.recording.path_journal import default_folder
from bpc_perception.recording.print_folder import PRINTS
from bpc_perception.report.result_folder import expect_room_for
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.ros_arguments import remappings
from bpc_perception.runtime.supervisor import Supervisor

SILENCE_PATIENCE_S = 5.0  # until topics that are still silent are named


def live(
    hand_eye: Annotated[Path, typer.Option(
        '--handeye', metavar='FILE', help='Hand-eye calibration.')],
    parameters: Annotated[Path | None, typer.Option(
        '--params', metavar='FILE',
        help='ROS parameter file for the nodes; it has to say the nozzle_offset.')] = None,
    design: Annotated[Path | None, typer.Option(
        '--design', metavar='FILE', help='What the prints are to be: G-code, or a CSV path. Where '
        'it lies, and what switches ink, the parameters design.* tell.')] = None,
    camera: Annotated[str | None, typer.Option(
        '--camera', metavar='BACK_END', help='Take captures with this back end of the camera '
        'driver, in the thickness node\'s process; unless given, the camera publishes.')] = None,
    new_print: Annotated[bool, typer.Option(
        '--new-print', help='Begin a new print, even if the last one crashed just now.')] = False,
    resume: Annotated[bool, typer.Option(
        '--resume', help='Go on with the last print, even if it was ended.')] = False,
    out: PrintsOption = PRINTS,
    no_save: NoSaveOption = False,
    remap: RemapOption = None,
    page: PageOption = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Measure a running print until Ctrl-C.

    Robot and extruder publish by themselves.
    """
    terminal = Terminal(quiet, json_lines)
    if new_print and resume:
        raise ValueError('expected --new-print or --resume, found both; give one of them')
    load_hand_eye(hand_eye)
    thickness = configure(ThicknessConfig(), 'thickness', parameters)
    wanted_design(thickness.design, design)
    name_other_sections(parameters)
    if camera is not None:
        check_back_end(camera)
    recorder = live_recorder(parameters)
    expect_room_for(out, 'the prints')
    others = remappings(remap)
    saved = None if no_save else SavedPrints(
        out, hand_eye, parameters, others, design)
    pose_topic = FlangePoses(recorder.pose, recorder.base_frame).topic
    inputs = [others.get(name, name) for name in (*topics.CAMERA, pose_topic, topics.EXTRUSION)]
    with (monitoring(terminal, keep=1) as monitor,
          saving(saved, monitor, terminal),
          Nodes(parameters, remappings=others) as nodes,
          serving(page, terminal, others)):
        start_nodes(nodes, recorder, hand_eye, camera,
                    'none' if new_print else 'newest' if resume else recorder.resume, design)
        terminal.say('Waiting for captures; Ctrl-C ends.')
        supervisor = Supervisor(nodes, monitor.node)
        monitor.spin_until(lambda: False, SILENCE_PATIENCE_S, supervisor.check)
        name_silent_topics(inputs, monitor, terminal)
        monitor.spin_until(lambda: False, check=supervisor.check)


def start_nodes(nodes: Nodes, recorder: RecorderConfig, hand_eye: Path,
                camera: str | None, resume: str, design: Path | None = None) -> None:
    """Start path recorder and thickness node, the latter with the camera driver if there is one.

    Args:
        nodes: to start them with.
        recorder: settings of the path recorder.
        hand_eye: file of the hand-eye calibration.
        camera: back end of the camera driver; None = the camera publishes by itself.
        resume: which print to go on with, see RecorderConfig.
        design: of the prints; None = that of the parameters.
    """
    state = recorder.state_folder or str(default_folder())
    nodes.start('bpc_perception.nodes.path_recorder', state_folder=state, resume=resume)
    thickness = {'hand_eye_file': str(hand_eye), 'state_folder': state,
                 **({'design.file': str(design)} if design else {})}
    if camera is None:
        nodes.start('bpc_perception.nodes.thickness', **thickness)
    else:
        nodes.start('bpc_perception.nodes.composed', back_end=camera, **thickness)


def name_silent_topics(inputs: Iterable[str], monitor: Monitor, terminal: Terminal) -> None:
    """Say which of these topics nobody publishes."""
    for topic in inputs:
        if not monitor.publishers(topic):
            terminal.emit('silent', f'  {topic}: nobody publishes it yet', topic=topic)
