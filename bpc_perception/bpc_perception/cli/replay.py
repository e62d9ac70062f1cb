"""``bpc demo`` and ``bpc replay``: a recording through the nodes, over topics."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
import os
from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.cli.parts.live_page import keep_page_open, PageOption, serving
from bpc_perception.cli.parts.monitor import Monitor, monitoring
from bpc_perception.cli.parts.options import (
    BagArgument,
    FiguresOption,
    HandEyeOption,
    JsonOption,
    OutOption,
    ParametersOption,
    QuietOption,
    SeparateOption,
)
from bpc_perception.cli.parts.terminal import Terminal
from bpc_perception.core.config import PlayerConfig
from bpc_perception.core.session import Result
from bpc_perception.messages import topics
from bpc_perception.recording import inputs
from bpc_perception.recording.contents import captures
from bpc_perception.recording.offline import measure_bag
from bpc_perception.report.outputs import check_figures, check_out, write_outputs
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import provenance_of
from bpc_perception.runtime.child_processes import Nodes

# A recording can wait for a busy machine; a robot's poses, best effort, cannot.
LOSSLESS = {f'qos_overrides./{topic}.subscription.reliability': 'reliable'
            for topic in topics.POSES}
# Robot and extruder of a recording end with it, which is no fault.
UNWATCHED = {'watch.warn_after': 0.0}
PATIENCE = 5.0  # of a capture, for the path to reach its stamp [s]
AFTERMATH = 10.0  # for the last results after the recording's end [s]


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
    quiet: QuietOption = False,
    json_lines: JsonOption = False,
) -> None:
    """Replay a recording through the nodes."""
    terminal = Terminal(quiet, json_lines)
    check_out(out)
    check_figures(figures)
    PlayerConfig(rate=rate)
    given = inputs.load(bag, hand_eye, parameters)
    stamps = [capture.stamp_ns for _, capture in captures(given.bag)]
    if not stamps:
        raise ValueError(f'{bag}: expected a complete capture, found none')
    played_out = False
    with (monitoring(terminal) as monitor,
          Nodes(given.parameter_file, {'use_sim_time': True, **UNWATCHED}) as nodes,
          serving(page, terminal, use_sim_time=True)):
        monitor.expect_no_other_printer()
        nodes.start('bpc_perception.nodes.path_recorder', **LOSSLESS)
        nodes.start_measuring(
            {'back_end': 'bag', 'bag': str(bag)},
            {'patience': PATIENCE, 'hand_eye_file': str(given.hand_eye_file), **LOSSLESS},
            separate)

        def there() -> bool:
            nodes.check()
            return monitor.sees('path_recorder', 'thickness', 'camera_driver')

        # Only then the player, which takes anyone who listens for its audience.
        monitor.spin_until(there)
        nodes.start('bpc_perception.nodes.bag_player', bag=str(bag), rate=rate, loop=loop,
                    use_sim_time=False)

        def played() -> bool:
            nodes.check('bag_player')
            return nodes.ended('bag_player')

        monitor.spin_until(played)
        monitor.spin_until(lambda: stamps[-1] in monitor.advice, AFTERMATH)
        played_out = True
        keep_page_open(page, terminal, monitor)
    # After Ctrl-C nothing can be said of what comes behind the last result.
    expected = len(stamps) if played_out else max(
        (number for number, stamp_ns in enumerate(stamps, 1)
         if stamp_ns in monitor.profiles and stamp_ns in monitor.advice), default=0)
    log = PrintLog(expected=expected)
    with terminal.progress('collect', expected) as advance:
        for result in islice(collect(monitor, given), expected):
            log.add(result)
            advance()
    if log.reported is None:
        silence = 'the nodes gave no reason' if played_out else 'it was ended before the first'
        raise ValueError(f'{bag}: expected a profile, found none; '
                         f'{"; ".join(monitor.warnings) or silence}')
    terminal.files(write_outputs(out, log, provenance_of(given), figures))


def collect(monitor: Monitor, given: inputs.Inputs) -> Iterator[Result]:
    """The live results, each with its recorded capture and the camera's pose then."""
    for result in measure_bag(given.bag, given.hand_eye, given.thickness, given.recorder):
        profile = monitor.profiles.get(result.capture.stamp_ns)
        advice = monitor.advice.get(result.capture.stamp_ns)
        if profile is None or advice is None:  # Ctrl-C may come between the two
            profile, advice = None, None
        yield Result(result.capture, result.T_base_camera, profile, advice,
                     result.refusal or 'no profile came')
