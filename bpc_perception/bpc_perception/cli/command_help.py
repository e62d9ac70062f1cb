"""What each command is for, read from its source: to import all of them takes a second."""

from __future__ import annotations

import ast
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path


def help_of(command: EntryPoint) -> str:
    """Return the help of a command: the docstring of its function, or the help of its group."""
    spec = find_spec(command.module)
    if spec is None or spec.origin is None:
        return ''
    for node in ast.parse(Path(spec.origin).read_text(encoding='utf-8')).body:
        match node:
            case ast.FunctionDef(name=command.attr):
                return ast.get_docstring(node) or ''
            case ast.Assign(targets=[ast.Name(id=command.attr)], value=ast.Call() as call):
                return next((ast.literal_eval(each.value) for each in call.keywords
                             if each.arg == 'help'), '')
    return ''
