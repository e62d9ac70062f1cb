"""Stress scenes on a plane bed that are hard by the shape of path and ink."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import meander, ring, turtle
from bpc_sim.ink.deposit import Deposit
from bpc_sim.scene.imaging import mix
from bpc_sim.scene.raster import pixel_centres
from bpc_sim.stress.planar_print import (
    along,
    BEAD_WIDTH_M,
    IMAGE_SIZE_PX,
    PIXEL_M,
    PlanarPrint,
    random_imaging,
    seeded,
    spiral,
)
from bpc_sim.stress.stress_scene import StressScene

EDGE_CLEARANCE_M = 0.3e-3  # of free drops and dirt from the bead's edges


def closed_ring(seed: int) -> StressScene:
    """Return a closed circle; its outer contour alone would fill it."""
    return along(ring(18e-3), seeded('ring', seed)).scene('ring')


def frame(seed: int) -> StressScene:
    """Return a closed square of 36 mm with sharp corners, round on the outside."""
    half = 18e-3
    corner = (0.0, np.pi / 2)
    curve = turtle(((half, 0), corner, *(((2 * half, 0), corner) * 3), (half, 0)),
                   (0.0, -half), closed=True)
    printed = along(curve, seeded('frame', seed))
    discs = [(x, y, BEAD_WIDTH_M / 2) for x in (-half, half) for y in (-half, half)]
    return replace(printed, fills=np.array(discs)).scene('frame')


def mesh(seed: int) -> StressScene:
    """Return four strands across four, 8 mm apart: one path that crosses itself 16 times."""
    run, radius = 30e-3, 4e-3
    left, right = (np.pi * radius, np.pi), (np.pi * radius, -np.pi)
    strands = ((run, 0), left, (run, 0), right, (run, 0), left, (run, 0))
    # From the end of the fourth strand, heading -x, three quarters of a circle to the fifth.
    over = (1.5 * np.pi * 3e-3, -1.5 * np.pi)
    curve = turtle((*strands, over, *strands), (-15e-3, -12e-3))
    return along(curve, seeded('mesh', seed)).scene('mesh')


def tight_meander(seed: int) -> StressScene:
    """Return strands that are 0.5 mm apart from edge to edge."""
    return along(meander(BEAD_WIDTH_M + 0.5e-3, 34e-3, 12),
                 seeded('tight_meander', seed)).scene('tight_meander')


def touching_meander(seed: int) -> StressScene:
    """Return strands that touch, except on the 12 mm where the path leads in and out."""
    turn, run, lead = np.pi * BEAD_WIDTH_M / 2, 20e-3, 12e-3
    left, right = (turn, np.pi), (turn, -np.pi)
    between = ((run, 0), right, (run, 0), left)
    curve = turtle(((lead + run, 0), left, *(between * 4), (run, 0), right, (run + lead, 0)),
                   (-run / 2 - lead, -10e-3))
    return along(curve, seeded('touching_meander', seed)).scene('touching_meander')


def figure_eight(seed: int) -> StressScene:
    """Return a closed path that crosses itself once, at a right angle."""
    radius = 9e-3
    loop = 1.5 * np.pi
    straight = (2 * radius, 0.0)
    curve = turtle(((radius * loop / 2, loop / 2), straight, (radius * loop, -loop), straight,
                    (radius * loop / 2, loop / 2)),
                   (-radius * (1 + np.sqrt(2)), 0.0), -np.pi / 2, closed=True)
    return along(curve, seeded('figure_eight', seed)).scene('figure_eight')


def spills(seed: int) -> StressScene:
    """Return drops of ink beside the path and against the bead's side, and specks of dirt.

    Where a drop meets or nearly meets a cross segment, the width has no meaning: EDGE. Dirt
    keeps 0.3 mm away from the bead's edges.
    """
    rng = seeded('spills', seed)
    printed = spiral(rng)
    drops = np.concatenate((_touching_drops(printed, 6), _free_discs(printed, 14, 0.4e-3, 1.5e-3)))
    printed = replace(printed, drops=drops)
    ink, bed = (np.tile(colour, (IMAGE_SIZE_PX * IMAGE_SIZE_PX, 1))
                for colour in (printed.imaging.ink, printed.imaging.bed))
    centres = pixel_centres(IMAGE_SIZE_PX, PIXEL_M)
    for x, y, radius in _free_discs(printed, 60, 0.1e-3, 0.3e-3):
        beyond = np.hypot(centres[:, 0] - x, centres[:, 1] - y) - radius
        share = np.clip(0.5 - beyond / PIXEL_M, 0, 1)
        colour = rng.uniform(20, 230, 3)
        ink, bed = mix(colour, ink, share), mix(colour, bed, share)
    shape = IMAGE_SIZE_PX, IMAGE_SIZE_PX, 3
    return printed.scene('spills', ink=ink.reshape(shape), bed=bed.reshape(shape))


def path_offset(seed: int, tenths: int) -> StressScene:
    """Return a path that lies some tenths of a millimetre beside the bead's middle."""
    name = f'path_offset_{tenths:02}'
    rng = seeded(name, seed)
    return spiral(rng, amplitude=0.0).scene(
        name, path_shift=1e-4 * tenths * float(rng.choice((-1.0, 1.0))))


