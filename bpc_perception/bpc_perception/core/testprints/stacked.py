"""Test prints in layers: a lattice, a line over lines, a wall."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bpc_perception.core.testprints.plan import Part, TestPrint
from bpc_perception.core.testprints.setup import expect, Pattern, Setup

# In diameters of the nozzle:
PITCH, LEAST_PITCH = 4.0, 1.5
SPANS = (5.0, 10.0)  # three lines, as in the draft ASTM WK72274
SUPPORT_LENGTH, WALL_LENGTH = 12.0, 20.0
LEAST_SUPPORT_M, LEAST_WALL_M, LEAST_OVERHANG_M = 8e-3, 20e-3, 2e-3
STRANDS, LAYERS = 5, 10
MOST_STRANDS, MOST_LAYERS, MOST_SPANS = 50, 100, 20


def lattice(setup: Setup, strands: int = STRANDS, pitch: float = np.nan) -> TestPrint:
    """Return two layers of strands that cross at right angles, with pores between.

    Args:
        setup: what it is for.
        strands: in each layer.
        pitch: from strand to strand [m]; NaN = by the nozzle.

    Raises:
        ValueError: a value is out of range, or the lattice does not fit the bed.
    """
    expect_count('--strands', strands, 2, MOST_STRANDS)
    pitch = PITCH * setup.nozzle if np.isnan(pitch) else pitch
    expect('--pitch-mm', pitch, LEAST_PITCH * setup.nozzle, 50 * setup.nozzle)
    places = pitch * np.arange(strands)
    over = max(pitch / 2, LEAST_OVERHANG_M)
    ends = np.array((-over, places[-1] + over))
    pattern = Pattern(setup)
    for layer, axis in ((0, 0), (1, 1)):
        for number, place in enumerate(places):
            stroke = np.empty((2, 2))
            stroke[:, axis], stroke[:, 1 - axis] = ends, place
            pattern.add(stroke, Part.STRAND, layer, distance=pitch if number else np.nan)
    return pattern.finish('lattice')


def line_over_lines(setup: Setup, spans: Sequence[float] = ()) -> TestPrint:
    """Return lines at growing distances, and a line across them, which hangs between.

    After the draft ASTM WK72274, which lays one line across three.

    Args:
        setup: what they are for.
        spans: distances between neighbours [m]; none = by the nozzle.

    Raises:
        ValueError: a span is out of range, or the lines do not fit the bed.
    """
    spans = list(spans) or [share * setup.nozzle for share in SPANS]
    expect_count('--spans-mm', len(spans), 1, MOST_SPANS)
    for span in spans:
        expect('--spans-mm', span, 2 * setup.nozzle, 100 * setup.nozzle)
    half = max(SUPPORT_LENGTH * setup.nozzle, LEAST_SUPPORT_M) / 2
    over = max(3 * setup.nozzle, LEAST_OVERHANG_M)
    places = np.concatenate(([0.0], np.cumsum(spans)))
    pattern = Pattern(setup)
    for place, span in zip(places, (np.nan, *spans), strict=True):
        pattern.add(np.array([(place, -half), (place, half)]), Part.SUPPORT, distance=span)
    pattern.add(np.array([(-over, 0.0), (places[-1] + over, 0.0)]), Part.SPAN, 1)
    return pattern.finish('line-over-lines')


def wall(setup: Setup, layers: int = LAYERS, length: float = np.nan) -> TestPrint:
    """Return strokes on top of each other, to and fro, after the draft ASTM WK72274.

    Args:
        setup: what it is for.
        layers: how many.
        length: of the wall [m]; NaN = by the nozzle.

    Raises:
        ValueError: a value is out of range, or the wall does not fit the bed.
    """
    expect_count('--layers', layers, 2, MOST_LAYERS)
    length = max(WALL_LENGTH * setup.nozzle, LEAST_WALL_M) if np.isnan(length) else length
    expect('--length-mm', length, 10 * setup.nozzle, 2.0)
    pattern = Pattern(setup)
    for layer in range(layers):
        ends = np.array([(0.0, 0.0), (length, 0.0)])
        pattern.add(ends if layer % 2 == 0 else ends[::-1], Part.WALL, layer)
    return pattern.finish('wall')


def expect_count(what: str, found: int, least: int, most: int) -> None:
    """Raise ValueError unless a number is in a range."""
    if not least <= found <= most:
        raise ValueError(f'{what}: expected {least} to {most}, found {found}; choose another')
