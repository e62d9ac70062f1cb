"""All targets of the fuzzer: everything that reads bytes which others wrote."""

from __future__ import annotations

from pathlib import Path

from bpc_perception.core.design.design import DesignError
from bpc_perception.core.parameter import ConfigError
from bpc_perception.core.targets import WidthTargets
from bpc_perception.files.design.read import read_design
from bpc_perception.files.hand_eye_file import HandEyeError, load_hand_eye
from bpc_perception.files.parameter_file import ParameterFileError
from bpc_perception.messages.stamps import ConversionError
from bpc_perception.recording.bag import BagError
from bpc_system_tests.robustness.fuzz_targets.extruders import (
    extruder_lines,
    read_lines,
    read_tic,
    tic_answers,
)
from bpc_system_tests.robustness.fuzz_targets.messages import (
    capture_seeds,
    measure_capture,
    message_seeds,
    read_message,
)
from bpc_system_tests.robustness.fuzz_targets.recordings import (
    bag_reader,
    mcap_seeds,
    sqlite_reader,
    sqlite_seed,
)
from bpc_system_tests.robustness.fuzz_targets.target import by_file, Target
from bpc_system_tests.robustness.fuzz_targets.text_files import (
    calibrations,
    g_code_files,
    parameter_files,
    read_parameters,
)


def targets(folder: Path) -> dict[str, Target]:
    """Return all targets by name; their files go into a folder, best one in memory."""
    return {
        'bag': Target(mcap_seeds(folder), bag_reader(folder), (BagError,), cost=4),
        'sqlite bag': Target([sqlite_seed(folder)], sqlite_reader(folder), (BagError,), cost=20),
        'calibration': Target(calibrations(), by_file(folder / 'a.calib', load_hand_eye),
                              (HandEyeError,), text=True, cost=4),
        'parameters': Target(parameter_files(), by_file(folder / 'params.yaml', read_parameters),
                             (ParameterFileError, ConfigError), text=True, cost=16),
        'targets': Target([b'arc_length_mm,thickness_mm\n0,2\n10.5,2.5\n10.5,1e0\n'],
                          by_file(folder / 'targets.csv', WidthTargets.read), (ValueError,),
                          text=True),
        'g-code': Target(g_code_files(), by_file(folder / 'design.gcode', read_design),
                         (DesignError,), text=True, cost=4),
        'design table': Target([b'x_mm,y_mm,z_mm,stroke,width_mm\n0,0,0,1,\n9.5,0,0,1,2\n'],
                               by_file(folder / 'design.csv', read_design), (DesignError,),
                               text=True),
        'extruder line': Target(extruder_lines(), read_lines, ()),
        'tic': Target([tic_answers()], read_tic, ()),
        'messages': Target(message_seeds(), read_message, (ConversionError,)),
        'captures': Target(capture_seeds(), measure_capture, (), cost=40),
    }
