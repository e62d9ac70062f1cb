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


def read_yaml(path: str | Path, most_bytes: int = LARGEST_FILE_BYTES,
              aliases: bool = False) -> Any:
    """Return the content of a YAML file, made of plain values only. Raises FileError.

    Args:
        path: of the file.
        most_bytes: that it may have.
        aliases: whether it may have them. Then nobody may go through all of the content.
    """
    try:
        with Path(path).open('rb') as file:  # a device, for instance, has no known size
            content = file.read(most_bytes + 1)
    except OSError as error:
        raise FileError(f'expected a readable YAML file, found: {error.strerror}') from error
    except ValueError as error:  # of a name that no file can have
        raise FileError(f'expected a readable YAML file, found: {error}') from error
    if len(content) > most_bytes:
        raise FileError(f'expected a readable YAML file, found: more than {most_bytes} bytes; is '
                        'it the right file?')
    try:
        return _plain(content, aliases)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        assert mark is not None  # of whatever the parser, or this loader, refuses
        problem = str(error.problem).removeprefix('found ')
        raise FileError(_at(mark.line, mark.column, problem)) from error
    except UnicodeDecodeError as error:
        before = content[:error.start].decode('utf-8')
        raise FileError(_behind(before, 'letters that are not UTF-8')) from error
    except yaml.reader.ReaderError as error:
        before, found = content.decode('utf-8')[:error.position], chr(error.character)
        raise FileError(_behind(before, f'the control character {found!r}')) from error
    except Exception as error:  # PyYAML lets through what Python says of a letter that is none
        found = (str(error) or type(error).__name__).splitlines()[0]
        raise FileError(f'expected a readable YAML file, found: {found}; save it anew') from error


def _plain(content: bytes, aliases: bool) -> Any:
    # As OpenCV writes it, the directive is none of YAML; its line stays, so that lines count.
    loader = PlainLoader(content.decode('utf-8').removeprefix('%YAML:1.0'))
    loader.aliases = aliases
    try:
        return loader.get_single_data()
    finally:
        loader.dispose()


def _at(line: int, column: int, problem: str) -> str:
    """Return an error at a place, which counts from 0."""
    return (f'expected a readable YAML file, found: {problem}, in line {line + 1}, '
            f'column {column + 1}; correct it there or just above')


def _behind(before: str, problem: str) -> str:
    """Return an error behind a text."""
    return _at(before.count('\n'), len(before) - before.rfind('\n') - 1, problem)


class PlainLoader(yaml.SafeLoader):
    """Loads no Python objects and, as a rule, no aliases: a few of them make a billion values.

    ROS does not load aliases from parameter files either. As there, 2e-3 is a number.
    """

    aliases = False
    _depth = 0

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose one value with all that is in it."""
        event = self.peek_event()
        if isinstance(event, yaml.AliasEvent) and not self.aliases:
            raise _error(f'an alias, *{event.anchor}', event)
        if self._depth >= MOST_LEVELS:
            raise _error(f'more than {MOST_LEVELS} levels', event)
        self._depth += 1
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        """Construct a value; PyYAML lets through whatever that raises, as of 2024-99-99."""
        try:
            return super().construct_object(node, deep)  # type: ignore[no-untyped-call,unused-ignore]
        except yaml.MarkedYAMLError:
            raise
        except Exception as error:
            raise _error(f'{node.value!r:.40} as a value', node) from error


def _error(problem: str, where: Any) -> yaml.MarkedYAMLError:
    """Return an error at an event or a node."""
    return yaml.MarkedYAMLError(problem=problem, problem_mark=where.start_mark)


def _matrix(loader: PlainLoader, node: yaml.MappingNode) -> dict[Any, Any]:
    """Construct a matrix of OpenCV as the mapping that it is."""
    return dict(loader.construct_mapping(node, deep=True))


PlainLoader.add_constructor('tag:yaml.org,2002:opencv-matrix', _matrix)
PlainLoader.add_implicit_resolver(
    'tag:yaml.org,2002:float', re.compile(r'^[-+]?(\.\d+|\d+(\.\d*)?)[eE][-+]?\d+$'),
    list('-+.0123456789'))
