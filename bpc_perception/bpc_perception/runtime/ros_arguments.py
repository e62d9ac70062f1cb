"""The command line of a node: its parameters and remappings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
import json
from pathlib import Path
from typing import Any


def ros_arguments(parameters: Mapping[str, Any], remappings: Mapping[str, str],
                  parameter_file: Path | None = None) -> list[str]:
    """Return the arguments that give a node parameters; these win over those of the file.

    A value is written as JSON, which is YAML: in one line, and a string stays a string whatever
    is in it.
    """
    arguments = ['--ros-args', '--disable-external-lib-logs']
    if parameter_file is not None:
        arguments += ['--params-file', str(parameter_file)]
    for name, value in parameters.items():
        arguments += ['-p', f'{name}:={json.dumps(value, ensure_ascii=False)}']
    for topic, other in remappings.items():
        arguments += ['-r', f'{topic}:={other}']
    return arguments


def remappings(rules: Iterable[str] | None) -> dict[str, str]:
    """Return the rules of ``--remap``: topic to the other that is taken in its place.

    Raises:
        ValueError: a rule has another form.
    """
    others = {}
    for rule in rules or []:
        topic, colon, other = rule.partition(':=')
        if not (topic and colon and other):
            raise ValueError(f'--remap: expected TOPIC:=OTHER, found {rule!r}')
        others[topic] = other
    return others
