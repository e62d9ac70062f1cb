"""A reader under test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

Run = Callable[[bytes], object]


@dataclass(frozen=True)
class Target:
    """A reader under test, which gets spoiled copies of its seeds.

    Attributes:
        seeds: good inputs.
        run: reads one input.
        refused: the errors that the reader documents; it may raise no others.
        text: whether inputs are text, and spoiled by words rather than by bytes.
        cost: about how much longer an input takes than with the fastest target.
    """

    seeds: list[bytes]
    run: Run
    refused: tuple[type[Exception], ...]
    text: bool = False
    cost: int = 1


def by_file(file: Path, read: Callable[[Path], object]) -> Run:
    """Return a reader of files as a reader of bytes."""
    def run(data: bytes) -> object:
        file.write_bytes(data)
        return read(file)
    return run
