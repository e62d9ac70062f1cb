"""Read a design from a file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bpc_perception.core.design.design import Design, DesignError
from bpc_perception.files.design.extruded_width import ExtrudedWidth
from bpc_perception.files.design.ink_commands import InkCommands
from bpc_perception.files.design.machine import Machine
from bpc_perception.files.design.path_table import design_from_table
from bpc_perception.files.design.slicer_notes import SlicerNotes
from bpc_perception.files.design.words import read_lines

LARGEST_BYTES = 50_000_000
G_CODE = ('.gcode', '.gco', '.g', '.nc', '.ngc', '.cnc', '.tap', '.txt')
TABLE = '.csv'


def read_design(path: str | Path, ink_on: Sequence[str] = (),
                ink_off: Sequence[str] = ()) -> Design:
    """Read a design: G-code, or a table of points (see ``design_from_table``).

    G-code is that of slicers, bioprinters and CNC machines, with arcs in the plane of x and y. Ink
    is laid where E rises in a move, or between commands that mean that on every machine: M760 to
    M763 of CELLINK, M101 and M103. Widths are those that PrusaSlicer, Bambu Studio or Cura tell,
    or that E makes with the settings that Slic3r tells.

    Args:
        path: of the file; its ending tells which it is.
        ink_on: commands of G-code that switch ink on on this machine, such as 'M42 P32 S255'; they
            take the place of all others. 'G1' is such where every G1 lays ink.
        ink_off: those that switch it off, such as 'M42 P32 S0', or 'G0'.

    Raises:
        DesignError: it cannot be read, or not without guessing; the message names file and line.
    """
    path = Path(path)
    try:
        if path.suffix.lower() == TABLE:
            return design_from_table(_text(path))
        return design_from_g_code(_text(path), ink_on, ink_off)
    except DesignError as error:
        raise DesignError(f'{path}: {error}') from None


def design_from_g_code(text: str, ink_on: Sequence[str] = (),
                       ink_off: Sequence[str] = ()) -> Design:
    """Return the design in G-code; see ``read_design``. Raises DesignError."""
    ink = (InkCommands.named(ink_on, ink_off) if ink_on else
           InkCommands.of(command for line in read_lines(text) for command in line.commands))
    machine = Machine(ink, SlicerNotes(text), ExtrudedWidth.of(text))
    for line in read_lines(text):
        machine.follow(line)
    return machine.laid.design()


def _text(path: Path) -> str:
    """Return the text of a file. Raises DesignError."""
    if path.suffix.lower() not in (*G_CODE, TABLE):
        raise DesignError(f'expected a design that ends in {", ".join((*G_CODE, TABLE))}, found '
                          f'{path.suffix or "none of them"}; rename it, or export it as G-code')
    try:
        with path.open('rb') as stream:
            content = stream.read(LARGEST_BYTES + 1)
    except (OSError, ValueError) as error:
        raise DesignError(f'expected a readable design, found: {error}; name another') from error
    if len(content) > LARGEST_BYTES:
        raise DesignError(f'expected at most {LARGEST_BYTES} bytes, found more; is it the right '
                          'file?')
    if content.startswith((b'GCDE', b'PK\x03\x04')):
        raise DesignError('expected text, found a packed file; export it as plain G-code')
    # Commands are ASCII; what comments are written in does not matter.
    return content.decode('utf-8-sig', errors='replace')
