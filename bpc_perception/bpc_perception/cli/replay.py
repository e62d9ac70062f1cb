"""``bpc demo`` and ``bpc replay``: a recording through the nodes, over topics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
import os
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.live_page import PageOption
from bpc_perception.cli.parts.monitor import Monitor, monitoring
from bpc_perception.cli.parts.options import (
    BagArgument,
    FiguresOption,
    HandEyeOption,
    JsonOption,
    OutOption,
    ParametersOption,
    QuietOption,
    RemapOption,
    SeparateOption,
)
from bpc_perception.cli.parts.printer_nodes import printer_nodes
from bpc_perception.cli.parts.result_table import show_repair, show_verdict
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import PlayerConfig
from bpc_perception.core.result import Result
from bpc_perception.messages import topics
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import captures
from bpc_perception.recording.offline import measure_bag
from bpc_perception.report.outputs import check_figures
from bpc_perception.report.print_results import PrintResults, Wanted
from bpc_perception.report.provenance import provenance_of
from bpc_perception.report.result_folder import check_out, check_recording, replacing
from bpc_perception.runtime.child_processes import Nodes
from bpc_perception.runtime.ros_arguments import remappings

CAPTURE_PATIENCE_S = 5.0  # in which the path has to reach the stamp of a capture
LAST_RESULTS_TIMEOUT_S = 10.0  # after the end of the recording
# For the nodes that listen to robot and extruder.
INPUT_PARAMETERS = {
    # A robot's poses are best effort; but a recording can wait for a busy machine.
    **{f'qos_overrides./{topic}.subscription.reliability': 'reliable' for topic in topics.POSES},
    # Robot and extruder fall silent at the end of the recording, which is no fault.
    'watch.warn_after': 0.0,
}


@dataclass(frozen=True)
class Playback:
    """A recording, and how it is played.

    Attributes:
        recording: with its calibration and settings.
        stamps_ns: of its captures, in order [ns].
        player: settings of the bag player.
        separate: whether camera driver and thickness node are processes of their own.
    """

    recording: inputs.Inputs
    stamps_ns: list[int]
    player: PlayerConfig
    separate: bool


def demo(
    out: OutOption = Path('demo'),
    rate: Annotated[float, typer.Option(help='Speed; 1 = as recorded.')] = 1.0,
    figures: FiguresOption = False,
    page: PageOption = False,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Replay the sample print in real time through the three nodes."""
    root = Path(os.environ.get('BPC_ROOT', '.'))
    Terminal(quiet, json_lines).say(
        'A spiral of 174 mm is printed in one minute; the camera looks every 12 s.')
    replay(root / 'bags' / 'spiral_gaps', out, rate=rate, figures=figures, page=page,
           quiet=quiet, json_lines=json_lines)


def replay(
    bag: BagArgument,
    out: OutOption = Path('replay'),
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    rate: Annotated[float, typer.Option(help='Speed; 1 = as recorded.')] = 1.0,
    loop: Annotated[bool, typer.Option('--loop', help='Again and again, until Ctrl-C.')] = False,
    separate: SeparateOption = False,
    figures: FiguresOption = False,
    page: PageOption = False,
    remap: RemapOption = None,
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Replay a recording through the nodes."""
    terminal = Terminal(quiet, json_lines)
    check_out(out)
    check_figures(figures)
    player = PlayerConfig(bag=str(bag), rate=rate, loop=loop, remap=' '.join(remap or []))
    recording = inputs.load(bag, hand_eye, parameters, remappings(remap))
    check_recording(out, bag)
    stamps_ns = [capture.stamp_ns for _, capture in captures(recording.bag)]
    if not stamps_ns:
        raise ValueError(f'{bag}: expected a complete capture, found none'
                         '; record image, camera info and cloud of each')
    playback = Playback(recording, stamps_ns, player, separate)
    monitor, complete = play(playback, terminal, page)
    # After Ctrl-C nothing can be said about captures behind the last result.
    expected = len(stamps_ns) if complete else count_up_to_last_result(monitor, stamps_ns)
    if not monitor.profiles:
        silence = 'the nodes gave no reason' if complete else 'it was ended before the first'
        raise ValueError(f'{bag}: expected a profile, found none; '
                         f'{"; ".join(monitor.warnings) or silence}')
    with replacing(out) as folder, terminal.progress('collect', expected) as advance:
        results = PrintResults(folder, provenance_of(recording), Wanted(figures=figures),
                               expected)
        for result in islice(live_results(monitor, recording), expected):
            results.add(result)
            advance()
        files = results.finish()
    for result in results.reported:
        if result.verdict is not None:
            show_verdict(terminal, result.verdict)
        if result.repair is not None:
            show_repair(terminal, result.repair)
    terminal.files([out / file for file in files])


def play(playback: Playback, terminal: Terminal, page: bool) -> tuple[Monitor, bool]:
    """Play a recording through the nodes until its last capture is measured, or Ctrl-C.

    Returns:
        The monitor, which has the results, and whether the recording was played to its end.
    """
    complete = False
    with (monitoring(terminal) as monitor,
          printer_nodes(monitor, terminal, page, playback.recording.parameter_file,
                        use_sim_time=True) as nodes):
        start_measuring_nodes(nodes, playback)
        # Start the player last: it begins as soon as anyone listens.
        monitor.spin_until(lambda: (monitor.sees('path_recorder', 'thickness', 'camera_driver')
                                    and monitor.hears_results()), check=nodes.check)
        player = playback.player
        nodes.start('bpc_perception.nodes.bag_player', bag=player.bag, rate=player.rate,
                    loop=player.loop, remap=player.remap, use_sim_time=False)
        monitor.spin_until(lambda: nodes.ended('bag_player'),
                           check=lambda: nodes.check('bag_player'))
        monitor.spin_until(lambda: monitor.has(playback.stamps_ns[-1]),
                           LAST_RESULTS_TIMEOUT_S)
        complete = True
    return monitor, complete


def start_measuring_nodes(nodes: Nodes, playback: Playback) -> None:
    """Start path recorder, camera driver and thickness node."""
    nodes.start('bpc_perception.nodes.path_recorder', **INPUT_PARAMETERS)
    nodes.start_measuring(
        {'back_end': 'bag', 'bag': playback.player.bag, 'remap': playback.player.remap},
        {'patience': CAPTURE_PATIENCE_S, 'hand_eye_file': str(playback.recording.hand_eye_file),
         'advice.target_file': playback.recording.thickness.advice.target_file,
         **INPUT_PARAMETERS},
        playback.separate)


def count_up_to_last_result(monitor: Monitor, stamps_ns: list[int]) -> int:
    """Return the number of captures up to the last one that has all its results."""
    return max((number for number, stamp_ns in enumerate(stamps_ns, 1)
                if monitor.has(stamp_ns)), default=0)


def live_results(monitor: Monitor, recording: inputs.Inputs) -> Iterator[Result]:
    """Yield the live results in order, each with its recorded capture and the camera's pose."""
    for result in measure_bag(recording.bag, recording.hand_eye, recording.thickness,
                              recording.recorder):
        stamp_ns = result.capture.stamp_ns
        yield (replace(result, profile=monitor.profiles[stamp_ns], advice=monitor.advice[stamp_ns],
                       verdict=monitor.verdicts[stamp_ns], warning='')
               if monitor.has(stamp_ns) else  # Ctrl-C may come between them
               Result(result.capture, result.T_base_camera,
                      refusal=result.refusal or 'no profile came'))
