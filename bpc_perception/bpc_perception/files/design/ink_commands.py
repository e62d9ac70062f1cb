"""When a file of G-code pushes ink out: by its axis E, or by commands that switch it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
import re

from bpc_perception.core.design.design import DesignError
from bpc_perception.files.design.refusals import refusal
from bpc_perception.files.design.words import Command, MOVES

# CELLINK INKREDIBLE, "G-CODE COMMANDS" of 2017: valves of printheads 1 and 2. E has no meaning.
VALVES = {'M760': (0, True), 'M761': (0, False), 'M762': (1, True), 'M763': (1, False)}
# RepRap wiki, "M101: Turn extruder 1 on (Forward)" and "M103": before there was an axis E.
OLD_SWITCHES = {'M101': True, 'M103': False}
# CELLINK BIO X: "M750 T0 P30" starts a printhead and "M751 T0" stops it, beside E, which opens
# the valve during a move (G-code guide for the BIO X). Without T they move heads (INKREDIBLE).
BIO_X = {'M750': True, 'M751': False}
# These switch ink on some machines, on others fans, pumps or a spindle.
OF_SOME = ('M3', 'M4', 'M7', 'M8', 'M42', 'M106', 'M126', 'M128')


@dataclass(frozen=True)
class InkCommands:
    """Which commands of a file push ink out.

    Attributes:
        on, off: commands that switch it, as written without spaces; empty = none of its own. What
            starts with one of them counts, such as M42P32S255 for M42P32.
        by_e: whether moves in which E rises push it out.
        by_valve: whether the valves of an INKREDIBLE do.
        by_old_switch: whether M101 and M103 do.
    """

    on: tuple[str, ...] = ()
    off: tuple[str, ...] = ()
    by_e: bool = False
    by_valve: bool = False
    by_old_switch: bool = False

    @classmethod
    def named(cls, on: Sequence[str], off: Sequence[str]) -> InkCommands:
        """Return those that somebody names."""
        switch_on, switch_off = (tuple(re.sub(r'\s+', '', name).upper() for name in names)
                                 for names in (on, off))
        return cls(switch_on, switch_off)

    @classmethod
    def of(cls, commands: Iterable[Command]) -> InkCommands:
        """Return those of a file with these commands.

        Raises DesignError where it has none that mean this on every machine.
        """
        codes, by_e = set(), False
        for command in commands:
            codes.add(command.code)
            by_e |= (('E' in command.words and command.code in ('', *MOVES))
                     or ('T' in command.words and command.code in BIO_X))
        if not codes.isdisjoint(VALVES):
            return cls(by_valve=True)
        if by_e or not codes.isdisjoint(OLD_SWITCHES):
            return cls(by_e=by_e, by_old_switch=not by_e)
        some = [name for name in OF_SOME if name in codes]
        found = f'{", ".join(some)}, which have other uses too' if some else 'neither'
        raise DesignError('expected moves with E, or commands that switch ink as M760 does, found '
                          f'{found}; name the commands that switch ink on and off')


@dataclass
class Switch:
    """Whether ink is switched on, by which tool.

    Attributes:
        commands: that switch it.
        open: the tools that push it out.
    """

    commands: InkCommands
    open: list[int] = field(default_factory=list)

    def follow(self, command: Command, tool: int) -> None:
        """Take in a command, with the tool that is in use."""
        ink, code = self.commands, command.code
        if ink.on and _starts(command, ink.off):
            self._set(tool, False)
        elif ink.on and _starts(command, ink.on):
            self._set(tool, True)
        elif ink.by_valve and code in VALVES:
            self._set(*VALVES[code])
        elif ink.by_old_switch and code in OLD_SWITCHES:
            self._set(tool, OLD_SWITCHES[code])
        elif ink.by_e and code in BIO_X and 'T' in command.words and 'D' not in command.words:
            self._set(int(command.number('T') or 0), BIO_X[code])

    def _set(self, tool: int, on: bool) -> None:
        self.open = [other for other in self.open if other != tool] + [tool] * on


def _starts(command: Command, names: tuple[str, ...]) -> bool:
    """Return whether a command, as written, is one of these or starts with one."""
    return any(re.match(rf'{re.escape(name)}(?![\d.])', command.text) for name in names)


LEAST_STEP = 1e-9  # of E, that pushes ink out


@dataclass
class ExtruderAxis:
    """The axis E as one kind of firmware reads it.

    Attributes:
        heeds_g90: whether G90 and G91 set its mode too. Marlin 2 does so, RepRapFirmware not.
        absolute: its mode.
        value: where it is.
        step: of the last move, in which it went there.
    """

    heeds_g90: bool
    absolute: bool = True
    value: float = 0.0
    step: float = 0.0

    def follow(self, command: Command) -> None:
        """Take in a command that sets mode or value."""
        if command.code in ('M82', 'M83'):
            self.absolute = command.code == 'M82'
        elif command.code in ('G90', 'G91') and self.heeds_g90:
            self.absolute = command.code == 'G90'
        elif command.code == 'G92' and ('E' in command.words or not command.words):
            self.value = command.number('E') or 0.0

    def pushes(self, command: Command) -> bool:
        """Take in a move, and return whether ink is pushed out in it."""
        given = command.number('E')
        if given is None:
            self.step = 0.0
        else:
            self.step = given - self.value if self.absolute else given
        self.value += self.step
        return self.step > LEAST_STEP


@dataclass
class Extruder:
    """The axis E, as far as all firmwares agree on it."""

    readings: list[ExtruderAxis] = field(default_factory=lambda: [
        ExtruderAxis(True), ExtruderAxis(False), ExtruderAxis(False, absolute=False)])

    def follow(self, command: Command) -> None:
        """Take in a command that sets mode or value."""
        for axis in self.readings:
            axis.follow(command)

    @property
    def step(self) -> float:
        """How far E went in the last move; NaN = the file does not say."""
        steps = [axis.step for axis in self.readings]
        return steps[0] if max(steps) - min(steps) < LEAST_STEP else float('nan')

    def pushes(self, command: Command, moves: bool) -> bool:
        """Take in a move, and return whether ink is pushed out in it.

        Raises DesignError where it matters that the file does not say how E is meant.
        """
        found = {axis.pushes(command) for axis in self.readings}
        if moves and len(found) > 1:
            raise refusal(command.line, 'M82 or M83 after the last G90 or G91, before E',
                          f'none: firmwares read {command.text} in two ways', 'add the one meant')
        return found == {True}
