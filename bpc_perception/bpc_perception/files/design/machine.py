"""Follow the commands of G-code, and keep where ink is laid.

Meanings are those of RS274/NGC (NIST IR 6556) and of Marlin (marlinfw.org/docs/gcode); where
firmwares differ and it matters, the file is refused.
"""

from __future__ import annotations

from itertools import pairwise
import math
import re
from typing import TypeVar

import numpy as np

from bpc_perception.files.design.arcs import Arc, LARGEST_RADIUS_MM
from bpc_perception.files.design.extruded_width import ExtrudedWidth
from bpc_perception.files.design.ink_commands import Extruder, InkCommands, Switch
from bpc_perception.files.design.laid_ink import Known, LaidInk, Point
from bpc_perception.files.design.refusals import refusal
from bpc_perception.files.design.slicer_notes import SlicerNotes
from bpc_perception.files.design.words import Command, Line, MOVES

Kind = TypeVar('Kind')

INCH_MM = 25.4
AXES = 'XYZ'
OF_MOVES = 'XYZEFIJKPRS'  # letters
# They neither move the nozzle where it lays ink, nor change what numbers mean: dwell, retraction,
# cleaning, compensation off, speeds, a bed that is measured or levelled.
HARMLESS = {'G4', 'G8', 'G9', 'G10', 'G11', 'G12', 'G15', 'G17', 'G21', 'G22', 'G23', 'G31',
            'G40', 'G49', 'G50', 'G54', 'G61', 'G64', 'G69', 'G80', 'G91.1', 'G93', 'G94', 'G95',
            'G97', 'G98', 'G99', 'G29.1', 'G29.2', 'G60', 'G392'}
# Where the nozzle is afterwards, the file does not say: homing, parking, probing. As little does
# it behind a command that is not known and names no place.
AWAY = {'G26', 'G27', 'G28', 'G29', 'G30', 'G32', 'G33', 'G34', 'G35', 'G36', 'G38.2', 'G38.3',
        'G39', 'G161', 'G162', 'G380', 'G2814'}
OTHER_PLANES = {'G18', 'G19'}
# They change what numbers mean: offsets of tools and of work, scales, turns, absolute centres.
CHANGING = {'G16', 'G41', 'G42', 'G43', 'G51', 'G53', 'G55', 'G56', 'G57', 'G58', 'G59', 'G68',
            'G90.1', 'G92.1', 'G92.2', 'G92.3'}
TOOL = re.compile(r'T(\d{1,4})$')


