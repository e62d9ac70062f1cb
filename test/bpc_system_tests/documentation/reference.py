"""All that is generated: tables of the documentation, config/, and the SROS 2 policy.

Run as a program, in a shell with the environment of ``./bpc``, writes all of it anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
import re

from bpc_system_tests.documentation import (
    command_tables,
    message_tables,
    parameter_tables,
    sros2_policy,
)
from bpc_system_tests.documentation.pages import NODE_PAGES, read


def with_table(text: str, marker: str, table: str) -> str:
    """Return the text of a page with the table between a marker and the end made anew."""
    start, end = f'<!-- {marker} -->\n', '<!-- end -->'
    pattern = f'{re.escape(start)}.*?{end}'
    if len(re.findall(pattern, text, re.DOTALL)) != 1:
        raise ValueError(f'expected one table marked {start.strip()}')
    return re.sub(pattern, lambda _: f'{start}{table}{end}', text, flags=re.DOTALL)


def files() -> Iterator[tuple[Path, str]]:
    """Yield every generated file and what it has to contain."""
    for name, tables in parameter_tables.TABLES.items():
        page = NODE_PAGES / f'{name}.md'
        text = read(page)
        for marker, kind in tables.items():
            table = parameter_tables.parameter_table(kind())
            text = with_table(text, f'parameters of {marker}', table)
        yield page, text
    yield command_tables.PAGE, with_table(
        read(command_tables.PAGE), 'options of commands', command_tables.option_tables())
    yield message_tables.PAGE, message_tables.message_page()
    for node, kind in parameter_tables.FILES.items():
        yield parameter_tables.CONFIG / f'{node}.yaml', parameter_tables.parameter_file(
            node, kind())
    yield sros2_policy.FILE, sros2_policy.policy()


if __name__ == '__main__':
    for path, text in files():
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding='utf-8')
