"""ROS parameter files read without a graph, so that offline runs use the nodes' own settings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from bpc_perception.core.config import ConfigType, flatten, replace_flat

SIZE_LIMIT = 1_000_000


class ParameterFileError(ValueError):
    """A parameter file is not what was expected; the message names both."""


def configure(default: ConfigType, node: str, file: str | Path | None) -> ConfigType:
    """A configuration with the values that a parameter file gives a node.

    As with ROS, ``/**`` speaks to all nodes, so names unknown to this one are passed over there.

    Raises:
        ParameterFileError: the file cannot be read or has another form.
        ConfigError: a value does not fit.
    """
    if file is None:
        return default
    known = {name for name, _, _ in flatten(default)}
    values = {}
    for selector, parameters in _sections(Path(file)).items():
        flat = dict(_flat(parameters))
        if selector.strip('/') == '**':
            values.update({name: value for name, value in flat.items() if name in known})
        elif selector.rsplit('/', 1)[-1] == node:  # in whatever namespace
            values.update(flat)
    return replace_flat(default, values)


def _sections(path: Path) -> dict[str, dict[str, Any]]:
    try:
        if path.stat().st_size > SIZE_LIMIT:
            raise ParameterFileError(f'{path}: expected parameters, found a very large file')
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        problem = getattr(error, 'strerror', None) or str(error).splitlines()[0]
        raise ParameterFileError(f'{path}: expected a YAML file, found: {problem}') from error
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
