"""A settings file for the next print, as ``--params`` and ``--settings`` take it."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
import math
from pathlib import Path
from typing import Any

import yaml

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.files.parameter_file import configure, PARAMETERS, PRINT_SETTINGS
from bpc_perception.files.yaml_file import FileError, read_yaml

THICKNESS = 'thickness'
HEAD = '''\
# Settings for the next print, by bpc window. For ./bpc check and ./bpc live: --params THIS_FILE.
# {section} is for who sets the printer, and for ./bpc testprint: --settings THIS_FILE.
# No node of bpc reads it.
'''
MM, KPA = 1e-3, 1e3
FLOW, SPEED, AREA = 'flow_mm3_s', 'speed_mm_s', 'expected_area_mm2'
PRESSURE, TEMPERATURE = 'pressure_kpa', 'temperature_c'


def settings_file(settings: Mapping[str, object], target: float, tolerance: float,
                  base: Path | None) -> str:
    """Return the text of a settings file.

    Args:
        settings: of the printer, by name with unit.
        target: width wanted [m].
        tolerance: how far a width may be off it, as a share.
        base: parameter file whose values are kept; None = there is none.

    Raises ValueError if that is no parameter file.
    """
    configure(ThicknessConfig(), THICKNESS, base)  # refuses what is none
    try:
        content = (read_yaml(base) if base else None) or {}
    except FileError as error:
        raise ValueError(f'{base}: {error}') from error
    content = deepcopy(content)
    wanted = {('advice', 'target_thickness'): round(target, 9), ('advice', 'target_file'): '',
              ('tolerance', 'width'): tolerance}
    for parameters in _of_thickness(content):
        for (group, name), value in wanted.items():
            if value != '' or name in _group(parameters, group) or f'{group}.{name}' in parameters:
                parameters.pop(f'{group}.{name}', None)
                _group(parameters, group)[name] = value
    content[PRINT_SETTINGS] = {PARAMETERS: dict(settings)}
    return HEAD.format(section=PRINT_SETTINGS) + yaml.safe_dump(
        content, sort_keys=False, allow_unicode=True)


def read_settings(file: Path) -> dict[str, float]:
    """Return what a settings file says of the next print.

    Where a pressure drives the ink, the flow is what is expected to come out: the cross-section
    of a bead times its speed.

    Returns:
        ``width`` wanted [m], ``speed`` [m/s] and ``flow`` [m^3/s], and ``pressure`` [Pa] and
        ``temperature`` [degrees Celsius] where they are told.

    Raises:
        ValueError: it is no such file; the message names what to do.
    """
    width = configure(ThicknessConfig(), THICKNESS, file).advice.target_thickness
    section = (read_yaml(file) or {}).get(PRINT_SETTINGS)
    values: dict[str, Any] = section[PARAMETERS] if section else {}

    def value(name: str) -> float:
        found: Any = values.get(name)
        return float(found) if type(found) in (int, float) else math.nan

    speed, flow = value(SPEED) * MM, value(FLOW) * MM**3
    if math.isnan(flow):
        flow = value(AREA) * MM**2 * speed
    for what, number in ((SPEED, speed), (f'{FLOW}, or {PRESSURE} and {AREA},', flow),
                         ('advice.target_thickness', width)):
        if not 0 < number < math.inf:
            raise ValueError(f'{file}: expected {what} above 0 as "bpc window" writes it, found '
                             'none; name its next_print.yaml')
    told = {'pressure': value(PRESSURE) * KPA, 'temperature': value(TEMPERATURE)}
    return {'width': width, 'speed': speed, 'flow': flow} | {
        name: number for name, number in told.items() if not math.isnan(number)}


def _of_thickness(content: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the parameters of each section of the thickness node; one is made if there is none.

    It is put last, since it has to count more than what is said of all nodes.
    """
    found = list(_sections(content))
    if not found:
        content[THICKNESS] = {PARAMETERS: {}}
        found = [content[THICKNESS][PARAMETERS]]
    return found


def _sections(content: dict[str, Any]) -> list[dict[str, Any]]:
    found = []
    for name, below in content.items():
        if str(name).strip('/').rsplit('/', 1)[-1] == THICKNESS and PARAMETERS in below:
            found.append(below[PARAMETERS])
        elif name != PARAMETERS and isinstance(below, dict):
            found += _sections(below)
    return found


def _group(parameters: dict[str, Any], group: str) -> dict[str, Any]:
    made: dict[str, Any] = parameters.setdefault(group, {})
    return made
