"""Read ROS parameter files without a graph, so that offline runs use the settings of the nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.parameter import Config, ConfigError, ConfigType, flatten, replace_flat
from bpc_perception.files.yaml_file import FileError, read_yaml


class ParameterFileError(ValueError):
    """A parameter file is not what was expected; the message names both."""


def configure(default: ConfigType, node: str, file: str | Path | None) -> ConfigType:
    """Return a configuration with the values that a parameter file gives a node.

    As in ROS, ``/**`` is for all nodes, so names there that this node does not know are left out.

    Raises:
        ParameterFileError: the file cannot be read or has another form.
        ConfigError: a value does not fit.
    """
    return replace_flat(default, given_values(default, node, file))


def given_values(default: Config, node: str, file: str | Path | None) -> dict[str, Any]:
    """Return what a parameter file says of a node's parameters, by dotted name, unchecked.

    Raises ParameterFileError.
    """
    if file is None:
        return {}
    known = {name for name, _, _ in flatten(default)}
    values: dict[str, Any] = {}
    for selector, parameters in _sections(Path(file)).items():
        flat = dict(_flat(parameters))
        if selector.strip('/') == '**':
            values.update({name: value for name, value in flat.items() if name in known})
        elif selector.rsplit('/', 1)[-1] == node:  # in any namespace
            values.update(flat)
    return values


def live_recorder(file: str | Path | None) -> RecorderConfig:
    """Return the path recorder's configuration for a real printer, with its nozzle offset.

    Raises what ``configure`` raises, and ConfigError when the file does not state
    ``nozzle_offset``: with the default, bpc would silently measure beside the bead.
    """
    config = configure(RecorderConfig(), 'path_recorder', file)
    if 'nozzle_offset' not in given_values(config, 'path_recorder', file):
        raise ConfigError('nozzle_offset: expected the nozzle tip in the flange frame among the '
                          'parameters of path_recorder, found none; "bpc calibrate nozzle" '
                          'finds it')
    return config


def _sections(path: Path) -> dict[str, dict[str, Any]]:
    try:
        content = read_yaml(path)
    except FileError as error:
        raise ParameterFileError(f'{path}: {error}') from error
    try:
        return {str(node): dict(section['ros__parameters'])
                for node, section in (content or {}).items()}
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ParameterFileError(f'{path}: expected ros__parameters under each node, '
                                 'found another form') from None


def _flat(values: dict[str, Any], prefix: str = '') -> list[tuple[str, Any]]:
    """Return the values of nested dictionaries, each with its dotted name."""
    found: list[tuple[str, Any]] = []
    for name, value in values.items():
        if isinstance(value, dict):
            found += _flat(value, f'{prefix}{name}.')
        else:
            found.append((f'{prefix}{name}', value))
    return found
