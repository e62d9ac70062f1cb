"""Lines of G-code as commands of words: a letter and a number each.

No parser on PyPI is taken: gcodeparser (MIT) skips what it cannot read instead of refusing it,
and knows neither checksums nor comments in brackets; gcode-lib is GPL; neither interprets arcs.

The form is that of RS274/NGC (NIST IR 6556, section 3.3) and of the RepRap wiki ("G-code"): spaces
and case do not count, comments are in brackets or behind a semicolon, a line may have a number N
and a checksum *.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce
import re

from bpc_perception.files.design.refusals import refusal

WORD = re.compile(r'\s*([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))?\s*')
COMMENT = re.compile(r';.*|\([^()]*\)')
CHECKSUM = re.compile(r'\*\s*(\d+)\s*$')
# Of Klipper, as EXCLUDE_OBJECT_START; the name of a program.
MACRO = re.compile(r'\s*(?:[A-Z_]{4,}\w*(?:\s|$)|O\s*[\d<])', re.I)
# What follows an M is the command's own: numbers, text, names of files. Those that carry text:
TEXT = re.compile(r'M(?:23|28|30|32|36|98|117|118|471|486|55\d|58\d|862(?:\.\d)?|997)$')
HIDDEN = re.compile(r'\sG\d+(?:\.\d)?(?:\s|$)', re.I)
LONGEST_LINE = 1000  # letters, without comments
LARGEST_NUMBER = 1e9
LONGEST_FOUND = 40  # letters of what was found


@dataclass
class Command:
    """A command with its words.

    Attributes:
        code: such as G1, G92.1 or M83; empty = words alone, which go on with the command before.
        words: value of each letter; None = a letter without a number.
        text: the command as written, without spaces, in capitals.
        line: number of its line, from 1.
    """

    code: str
    words: dict[str, float | None]
    text: str
    line: int

    def number(self, letter: str) -> float | None:
        """Return the number behind a letter; None = it is not there. Raises DesignError."""
        if letter not in self.words:
            return None
        value = self.words[letter]
        if value is None or not abs(value) <= LARGEST_NUMBER:
            raise refusal(self.line, f'a number up to {LARGEST_NUMBER:g} behind {letter}',
                          f'{"none" if value is None else value} in {self.text[:LONGEST_FOUND]}',
                          'write it, or send the file anew if it was cut')
        return value


@dataclass
class Line:
    """A line of G-code.

    Attributes:
        number: from 1.
        commands: in order.
        comments: without brackets and semicolon.
    """

    number: int
    commands: tuple[Command, ...]
    comments: tuple[str, ...]


def read_lines(text: str) -> Iterator[Line]:
    """Yield the lines of a file one after another. Raises DesignError at one that is none."""
    for number, raw in enumerate(re.split(r'\r\n|\r|\n', text), 1):
        if len(raw) > LONGEST_LINE and not raw.lstrip().startswith(';'):
            raise refusal(number, f'at most {LONGEST_LINE} letters', f'{len(raw)}',
                          'is it G-code?')
        comments: tuple[str, ...] = ()
        code = raw.strip()
        if ';' in raw or '(' in raw:
            comments = tuple(found.strip(' ;()') for found in COMMENT.findall(raw))
            code = COMMENT.sub(' ', raw).strip()
        yield Line(number, _commands(number, code) if code else (), comments)


def _commands(number: int, code: str) -> tuple[Command, ...]:
    """Return the commands of a line without comments."""
    if code == '%' or MACRO.match(code):  # begin and end of a program, or what moves nothing
        return ()
    groups = _groups(number, _without_checksum(number, code).upper())
    moves = [group.code for group in groups[:-1] if group.code in MOVES or group.code == '']
    if moves:
        raise refusal(number, 'one command that moves, at the end', code[:LONGEST_FOUND],
                      'write each command on a line of its own')
    return tuple(groups)


MOVES = ('G0', 'G1', 'G2', 'G3', 'G7')


def _without_checksum(number: int, code: str) -> str:
    """Return a line without its checksum, which has to be right."""
    found = CHECKSUM.search(code)
    if not found:
        return code
    own = reduce(lambda one, two: one ^ two, code[:found.start()].encode(), 0)
    if int(found[1]) != own:
        raise refusal(number, f'the checksum {own}', found[1],
                      'the line was damaged; send the file anew')
    return code[:found.start()]


def _groups(number: int, code: str) -> list[Command]:
    """Return the words of a line, each command with those that follow it."""
    groups: list[Command] = []
    words: dict[str, float | None] = {}
    name = text = ''
    place = 0
    while place < len(code):
        found = WORD.match(code, place)
        if not found:
            raise refusal(number, 'a letter with a number', repr(code[place:][:LONGEST_FOUND]),
                          'correct it, or make it a comment with ;')
        letter, value = found[1], found[2]
        if letter in 'GMT' and value is not None:
            if text:
                groups.append(Command(name, words, text, number))
            name = text = f'{letter}{float(value):g}'
            words = {}
            if letter == 'M':
                return [*groups, _of_a_machine(number, name, code[place:].strip())]
        elif letter != 'N' or text:
            words[letter] = None if value is None else float(value)
            text += f'{letter}{value or ""}'
        place = found.end()
    return [*groups, Command(name, words, text, number)] if text else groups


def _of_a_machine(number: int, name: str, code: str) -> Command:
    """Return a command M with the rest of its line, which is its own."""
    if not TEXT.match(name) and HIDDEN.search(code):
        raise refusal(number, f'nothing of another command behind {name}', code[:LONGEST_FOUND],
                      'write each command on a line of its own')
    rest = re.sub(r'^M\s*[\d.+-]+', '', code)
    words = {letter: float(value) if value else None for letter, value in WORD.findall(rest)}
    return Command(name, words, name + re.sub(r'\s+', '', rest), number)
