"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from bpc_perception.core.control.individuals import FEWEST_PRINTS

BagArgument = Annotated[Path, typer.Argument(
    metavar='BAG', help='Recording: a rosbag2 folder, an .mcap or .db3 file, or the '
    'folder of a print.')]
HandEyeOption = Annotated[Path | None, typer.Option(
    '--handeye', metavar='FILE',
    help='Hand-eye calibration; hand_eye.calib in the bag unless given.')]
ParametersOption = Annotated[Path | None, typer.Option(
    '--params', metavar='FILE',
    help='ROS parameter file for the nodes; params.yaml in the bag unless given.')]
OutOption = Annotated[Path, typer.Option(
    '--out', metavar='DIR', help='Folder for profile.csv, summary.json and report.html.')]
SeparateOption = Annotated[bool, typer.Option(
    '--separate', help='Camera driver and thickness node as two processes, over topics.')]
RemapOption = Annotated[list[str] | None, typer.Option(
    '--remap', metavar='TOPIC:=OTHER',
    help='Take another topic, as joint_states:=/lbr/joint_states; may be repeated.')]
FiguresOption = Annotated[bool, typer.Option(
    '--figures', help='Also write figures for papers, PDF and SVG, into DIR/figures.')]
XlsxOption = Annotated[bool, typer.Option(
    '--xlsx', help='Also write the tables as a workbook of Excel.')]
MatOption = Annotated[bool, typer.Option(
    '--mat', help='Also write the tables as a MAT-file, for MATLAB.')]
BaselineOption = Annotated[int | None, typer.Option(
    '--baseline', min=FEWEST_PRINTS, metavar='N', help='The first so many prints set the control '
    'limits; unless given, all do.')]
QuietOption = Annotated[bool, typer.Option(
    '--quiet', help='Say nothing but errors.')]
JsonOption = Annotated[bool, typer.Option(
    '--json', help='Say everything as JSON, one object a line.')]
