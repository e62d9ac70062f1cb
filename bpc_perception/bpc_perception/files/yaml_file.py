"""Files that people write in YAML, calibrations and parameters: small, plain, read with care."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

LARGEST = 100_000  # a hundred times what such a file has [bytes]
DEEPEST = 20  # nesting of YAML


class FileError(ValueError):
    """A file is not what was expected; the message names what was found, but not the file."""


def read_yaml(path: str | Path) -> Any:
    """The content of a YAML file, made of plain values only. Raises FileError."""
    try:
        with Path(path).open('rb') as file:  # its size may not be known, as that of a device
            content = file.read(LARGEST + 1)
        if len(content) > LARGEST:
            raise ValueError(f'more than {LARGEST} bytes')
        loader = PlainLoader(content.decode('utf-8'))
        try:
            return loader.get_single_data()
        finally:
            loader.dispose()
    # For values that fit no type, such as !!bool x and 2024-99-99, PyYAML lets through whatever
    # making them raises.
    except Exception as error:
        found = getattr(error, 'strerror', None) or str(error) or type(error).__name__
        raise FileError(
            f'expected a readable YAML file, found: {found.splitlines()[0]}') from error


class PlainLoader(yaml.SafeLoader):
    """Knows neither Python's objects nor aliases, of which a few lines make a billion values.

    ROS knows none in its parameter files either.
    """

    _depth = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """One value with all that is in it."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError(f'an alias, *{self.peek_event().anchor}')
        if self._depth >= DEEPEST:
            raise yaml.YAMLError(f'more than {DEEPEST} levels')
        self._depth += 1
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1
