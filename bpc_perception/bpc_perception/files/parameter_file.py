"""Read ROS parameter files without a graph, so that offline runs use the settings of the nodes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
import logging
from pathlib import Path
from typing import Any

from bpc_perception.core.config import RecorderConfig
from bpc_perception.core.parameter import Config, ConfigError, ConfigType, flatten, replace_flat
from bpc_perception.files.yaml_file import FileError, read_yaml

logger = logging.getLogger(__name__)

PARAMETERS = 'ros__parameters'
WILDCARDS = ('*', '**')
OF_EVERY_NODE = ('use_sim_time', 'qos_overrides.', 'start_type_description_service')
NODES = ('bag_player', 'bag_recorder', 'camera_driver', 'extruder_bridge', 'page',
         'path_recorder', 'results_writer', 'thickness')
PRINT_SETTINGS = 'print_settings'  # of the printer: bpc window writes them for people


class ParameterFileError(ValueError):
    """A parameter file is not what was expected; the message names both."""


@dataclass(frozen=True)
class _Section:
    """What a file says of a node, or of those that a wildcard names.

    Attributes:
        name: with its namespace, such as ``cell/thickness`` or ``**``.
        values: by dotted name.
    """

    name: str
    values: dict[str, Any]

    @property
    def node(self) -> str:
        """The name without its namespace."""
        return self.name.rsplit('/', 1)[-1]


def configure(default: ConfigType, node: str, file: str | Path | None) -> ConfigType:
    """Return a configuration with the values that a parameter file gives a node.

    As in ROS, a wildcard is for all nodes, so names there that this node does not know are left
    out, and so are parameters that every node of ROS has.

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
    for section in _sections(Path(file)):
        if section.node == node:  # in any namespace
            values.update({name: value for name, value in section.values.items()
                           if not name.startswith(OF_EVERY_NODE)})
        elif section.node in WILDCARDS:
            values.update({name: value for name, value in section.values.items()
                           if name in known})
    return values


def name_other_sections(file: str | Path | None) -> None:
    """Log which sections are for no node of bpc: one may be misspelt.

    Raises ParameterFileError.
    """
    others = [] if file is None else [
        section.name for section in _sections(Path(file))
        if section.node not in (*NODES, *WILDCARDS, PRINT_SETTINGS)]
    if others:
        logger.warning('%s: expected sections for %s, found %s as well: no node of bpc reads that',
                       file, ', '.join(NODES), ', '.join(others))


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


def _sections(path: Path) -> list[_Section]:
    """Read the sections of a file, in their order [rcl_yaml_param_parser]."""
    try:
        content = read_yaml(path)
    except FileError as error:
        raise ParameterFileError(f'{path}: {error}') from error
    try:
        return list(_sections_in({} if content is None else content, ()))
    except _FormError as error:
        raise ParameterFileError(f'{path}: expected ros__parameters under each node, as in '
                                 f'"thickness: {{ros__parameters: {{…}}}}", found {error}'
                                 '; write it so'
                                 ) from None


class _FormError(Exception):
    """A parameter file has another form; the message names what was found."""


def _sections_in(content: Any, above: tuple[str, ...]) -> Iterator[_Section]:
    """Yield the sections below some levels, of which those above a node are its namespace.

    Raises _FormError.
    """
    if not isinstance(content, dict):
        raise _FormError(f'{content!r:.40} under {".".join(above) or "no node"}')
    for name, below in content.items():
        if name != PARAMETERS:
            yield from _sections_in(below, (*above, str(name).strip('/')))
        elif above and isinstance(below, dict):
            yield _Section('/'.join(above), dict(_flat(below)))
        else:
            where = f'{below!r:.40} in that of {"/".join(above)}' if above else 'it at the top'
            raise _FormError(where)


def _flat(values: dict[str, Any], prefix: str = '') -> list[tuple[str, Any]]:
    """Return the values of nested dictionaries, each with its dotted name."""
    found: list[tuple[str, Any]] = []
    for name, value in values.items():
        if isinstance(value, dict):
            found += _flat(value, f'{prefix}{name}.')
        else:
            found.append((f'{prefix}{name}', value))
    return found
