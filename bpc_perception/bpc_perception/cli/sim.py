"""``bpc sim``: the nodes on the synthetic printer."""

from __future__ import annotations

from pathlib import Path
import tempfile
import time
from typing import Annotated

import typer
import yaml

from bpc_perception.cli.monitor import monitoring
from bpc_perception.cli.options import SeparateOption
from bpc_perception.cli.processes import Nodes
from bpc_perception.core.config import AdviceConfig, CameraConfig

START_DELAY = 6.0  # until all nodes have found each other [s]


def sim(
    scenario: Annotated[str, typer.Option(help=(
        'What is printed: spiral_gaps, line, ring, meander, archimedean or fermat.'
    ))] = 'spiral_gaps',
    speed: Annotated[float, typer.Option(help='Of the nozzle [mm/s].')] = 3.0,
    rate: Annotated[float, typer.Option(help='Captures a second.')] = 0.5,
    target: Annotated[float, typer.Option(help='Thickness wanted [mm].')] = 2.0,
    record: Annotated[Path | None, typer.Option(
        metavar='BAG', help='Only write the print to a new bag, without a graph.')] = None,
    separate: SeparateOption = False,
) -> None:
    """Print on the synthetic printer, measured live (open loop)."""
    # The simulator is a package of its own, needed by this command only.
    from bpc_sim.config import SimConfig
    from bpc_sim.sample import hand_eye, parameters
    from bpc_sim.sample import record as record_print

    if not 0.1 <= speed <= 500:
        raise ValueError(f'speed: expected 0.1 to 500 mm/s, found {speed:g}')
    config = SimConfig(scenario=scenario, speed=speed * 1e-3)
    CameraConfig(rate=rate)
    AdviceConfig(target_thickness=target * 1e-3)
    if rate == 0:
        raise ValueError('rate: expected more than 0 Hz, found 0')
    job = config.job()
    if record is not None:
        record_print(job, record, 1 / rate, target * 1e-3)
        print(record)
        return
    with tempfile.TemporaryDirectory() as folder:
        calibration, settings = Path(folder, 'hand_eye.calib'), Path(folder, 'params.yaml')
        calibration.write_text(yaml.safe_dump(hand_eye(job)))
        settings.write_text(yaml.safe_dump(parameters(job, target * 1e-3)))
        with monitoring(keep=1) as monitor, Nodes(settings) as nodes:
            monitor.expect_no_other_printer()
            start_ns = time.time_ns() + round(START_DELAY * 1e9)
            common = {'scenario': scenario, 'speed': config.speed, 'start_time_ns': start_ns}
            nodes.start('bpc_perception.nodes.path_recorder')
            nodes.start_measuring({'back_end': 'synthetic', 'rate': rate, **common},
                                  {'hand_eye_file': str(calibration)}, separate)
            nodes.start('bpc_sim.nodes.robot', **common)
            nodes.start('bpc_sim.nodes.extruder', **common)
            print(f'{job.length * 1e3:.0f} mm at {speed:g} mm/s: '
                  f'{job.duration + START_DELAY:.0f} s; Ctrl-C ends.')
            end_ns = start_ns + round(job.duration * 1e9)

            def complete() -> bool:
                nodes.check()
                return any(stamp > end_ns for stamp in monitor.advice)

            if not monitor.spin_until(complete, START_DELAY + job.duration + 10 + 2 / rate):
                raise ValueError('expected a profile after the end of the print, found none; '
                                 f'{"; ".join(monitor.warnings) or "the nodes gave no reason"}')