class Machine:
    """A machine that follows a file, from a place that is not known.

    Attributes:
        laid: the ink so far.
    """

    def __init__(self, ink: InkCommands, notes: SlicerNotes, extruded: ExtrudedWidth) -> None:
        self.laid = LaidInk()
        self._extruded = extruded
        self._notes = notes
        self._switch = Switch(ink)
        self._extruder = Extruder() if ink.by_e else None
        self._tool = 0
        self._unit = 1.0  # [mm]
        self._absolute = True
        self._move = ''
        self._position: Point = (0.0, 0.0, 0.0)  # [mm]
        self._known: Known = (False, False, False)
        self._origin = [0.0, 0.0, 0.0]  # of the numbers in the file, set by G92 [mm]

    def follow(self, line: Line) -> None:
        """Take in a line. Raises DesignError where it cannot be understood."""
        for comment in line.comments:
            self._notes.follow(comment, line.number)
        for command in line.commands:
            self._switch.follow(command, self._tool)
            if self._extruder is not None:
                self._extruder.follow(command)
            if command.code in ('', *MOVES):
                self._go(command)
            elif command.code[0] == 'T':
                self._take(command)
            elif command.code[0] == 'G':
                self._set(command)

    def _take(self, command: Command) -> None:
        found = TOOL.match(command.code)
        if not found:
            raise refusal(command.line, 'the number of a tool', command.code, 'correct it')
        self._tool = int(found[1])

    def _set(self, command: Command) -> None:
        """Take in a command G that is no move."""
        code = command.code
        if code in ('G90', 'G91'):
            self._absolute = code == 'G90'
        elif code in ('G20', 'G21'):
            self._unit = INCH_MM if code == 'G20' else 1.0
        elif code == 'G92':
            self._name_place(command)
        elif code in OTHER_PLANES:
            raise refusal(command.line, 'arcs in the plane of x and y, G17', code,
                          'write arcs of other planes as lines')
        elif code in CHANGING or (code == 'G10' and 'L' in command.words):
            raise refusal(command.line, 'coordinates that go on as they are', command.text[:40],
                          'write moves without it')
        elif code in AWAY or not (code in HARMLESS or command.words):
            self._leave(command)
        elif code not in HARMLESS:
            raise refusal(command.line, 'a command that is known', command.text[:40],
                          'leave it out if it does not move the nozzle, else write it as moves')

    def _name_place(self, command: Command) -> None:
        """Take in G92: the nozzle stays where it is, and the numbers change."""
        for axis, letter in enumerate(AXES):
            value = command.number(letter)
            if value is None and command.words:
                continue
            named = (value or 0.0) * self._unit
            if self._known[axis]:
                self._origin[axis] = self._position[axis] - named
            else:
                self._position = _with(self._position, axis, self._origin[axis] + named)
                self._known = _with(self._known, axis, True)

    def _leave(self, command: Command) -> None:
        """Take in a command that moves the nozzle who knows where. Homing ends G92."""
        named = [letter in command.words for letter in AXES]
        for axis in range(3):
            if named[axis] or not any(named) or command.code == 'G29':
                self._known = _with(self._known, axis, False)
                if command.code == 'G28':
                    self._origin[axis] = 0.0
        self.laid.stop()

    def _go(self, command: Command) -> None:
        """Take in a move."""
        if not command.code and not (self._move and set(OF_MOVES).issuperset(command.words)):
            raise refusal(command.line, 'a command', command.text[:40],
                          'write G1 before it, or make it a comment with ;')
        code = self._move = command.code or self._move
        end, known = self._end(command, self._absolute and code != 'G7')
        turns = code in ('G2', 'G3')
        moves = turns or end != self._position or known != self._known
        pushes = self._extruder is not None and self._extruder.pushes(command, moves)
        tools = self._switch.open
        if pushes or (tools and moves):
            tool = tools[-1] if tools else self._tool
            way = [self._position, *(self._arc(command, code, end) if turns else [end])]
            self.laid.lay(way, self._known, known, command.line, tool, self._notes.layer,
                          self._width(way, tool))
        elif moves:
            self.laid.stop()
        self._position, self._known = end, known

    def _width(self, way: list[Point], tool: int) -> float:
        """Return the width wanted along a way [m]; NaN = not told."""
        told = self._notes.width(tool)
        if told == told or self._extruder is None or any(point[2] != way[0][2] for point in way):
            return told
        length = sum(math.dist(one, two) for one, two in pairwise(way))
        return self._extruded.at(self._extruder.step, length, way[0][2], tool)

    def _end(self, command: Command, absolute: bool) -> tuple[Point, Known]:
        """Return where a move ends, and which coordinates of it are known."""
        end, known = self._position, self._known
        for axis, letter in enumerate(AXES):
            if letter not in command.words:
                continue
            value = (command.number(letter) or 0.0) * self._unit
            if absolute:
                end = _with(end, axis, self._origin[axis] + value)
                known = _with(known, axis, True)
            else:
                end = _with(end, axis, end[axis] + value)
            if not abs(end[axis]) <= LARGEST_RADIUS_MM:
                raise refusal(command.line, f'coordinates up to {LARGEST_RADIUS_MM:g} mm',
                              command.text[:40], 'correct it')
        return end, known

    def _arc(self, command: Command, code: str, end: Point) -> list[Point]:
        """Return the points of an arc, without the first."""
        if command.number('P') or command.number('K'):
            raise refusal(command.line, 'an arc without P and K', command.text[:40],
                          'write each turn as an arc in the plane of x and y')
        i, j, radius = (None if value is None else value * self._unit
                        for value in map(command.number, 'IJR'))
        arc = Arc(np.array(self._position), np.array(end), code == 'G2', i, j, radius,
                  command.line)
        return [(x, y, z) for x, y, z in arc.points().tolist()]


def _with(values: tuple[Kind, Kind, Kind], axis: int, value: Kind) -> tuple[Kind, Kind, Kind]:
    """Return three values with another one for an axis."""
    one, two, three = values
    return ((value, two, three), (one, value, three), (one, two, value))[axis]
