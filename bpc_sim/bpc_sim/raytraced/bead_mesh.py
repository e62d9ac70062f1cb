"""Triangles of beads: a section swept along the path, with round ends and corners."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_sim.ink.deposit import Deposit
from bpc_sim.raytraced.section import Section, SUNK_M

RING_STEP_M = 1e-4  # along the path
END_RINGS = 16  # of a round end
DOME_SECTORS = 48  # of the ink on the outside of a corner


@dataclass(frozen=True)
class Mesh:
    """Triangles in the surface frame.

    Attributes:
        vertices: (V, 3) [m].
        faces: (F, 3) of vertices, counter-clockwise from outside.
    """

    vertices: Array
    faces: NDArray[np.uint32]


def bead_meshes(deposit: Deposit, section: Section) -> list[Mesh]:
    """Return a mesh for each run of ink, and one for each of its corners."""
    found = []
    for start, end in deposit.runs.tolist():
        inner = [s for s in deposit.curve.breaks
                 if start < s < end and _is_corner(deposit, s)]
        for first, last in zip([start, *inner], [*inner, end], strict=True):
            found.append(_swept(deposit, section, first, last, first == start, last == end))
        found += [_dome(deposit, section, s) for s in inner]
    return found


def _is_corner(deposit: Deposit, s: float) -> bool:
    before, after = deposit.curve.tangents(np.array((s - 1e-7, s + 1e-7)))
    return float(before @ after) < 0.999


def _swept(deposit: Deposit, section: Section, start: float, end: float, opens: bool,
           closes: bool) -> Mesh:
    """Return the section along the path from start to end [m], with round ends if asked for."""
    tiny = 1e-9 * (end - start)  # at a corner the tangent of this side counts
    s = np.linspace(start + tiny, end - tiny, max(2, round((end - start) / RING_STEP_M) + 1))
    centre, normal = deposit.curve.points(s), deposit.curve.normals(s)
    tangent, width = deposit.curve.tangents(s), deposit.profile(s)
    scale = np.ones(len(s))
    around = np.linspace(0, np.pi / 2, END_RINGS + 1)[1:] * (1 - 1e-6)
    if closes:
        centre = np.concatenate((centre, centre[-1] + np.sin(around)[:, None]
                                 * tangent[-1] * width[-1] / 2))
        normal = np.concatenate((normal, np.tile(normal[-1], (END_RINGS, 1))))
        width, scale = (np.concatenate((width, np.full(END_RINGS, width[-1]))),
                        np.concatenate((scale, np.cos(around))))
    if opens:
        centre = np.concatenate((centre[0] - np.sin(around)[::-1, None]
                                 * tangent[0] * width[0] / 2, centre))
        normal = np.concatenate((np.tile(normal[0], (END_RINGS, 1)), normal))
        width, scale = (np.concatenate((np.full(END_RINGS, width[0]), width)),
                        np.concatenate((np.cos(around)[::-1], scale)))
    # An outline is closed below the bed.
    x = np.concatenate((section.x, section.x[[-1, 0]]))
    z = np.concatenate((section.z, (0.0, 0.0)))
    across = (width * scale)[:, None] * x
    vertices = np.concatenate((
        centre[:, None] - across[..., None] * normal[:, None],
        ((width * scale)[:, None] * z)[..., None]), axis=2)
    vertices[:, -2:, 2] = -SUNK_M
    return Mesh(vertices.reshape(-1, 3), _tube(len(vertices), len(x)))


def _tube(rings: int, around: int) -> NDArray[np.uint32]:
    """Return the faces between rings, and those that close the first and the last."""
    ring, place = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing='ij')
    a, b = ring * around + place, ring * around + (place + 1) % around
    c, d = a + around, b + around
    fan = np.arange(1, around - 1)
    first = np.stack((0 * fan, fan + 1, fan), axis=1)
    last = (rings - 1) * around + first[:, ::-1]
    sides = np.stack((np.stack((a, b, c), axis=-1), np.stack((b, d, c), axis=-1)), axis=-2)
    return np.concatenate((sides.reshape(-1, 3), first, last)).astype(np.uint32)


def _dome(deposit: Deposit, section: Section, s: float) -> Mesh:
    """Return the section turned about the upright at a corner."""
    place = np.array((s,))
    centre, width = deposit.curve.points(place)[0], float(deposit.profile(place)[0])
    half = section.x >= 0
    radius, z = np.append(section.x[half], section.x[half][-1]), np.append(section.z[half], 0.0)
    radius[0] = 1e-6
    angle = np.linspace(0, 2 * np.pi, DOME_SECTORS, endpoint=False)
    vertices = width * np.stack((
        np.cos(angle)[:, None] * radius, np.sin(angle)[:, None] * radius,
        np.broadcast_to(z, (DOME_SECTORS, len(z)))), axis=-1)
    vertices[:, -1, 2] = -SUNK_M
    vertices[..., :2] += centre
    count = len(z)
    sector, ring = np.meshgrid(np.arange(DOME_SECTORS), np.arange(count - 1), indexing='ij')
    a, b = sector * count + ring, (sector + 1) % DOME_SECTORS * count + ring
    sides = np.stack((np.stack((a, a + 1, b), axis=-1), np.stack((b, a + 1, b + 1), axis=-1)),
                     axis=-2)
    return Mesh(vertices.reshape(-1, 3), sides.reshape(-1, 3).astype(np.uint32))