def gaps_and_ends(seed: int) -> StressScene:
    """Return strands with short gaps, ends that taper over 3 mm, and bulges of 1.6 widths."""
    rng = seeded('gaps_and_ends', seed)
    curve = meander(6e-3, 36e-3, 6)
    gaps = np.array((0.3e-3, 0.5e-3, 1e-3, 2e-3, 0.3e-3, 0.5e-3, 1e-3, 2e-3))
    places = np.linspace(0, curve.length, len(gaps) + 5)[1:-1]
    places = rng.permutation(places + rng.uniform(-4e-3, 4e-3, len(places)))
    bulges, starts = places[:3], places[3:]

    def width(s: Array) -> Array:
        widened = np.zeros(np.shape(s))
        for place in bulges:
            widened += 0.6 * np.cos(np.clip((s - place) / BEAD_WIDTH_M, -1, 1) * np.pi / 2)**2
        tapered = np.clip(np.minimum(s, curve.length - s) / 3e-3, 0, 1)
        return np.asarray(BEAD_WIDTH_M * np.where(tapered < 1, tapered, 1 + widened))

    intervals = np.stack((starts, starts + gaps), axis=1)
    deposit = Deposit(curve, width, intervals)
    return PlanarPrint(deposit, random_imaging(rng), rng).scene('gaps_and_ends')


def _touching_drops(printed: PlanarPrint, count: int) -> Array:
    """Return drops (count, 3) [m] that stick out of the bead's side by most of their size."""
    rng, deposit = printed.rng, printed.deposit
    s = rng.choice(deposit.curve.uniform(1000)[50:-50], 10 * count, replace=False)
    s = s[deposit.inked(s)][:count]
    radius = rng.uniform(0.5e-3, 1.2e-3, count)
    beside = rng.choice((-1.0, 1.0), count) * (deposit.width(s) / 2
                                               + rng.uniform(0.2, 0.8, count) * radius)
    return np.column_stack((
        deposit.curve.points(s) + beside[:, None] * deposit.curve.normals(s), radius))


def _free_discs(printed: PlanarPrint, count: int, smallest: float, largest: float) -> Array:
    """Return discs (count, 3) [m] on bare bed or on ink, 0.3 mm or more from every edge."""
    half = IMAGE_SIZE_PX * PIXEL_M / 2
    centres = printed.rng.uniform(-half, half, (50 * count, 2))
    radius = printed.rng.uniform(smallest, largest, len(centres))
    fitting = np.abs(printed.margin(centres)) >= radius + EDGE_CLEARANCE_M
    return np.column_stack((centres, radius))[fitting][:count]
