"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

BagArgument = Annotated[Path, typer.Argument(
    metavar='BAG', help='Recording: a rosbag2 folder, or an .mcap or .db3 file.')]
HandEyeOption = Annotated[Path | None, typer.Option(
    '--handeye', metavar='FILE',
    help='Hand-eye calibration; hand_eye.calib in the bag unless given.')]
ParametersOption = Annotated[Path | None, typer.Option(
    '--params', metavar='FILE',
    help='ROS parameter file for the nodes; params.yaml in the bag unless given.')]
OutOption = Annotated[Path, typer.Option(
    '--out', metavar='DIR', help='Folder for profile.csv, summary.json and report.html.')]
