"""The tables and files of parameters, made from the configuration objects."""

from __future__ import annotations

from typing import Any

import yaml

from bpc_perception.core.config import (
    BagRecorderConfig,
    CameraConfig,
    ExtruderConfig,
    PageConfig,
    PlayerConfig,
    RecorderConfig,
    ResultsWriterConfig,
    ThicknessConfig,
    ZividConfig,
)
from bpc_perception.core.parameter import Config, flatten, Parameter
from bpc_sim.config import ControllerConfig, SimConfig
from bpc_system_tests.documentation.pages import ROOT

CONFIG = ROOT / 'bpc_perception' / 'config'
# The tables of each page.
TABLES: dict[str, dict[str, type[Config]]] = {
    'camera_driver': {'camera_driver': CameraConfig, 'zivid': ZividConfig},
    'extruder_bridge': {'extruder_bridge': ExtruderConfig},
    'path_recorder': {'path_recorder': RecorderConfig},
    'thickness': {'thickness': ThicknessConfig},
    'bag_player': {'bag_player': PlayerConfig},
    'bag_recorder': {'bag_recorder': BagRecorderConfig},
    'results_writer': {'results_writer': ResultsWriterConfig},
    'page': {'page': PageConfig},
    'simulator': {'print_controller': ControllerConfig, 'synthetic printer': SimConfig},
}
FILES: dict[str, type[Config]] = {
    node: TABLES[node][node] for node in (
        'camera_driver', 'extruder_bridge', 'path_recorder', 'thickness')}
TYPES = {bool: 'bool', int: 'integer', float: 'double', str: 'string'}
HEADER = ('| parameter | type | unit | default | range | meaning |', '|---|---|---|---|---|---|')


def parameter_table(config: Config) -> str:
    """Return the Markdown table of all parameters."""
    rows = []
    for name, parameter, value in flatten(config):
        mark = '' if parameter.read_only else ' ⟳'
        kind = (f'{TYPES[type(value[0])]} array' if isinstance(value, tuple)
                else TYPES[type(value)])
        rows.append(f'| `{name}`{mark} | {kind} | {parameter.unit} | '
                    f'`{in_yaml(value)}` | {limits(parameter)} | {parameter.description} |')
    return '\n'.join((*HEADER, *rows)) + '\n'


def parameter_file(node: str, config: Config) -> str:
    """Return the ROS parameter file with every default and its meaning."""
    lines = [f'# Every parameter of the {node} node with its default; keep what you change.',
             f'{node}:', '  ros__parameters:']
    for name, parameter, value in flatten(config):
        unit = f' [{parameter.unit}]' if parameter.unit else ''
        remarks = [limits(parameter)] if limits(parameter) else []
        if parameter.read_only:
            remarks.append('read at the start')
        remark = f' ({"; ".join(remarks)})' if remarks else ''
        lines += [f'    # {parameter.description}{unit}{remark}', f'    {name}: {in_yaml(value)}']
    return '\n'.join(lines) + '\n'


def limits(parameter: Parameter) -> str:
    """Return the values that a parameter takes; empty = any."""
    if parameter.choices:
        return ', '.join(parameter.choices)
    if parameter.minimum is None or parameter.maximum is None:
        return ''
    return f'{parameter.minimum:.7g} to {parameter.maximum:.7g}'


def in_yaml(value: Any) -> str:
    """Return a value as it is written in a parameter file."""
    value = list(value) if isinstance(value, tuple) else value
    return yaml.safe_dump(value, default_flow_style=True).splitlines()[0]
