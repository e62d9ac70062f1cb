"""What every refusal has to say: what was expected, what was found, and what to do."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import bpc_perception

SOURCE = Path(bpc_perception.__file__).parent
# What is refused to the user of a command, or to who looks after a rig. The errors of values
# (core.parameter, core.config) name the values that may be given.
ROOMS = ('batch', 'cli', 'core/calibration', 'core/capture', 'core/design', 'core/measurement',
         'core/path', 'core/robot', 'core/window', 'drivers', 'files', 'messages', 'page',
         'recording', 'report')
TELLING = ('expected one of', 'TOPIC:=OTHER', 'as in the camera info', 'region: ',
           'reasons', 'refusals', 'choose')  # such are within
# What these say is within a line of others, who know where it comes from.
INNER = ('recording/storage/mcap_file.py', 'files/yaml_file.py', 'core/robot/poses.py')


def refusals() -> Iterator[tuple[str, str]]:
    """Place and text of each error that says what was expected and found."""
    for room in ROOMS:
        for file in sorted((SOURCE / room).rglob('*.py')):
            name = str(file.relative_to(SOURCE))
            for node in ast.walk(ast.parse(file.read_text('utf-8'))):
                if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
                    text = ast.unparse(node.exc)
                    if 'expected' in text and 'found' in text and name not in INNER:
                        yield f'{name}:{node.lineno}', text


FOUND = dict(refusals())


def test_there_are_refusals() -> None:
    assert len(FOUND) > 120


@pytest.mark.parametrize('place', FOUND)
def test_every_refusal_says_what_to_do(place: str) -> None:
    text = FOUND[place]
    assert '; ' in text or ': turn' in text or any(words in text for words in TELLING), text
