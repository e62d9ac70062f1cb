"""The meshes that are traced are as wide, as high and as large as their truth says."""

from __future__ import annotations

import numpy as np
import pytest

from bpc_perception.core.arrays import Array
from bpc_sim.ink.curves import Curve, line, meander, polyline
from bpc_sim.ink.deposit import constant_width, Deposit
from bpc_sim.raytraced.bead_mesh import bead_meshes, Mesh
from bpc_sim.raytraced.section import cap, Section, superellipse

MM = 1e-3
WIDTH, LENGTH = 1.5 * MM, 20 * MM
SECTIONS = {'low': superellipse(0.2, 2.0), 'pointed': superellipse(0.35, 1.6),
            'cap_60': cap(np.radians(60)), 'cap_90': cap(np.radians(90)),
            'cap_120': cap(np.radians(120))}


def meshes(section: Section, curve: Curve, gaps: Array | None = None) -> list[Mesh]:
    empty = np.empty((0, 2))
    return bead_meshes(Deposit(curve, constant_width(WIDTH), empty if gaps is None else gaps),
                       section)


def volume(mesh: Mesh) -> float:
    """By the divergence theorem: positive if all faces look outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum('ni,ni->n', a, np.cross(b, c)).sum()) / 6


def is_closed(mesh: Mesh) -> bool:
    """Whether each edge is one of two faces, in opposite directions."""
    edges = np.concatenate([mesh.faces[:, (i, (i + 1) % 3)] for i in range(3)]).astype(int)
    codes = edges[:, 0] * len(mesh.vertices) + edges[:, 1]
    back = edges[:, 1] * len(mesh.vertices) + edges[:, 0]
    return len(np.unique(codes)) == len(codes) and set(codes) == set(back)


@pytest.mark.parametrize('name', list(SECTIONS))
def test_a_section_is_one_width_wide_and_stands_on_the_bed(name: str) -> None:
    section = SECTIONS[name]
    assert np.ptp(section.x) == pytest.approx(1.0, abs=2e-3)  # of a polygon
    assert section.z[[0, -1]] == pytest.approx(0.0, abs=1e-12)
    assert section.z.min() >= -1e-12


@pytest.mark.parametrize('degrees', [40, 60, 90, 110, 120])
def test_a_cap_meets_the_bed_at_its_contact_angle(degrees: float) -> None:
    section = cap(np.radians(degrees))
    rise, out = section.z[1] - section.z[0], section.x[1] - section.x[0]
    step = 2 * degrees / 48  # of the outline
    assert np.degrees(np.arctan2(rise, out)) == pytest.approx(degrees, abs=step)


@pytest.mark.parametrize('name', list(SECTIONS))
def test_a_bead_is_closed_and_as_wide_and_large_as_told(name: str) -> None:
    section = SECTIONS[name]
    [mesh] = meshes(section, line(LENGTH))
    assert is_closed(mesh)
    assert np.ptp(mesh.vertices[:, 1]) == pytest.approx(WIDTH, rel=2e-3)
    assert mesh.vertices[:, 2].max() == pytest.approx(section.height * WIDTH, rel=1e-6)
    # Its ends are round: half a width beyond the path.
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(LENGTH + WIDTH, rel=1e-3)
    foot = section.x[-1] - section.x[0]
    area = -np.trapezoid(section.x, section.z) * WIDTH**2 + foot * WIDTH * 5e-5
    assert volume(mesh) == pytest.approx(area * LENGTH, rel=0.1)
    assert volume(mesh) > area * LENGTH


def test_a_bend_is_one_piece_and_a_corner_has_a_dome() -> None:
    section = SECTIONS['low']
    assert len(meshes(section, meander(5 * MM, 10 * MM, 3))) == 1
    legs = polyline(MM * np.array(((0, 0), (10, 0), (10, 10))))
    found = meshes(section, legs)
    assert len(found) == 3
    dome = found[-1].vertices
    assert np.hypot(*(dome[:, :2] - 10 * MM * np.array((1, 0))).T).max() == pytest.approx(
        WIDTH / 2, rel=1e-3)
    assert volume(found[-1]) > 0


def test_each_run_of_ink_has_its_mesh() -> None:
    found = meshes(SECTIONS['low'], line(LENGTH), MM * np.array(((5, 8), (12, 16))))
    assert len(found) == 3
    assert all(is_closed(mesh) and volume(mesh) > 0 for mesh in found)
