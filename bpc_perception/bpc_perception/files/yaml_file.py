"""Read YAML files that users write: small, of plain values, and possibly made to harm."""

from __future__ import annotations

from pathlib import Path
import re
from typing import Any

import yaml

LARGEST_FILE_BYTES = 100_000  # a hundred times the size of such a file
MOST_LEVELS = 20  # of nesting


class FileError(ValueError):
    """A file is not what was expected; the message names what was found, but not the file."""


def read_yaml(path: str | Path, largest: int = LARGEST_FILE_BYTES) -> Any:
    """Return the content of a YAML file, made of plain values only.

    Raises FileError, also when it has more than ``largest`` bytes.
    """
    try:
        with Path(path).open('rb') as file:  # a device, for instance, has no known size
            content = file.read(largest + 1)
        if len(content) > largest:
            raise ValueError(f'more than {largest} bytes')
        # As OpenCV writes it, the directive is none of YAML.
        loader = PlainLoader(content.decode('utf-8').removeprefix('%YAML:1.0'))
        try:
            return loader.get_single_data()
        finally:
            loader.dispose()
    # PyYAML lets through whatever the construction of a value raises, for instance of !!bool x or
    # 2024-99-99.
    except Exception as error:
        found = getattr(error, 'strerror', None) or str(error) or type(error).__name__
        raise FileError(
            f'expected a readable YAML file, found: {found.splitlines()[0]}') from error


class PlainLoader(yaml.SafeLoader):
    """Loads neither Python objects nor aliases: a few lines of aliases make a billion values.

    ROS does not load aliases from parameter files either. As there, 2e-3 is a number.
    """

    _depth = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose one value with all that is in it."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError(f'an alias, *{self.peek_event().anchor}')
        if self._depth >= MOST_LEVELS:
            raise yaml.YAMLError(f'more than {MOST_LEVELS} levels')
        self._depth += 1
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1


def _matrix(loader: PlainLoader, node: yaml.MappingNode) -> dict[Any, Any]:
    """Construct a matrix of OpenCV as the mapping that it is."""
    return dict(loader.construct_mapping(node, deep=True))


PlainLoader.add_constructor('tag:yaml.org,2002:opencv-matrix', _matrix)
PlainLoader.add_implicit_resolver(
    'tag:yaml.org,2002:float', re.compile(r'^[-+]?(\.\d+|\d+(\.\d*)?)[eE][-+]?\d+$'),
    list('-+.0123456789'))
