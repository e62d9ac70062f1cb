"""Test prints of one layer: pairs of strands, and turns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.testprints.plan import Part, TestPrint
from bpc_perception.core.testprints.setup import ENDS_M, expect, Pattern, Setup, SPREADING

# In diameters of the nozzle:
DISTANCES = (3.0, 2.5, 2.0, 1.75, 1.5, 1.25, 1.0)
RADII = (1.0, 2.0, 4.0)
LENGTH, LEG = 15.0, 8.0
PAIRS_APART = 4 * SPREADING  # so that only those of a pair are neighbours
SHAPES_APART = 5.0
ANGLES_RAD = tuple(np.radians((60.0, 90.0, 120.0, 150.0)).tolist())
RADIUS_TURN_RAD = np.pi / 2
LEAST_RAD, LARGEST_RAD = np.radians(20), np.radians(170)
LEAST_LENGTH_M, LEAST_LEG_M = 10e-3, 6e-3
ARC_STEP_RAD = np.radians(5)
COLUMNS = 2
MOST_STROKES = 100


def fusion(setup: Setup, distances: Sequence[float] = ()) -> TestPrint:
    """Return pairs of parallel strands, each pair nearer than the one before.

    Args:
        setup: what they are for.
        distances: between the lines of each pair [m]; none = by the nozzle.

    Raises:
        ValueError: a distance is out of range, or the pairs do not fit the bed.
    """
    distances = sorted(distances or [share * setup.nozzle for share in DISTANCES], reverse=True)
    _expect_few('--distances-mm', len(distances))
    length = max(LENGTH * setup.nozzle, LEAST_LENGTH_M) + 2 * ENDS_M
    pattern = Pattern(setup)
    y = 0.0
    for pair, distance in enumerate(distances, 1):
        expect('--distances-mm', distance, setup.nozzle / 2, 10 * setup.nozzle)
        for beside in (np.nan, distance):
            y += np.nan_to_num(beside)
            pattern.add(np.array([(0.0, y), (length, y)]), Part.STRAND, pair=pair,
                        distance=beside)
        y += PAIRS_APART * setup.nozzle
    return pattern.finish('fusion')


def turns(setup: Setup, angles: Sequence[float] = (), radii: Sequence[float] = ()) -> TestPrint:
    """Return strokes that turn once: corners of several angles, arcs of several radii.

    Args:
        setup: what they are for.
        angles: by which corners turn [rad]; none = 60 to 150 degrees.
        radii: of arcs that turn by 90 degrees [m]; none = by the nozzle.

    Raises:
        ValueError: an angle or a radius is out of range, or the strokes do not fit the bed.
    """
    radii = radii or [share * setup.nozzle for share in RADII]
    kinds = [*((angle, 0.0) for angle in sorted(angles or ANGLES_RAD)),
             *((RADIUS_TURN_RAD, radius) for radius in sorted(radii))]
    _expect_few('--angles-deg, --radii-mm', len(kinds))
    for angle, radius in kinds:
        if not LEAST_RAD <= angle <= LARGEST_RAD:
            raise ValueError(f'--angles-deg: expected 20 to 170 degrees, found '
                             f'{np.degrees(angle):g}; 90 turns into a right angle')
        expect('--radii-mm', radius, 0.0, 20 * setup.nozzle)
    leg = max(LEG * setup.nozzle, LEAST_LEG_M)
    shapes = [_turn(angle, radius, leg) for angle, radius in kinds]
    widest = max(float(np.ptp(shape[:, 0])) for shape in shapes)
    pattern = Pattern(setup)
    corner = np.zeros(2)
    for number, (shape, (angle, radius)) in enumerate(zip(shapes, kinds, strict=True)):
        row = shapes[number - number % COLUMNS:][:COLUMNS]
        pattern.add(shape - shape.min(axis=0) + corner, Part.TURN, angle=angle, radius=radius)
        corner[0] += widest + SHAPES_APART * setup.nozzle
        if number % COLUMNS == COLUMNS - 1:
            corner = np.array((0.0, corner[1] + SHAPES_APART * setup.nozzle + max(
                float(np.ptp(each[:, 1])) for each in row)))
    return pattern.finish('turns')


def _turn(angle: float, radius: float, leg: float) -> Array:
    """Return a leg along x, an arc to the left, and another leg, as points (N, 2) [m]."""
    count = max(2, round(angle / ARC_STEP_RAD) + 1) if radius > 0 else 1
    turned = np.linspace(0.0, angle, count)
    arc = radius * np.stack((np.sin(turned), 1 - np.cos(turned)), axis=1)
    return np.vstack(((-leg, 0.0), arc, arc[-1] + leg * np.array((np.cos(angle), np.sin(angle)))))


def _expect_few(what: str, count: int) -> None:
    if count > MOST_STROKES:
        raise ValueError(f'{what}: expected up to {MOST_STROKES}, found {count}'
                         '; leave some out')
