"""Find message types by their names."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory


class MessageTypeError(ValueError):
    """A message type is not installed; the message names it."""


@cache
def message_type(type_name: str) -> Any:
    """Return the Python class of a message type such as ``sensor_msgs/msg/Image``.

    Raises MessageTypeError.
    """
    try:
        package, kind, name = type_name.split('/')
        return getattr(import_module(f'{package}.{kind}'), name)
    except (ValueError, ImportError, AttributeError) as error:
        raise MessageTypeError('message type: expected one that is installed, '
                               f'found {type_name}'
                               '; build its package in this workspace') from error


@cache
def message_definition(type_name: str) -> str:
    """Return the text of a message type and of all types that it uses, as rosbag2 stores it.

    Raises MessageTypeError.
    """
    texts: dict[str, str] = {}
    pending = [type_name.replace('/msg/', '/')]
    while pending:
        name = pending.pop(0)
        if name in texts:
            continue
        try:
            package, short = name.split('/')
            source = Path(get_package_share_directory(package)) / 'msg' / f'{short}.msg'
            texts[name] = source.read_text(encoding='utf-8')
        except (ValueError, LookupError, OSError) as error:
            raise MessageTypeError('message type: expected one that is installed, '
                                   f'found {type_name}'
                                   '; build its package in this workspace') from error
        pending += _used_types(package, texts[name])
    first, *others = texts
    separator = '=' * 80
    return texts[first] + ''.join(
        f'\n{separator}\nMSG: {name}\n{texts[name]}' for name in others)


def _used_types(package: str, text: str) -> list[str]:
    """Return the types, such as ``std_msgs/Header``, of the fields of a message of a package."""
    found = []
    for line in text.splitlines():
        field = line.split('#')[0].split()
        base = field[0].split('[')[0] if len(field) >= 2 else ''
        if '/' in base:
            found.append(base.replace('/msg/', '/'))
        elif base[:1].isupper():
            found.append(f'{package}/{base}')
    return found
