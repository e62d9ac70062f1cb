"""Message types by name."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory


class MessageTypeError(ValueError):
    """A message type is not known here; the message names it."""


@cache
def message_type(type_name: str) -> Any:
    """The Python class of a message type such as ``sensor_msgs/msg/Image``."""
    try:
        package, kind, name = type_name.split('/')
        return getattr(import_module(f'{package}.{kind}'), name)
    except (ValueError, ImportError, AttributeError) as error:
        raise MessageTypeError('message type: expected one that is installed, '
                               f'found {type_name}') from error


@cache
def message_definition(type_name: str) -> str:
    """The text of a message type and of all it uses, as rosbag2 stores it."""
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
                                   f'found {type_name}') from error
        for line in texts[name].splitlines():
            field = line.split('#')[0].split()
            base = field[0].split('[')[0] if len(field) >= 2 else ''
            if '/' in base:
                pending.append(base.replace('/msg/', '/'))
            elif base[:1].isupper():
                pending.append(f'{package}/{base}')
    first, *others = texts
    separator = '=' * 80
    return texts[first] + ''.join(
        f'\n{separator}\nMSG: {name}\n{texts[name]}' for name in others)
