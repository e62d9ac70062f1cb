"""ROS parameter files read without a graph, so that offline runs use the nodes' own settings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.parameter import Config, ConfigError, ConfigType, flatten, replace_flat
from bpc_perception.files.yaml_file import FileError, read_yaml


class ParameterFileError(ValueError):
    """A parameter file is not what was expected; the message names both."""


def configure(default: ConfigType, node: str, file: str | Path | None) -> ConfigType:
    """A configuration with the values that a parameter file gives a node.

    As with ROS, ``/**`` speaks to all nodes, so names unknown to this one are passed over there.

    Raises:
        ParameterFileError: the file cannot be read or has another form.
        ConfigError: a value does not fit.
    """
    return replace_flat(default, given_values(default, node, file))


def given_values(default: Config, node: str, file: str | Path | None) -> dict[str, Any]:
    """What a parameter file says of a node's parameters, by dotted name; checked by nobody yet.

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
        elif selector.rsplit('/', 1)[-1] == node:  # in whatever namespace
            values.update(flat)
    return values


def live_recorder(file: str | Path | None) -> RecorderConfig:
    """The path recorder's configuration for a real printer, whose nozzle has to be said.

    Raises what ``configure`` raises, and ConfigError where nothing says ``nozzle_offset``: the
    default would measure beside the bead without a word.
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
    found: list[tuple[str, Any]] = []
    for name, value in values.items():
        if isinstance(value, dict):
            found += _flat(value, f'{prefix}{name}.')
        else:
            found.append((f'{prefix}{name}', value))
    return found
