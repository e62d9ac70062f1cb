"""The page of the messages, made from the comments in their definitions."""

from __future__ import annotations

from dataclasses import dataclass, field
import re
import textwrap

from bpc_system_tests.documentation.pages import DOCS, ROOT

PAGE = DOCS / 'reference' / 'messages.md'
LINE_LENGTH = 120
FILES = sorted((ROOT / 'bpc_interfaces' / 'msg').glob('*.msg'))
HEADER = """# Messages

Made by `python test/bpc_system_tests/documentation/reference.py` from the files in
`bpc_interfaces/msg`. NaN stands for what is not known, never 0.
"""


@dataclass
class Group:
    """Lines of a definition that share the comment above them."""

    comment: list[str] = field(default_factory=list)
    declarations: list[str] = field(default_factory=list)


def groups(text: str) -> list[Group]:
    """Return the groups of a definition; a group ends with an empty line or a new comment."""
    found = [Group()]
    for line in text.splitlines():
        if not line.strip() or (line.startswith('#') and found[-1].declarations):
            found.append(Group())
        if line.startswith('#'):
            found[-1].comment.append(line.lstrip('#').strip())
        elif line.strip():
            found[-1].declarations.append(line.strip())
    return [group for group in found if group.comment or group.declarations]


def message_page() -> str:
    """Return the content of the page."""
    return '\n'.join((HEADER, *(_section(file.stem, groups(file.read_text('utf-8')))
                                for file in FILES)))


def _section(name: str, parts: list[Group]) -> str:
    about, *parts = parts
    constants = [part for part in parts if '=' in part.declarations[0]]
    fields = [part for part in parts if part not in constants]
    paragraphs = [textwrap.fill(paragraph, LINE_LENGTH)
                  for paragraph in '\n'.join(about.comment).strip().split('\n\n')]
    lines = [f'## {name}', '', f'File: [{name}.msg](../../bpc_interfaces/msg/{name}.msg)', '',
             '\n\n'.join(paragraphs), '']
    if constants:
        lines += [constants[0].comment.pop(0), '',
                  '| constant | value | meaning |', '|---|---|---|',
                  *map(_constants, constants), '']
    lines += ['| field | type | meaning |', '|---|---|---|', *map(_fields, fields), '']
    return '\n'.join(lines)


def _constants(group: Group) -> str:
    names, values = zip(*(re.findall(r'(\w+) *= *(\S+)', each)[0] for each in group.declarations),
                        strict=True)
    return (f'| {", ".join(f"`{name}`" for name in names)} | {", ".join(values)} '
            f'| {" ".join(group.comment)} |')


def _fields(group: Group) -> str:
    kinds, names = zip(*(each.split() for each in group.declarations), strict=True)
    return (f'| {", ".join(f"`{name}`" for name in names)} | {", ".join(dict.fromkeys(kinds))} '
            f'| {" ".join(group.comment)} |')
