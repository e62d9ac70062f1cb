"""A settings file for the next print, as ``--params`` of the commands takes it."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import yaml

from bpc_perception.core.config import ThicknessConfig
from bpc_perception.files.parameter_file import configure, PARAMETERS, PRINT_SETTINGS
from bpc_perception.files.yaml_file import FileError, read_yaml

THICKNESS = 'thickness'
HEAD = '''\
# Settings for the next print, by bpc window. For ./bpc check and ./bpc live: --params THIS_FILE.
# {section} is for who sets the printer; no node of bpc reads it.
'''


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
    wanted = {('advice', 'target_thickness'): target, ('advice', 'target_file'): '',
              ('tolerance', 'width'): tolerance}
    for parameters in _of_thickness(content):
        for (group, name), value in wanted.items():
            if value != '' or name in _group(parameters, group) or f'{group}.{name}' in parameters:
                parameters.pop(f'{group}.{name}', None)
                _group(parameters, group)[name] = value
    content[PRINT_SETTINGS] = {PARAMETERS: dict(settings)}
    return HEAD.format(section=PRINT_SETTINGS) + yaml.safe_dump(
        content, sort_keys=False, allow_unicode=True)


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
