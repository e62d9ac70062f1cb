"""``bpc measure``: a recorded print measured without a graph."""

from __future__ import annotations

from typing import Annotated

import typer

from bpc_perception.cli import inputs
from bpc_perception.cli.options import BagArgument, HandEyeOption, OutOption, ParametersOption
from bpc_perception.cli.table import ResultTable
from bpc_perception.offline import measure_bag
from bpc_perception.outputs import write_outputs


def measure(
    bag: BagArgument,
    out: OutOption,
    hand_eye: HandEyeOption = None,
    parameters: ParametersOption = None,
    capture: Annotated[int | None, typer.Option(
        metavar='N', help='Report this capture of the print, from 0; else the last.')] = None,
    all_captures: Annotated[bool, typer.Option(
        '--all', help='Write the outputs of every capture, each into its own folder.')] = False,
) -> None:
    """Measure a recorded print, to the same digits as live."""
    inputs.check_out(out)
    given = inputs.load(bag, hand_eye, parameters)
    table = ResultTable()
    results = []
    for result in measure_bag(given.bag, given.hand_eye, given.thickness, given.recorder):
        table.add(result)
        results.append(result)
    measured = [result for result in results if result.profile is not None]
    if not measured:
        reasons = '; '.join(sorted({result.refusal for result in results})) or 'no capture'
        raise ValueError(f'{bag}: expected a capture that can be measured, found: {reasons}')
    if capture is not None:
        found = ', '.join(str(result.profile.capture) for result in measured if result.profile)
        results = [result for result in measured
                   if result.profile is not None and result.profile.capture == capture]
        if not results:
            raise ValueError(f'{bag}: expected capture {capture}, found {found}')
    if results[-1].warning:
        typer.echo(f'bpc: {results[-1].warning}', err=True)
    if all_captures:
        for result in measured:
            assert result.profile is not None
            write_outputs(out / f'capture_{result.profile.capture:04d}', [result],
                          given.provenance)
    for file in write_outputs(out, results, given.provenance):
        print(file)
