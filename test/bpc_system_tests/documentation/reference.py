"""What the README and config/ say of the parameters, made from the configuration objects.

Run as a program, writes both anew, and the SROS 2 policy.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import re
from typing import Any

import yaml

from bpc_perception.core.config import (
    BagRecorderConfig,
    CameraConfig,
    ExtruderConfig,
    PageConfig,
    PlayerConfig,
    RecorderConfig,
    ThicknessConfig,
    ZividConfig,
)
from bpc_perception.core.parameter import Config, flatten, Parameter
from bpc_sim.config import ControllerConfig, SimConfig

if __package__:
    from bpc_system_tests.documentation import sros2_policy
else:
    import sros2_policy

ROOT = Path(__file__).resolve().parents[3]
README = ROOT / 'README.md'
CONFIG = ROOT / 'bpc_perception' / 'config'
TABLES: dict[str, type[Config]] = {
    'camera_driver': CameraConfig,
    'zivid': ZividConfig,
    'extruder_bridge': ExtruderConfig,
    'path_recorder': RecorderConfig,
    'thickness': ThicknessConfig,
    'bag_player': PlayerConfig,
    'bag_recorder': BagRecorderConfig,
    'page': PageConfig,
    'synthetic printer': SimConfig,
    'print_controller': ControllerConfig,
}
FILES: dict[str, type[Config]] = {
    node: TABLES[node] for node in (
        'camera_driver', 'extruder_bridge', 'path_recorder', 'thickness')}
TYPES = {bool: 'bool', int: 'integer', float: 'double', str: 'string', tuple: 'double array'}
HEADER = ('| parameter | type | unit | default | range | meaning |', '|---|---|---|---|---|---|')


def table(config: Config) -> str:
    """The Markdown table of all parameters."""
    rows = []
    for name, parameter, value in flatten(config):
        mark = '' if parameter.read_only else ' ⟳'
        kind = (f'{TYPES[type(value[0])]} array' if isinstance(value, tuple)
                else TYPES[type(value)])
        rows.append(f'| `{name}`{mark} | {kind} | {parameter.unit} | '
                    f'`{in_yaml(value)}` | {limits(parameter)} | {parameter.description} |')
    return '\n'.join((*HEADER, *rows)) + '\n'


def parameter_file(node: str, config: Config) -> str:
    """The ROS parameter file with every default and what it means."""
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
    """The values that a parameter takes; empty = any."""
    if parameter.choices:
        return ', '.join(parameter.choices)
    if parameter.minimum is None or parameter.maximum is None:
        return ''
    return f'{parameter.minimum:.7g} to {parameter.maximum:.7g}'


def in_yaml(value: Any) -> str:
    """A value as it is written in a parameter file."""
    value = list(value) if isinstance(value, tuple) else value
    return yaml.safe_dump(value, default_flow_style=True).splitlines()[0]


def with_tables(text: str) -> str:
    """The README's text with the tables between their markers made anew."""
    for name, kind in TABLES.items():
        start, end = f'<!-- parameters of {name} -->\n', '<!-- end -->'
        pattern = f'{re.escape(start)}.*?{end}'
        if len(re.findall(pattern, text, re.DOTALL)) != 1:
            raise ValueError(f'README: expected one table marked {start.strip()}')
        new = f'{start}{table(kind())}{end}'
        text = re.sub(pattern, lambda _, new=new: new, text, flags=re.DOTALL)
    return text


def files() -> Iterator[tuple[Path, str]]:
    """Every file made from the configuration, and what it has to say."""
    yield README, with_tables(README.read_text(encoding='utf-8'))
    for node, kind in FILES.items():
        yield CONFIG / f'{node}.yaml', parameter_file(node, kind())
    yield sros2_policy.FILE, sros2_policy.policy()


if __name__ == '__main__':
    for path, text in files():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding='utf-8')
