"""Hand-eye calibration and node parameters of a print that goes wrong."""

from __future__ import annotations

from pathlib import Path

from bpc_sim.closed_loop.job import ClosedLoopJob
from bpc_sim.printer.settings import hand_eye_calibration, node_parameters

MILLIMETRE_M = 1e-3


def loop_hand_eye(print_: ClosedLoopJob) -> dict[str, object]:
    """Return the calibration of the job's camera; wrong if that is what goes wrong."""
    calibration = hand_eye_calibration(print_.job)
    transform = calibration['transform']
    assert isinstance(transform, dict)
    # Across the strands of the meander, which run along the x axis of the bed.
    wrong = print_.job.T_base_surface[:3, 1] * print_.situation.offset
    for axis, value in zip('xyz', wrong.tolist(), strict=True):
        transform['translation'][axis] += value
    return calibration


def loop_parameters(print_: ClosedLoopJob, table: Path) -> dict[str, object]:
    """Return the parameters of the nodes, and write the targets along the path to ``table``."""
    targets = print_.situation.targets
    rows = [f'{s / MILLIMETRE_M},{width / MILLIMETRE_M}'
            for s, width in zip(targets.arc_length, targets.thickness, strict=True)]
    table.write_text('\n'.join(('arc_length_mm,thickness_mm', *rows)) + '\n')
    values = node_parameters(print_.job, float(targets.thickness[0]))
    thickness = values['/**/thickness']
    assert isinstance(thickness, dict)
    thickness['ros__parameters']['advice.target_file'] = str(table)
    return values
