"""The pores that the beads of a print enclose, and how they differ from those intended.

All of it is done with polygons, so that nothing is lost to pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import shapely

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.printability.bead_union import bead_union, holes, path_union, share_off
from bpc_perception.core.printability.flat_print import FlatPrint, Outline
from bpc_perception.core.printability.uncertainty import draw_side_errors

PERCENT = 100
UNSEEN_SHARE = 1e-3  # of an outline, that may be missing where a strand ends within another
PART_SHARE = 0.5  # of the smaller of two pores, that lies in the other where they are the same
SQUARE = 16  # L^2 / A of a square
# What an outline loses where corners are cut off straight, as a share of what is cut off.
CUT = 1 - 1 / np.sqrt(2)


@dataclass(frozen=True)
class Pore:
    """A pore of a print; NaN = not known.

    Attributes:
        number: from 1.
        layers: those whose strands enclose it, seen from above.
        centre: (3,) in the base frame, in the plane of the path's lowest layer [m].
        area, area_sigma: with its 1-sigma uncertainty [m^2].
        perimeter, perimeter_sigma: [m].
        printability, printability_sigma: Pr = L^2 / (16 A).
        ideal: Pr of the pore that was intended.
        intended_area: of that [m^2]; NaN where no width was wanted.
        intended: how many pores were intended in its place.
        interpolated: share of the outline that is interpolated; NaN where it is not told.
        samples: side points along its outline.
        outline: (K, 3) in the base frame [m].
        note: why something is not known; empty = nothing.
    """

    number: int
    layers: tuple[int, ...]
    centre: Array
    area: float
    area_sigma: float
    perimeter: float
    perimeter_sigma: float
    printability: float
    printability_sigma: float
    ideal: float
    intended_area: float
    intended: int
    interpolated: float
    samples: int
    outline: Array
    note: str

    @property
    def mesh_printability(self) -> float:
        """Actual / intended area [%]."""
        return PERCENT * self.area / self.intended_area

    @property
    def mesh_printability_sigma(self) -> float:
        """Its 1-sigma uncertainty [%]."""
        return PERCENT * self.area_sigma / self.intended_area

    @property
    def size_accuracy(self) -> float:
        """Actual / intended size [%]; size is the square root of the area."""
        return PERCENT * float(np.sqrt(self.area / self.intended_area))

    @property
    def size_accuracy_sigma(self) -> float:
        """Its 1-sigma uncertainty [%]; NaN for a pore that ink closed."""
        share = self.area_sigma / self.area / 2 if self.area > 0 else np.nan
        return self.size_accuracy * share


def shape_factor(area: Array | float, perimeter: Array | float) -> Array:
    """Return Pr = L^2 / (16 A) of areas (...) [m^2] and perimeters (...) [m]."""
    return np.asarray(np.square(perimeter) / (SQUARE * np.asarray(area)))


def find_pores(flat: FlatPrint, wanted: Array | None) -> list[Pore]:
    """Return the pores of each pair of layers, or of the only layer.

    Intended ones that are not there are among them.

    Args:
        flat: the print.
        wanted: (N,) width of the strands that was wanted [m]; None = not known.
    """
    if flat.curved or not np.isfinite(flat.width):
        return []
    layers = np.unique(flat.layer).tolist()
    pairs = list(pairwise(layers)) or [tuple(layers)]
    found: list[Pore] = []
    for pair in pairs:
        found += _pores_of(flat, pair, wanted, len(found) + 1)
    return found


def _pores_of(flat: FlatPrint, layers: tuple[int, ...], wanted: Array | None,
              number: int) -> list[Pore]:
    """Return the pores between the strands of some layers, numbered from ``number`` on."""
    chosen = np.isin(flat.layer, layers)
    inked = chosen & (flat.outline != Outline.BARE)
    narrowest = 2 * float(flat.sigma.mean())
    printed = holes(bead_union(flat, inked), narrowest)
    width = np.full(len(flat.stroke), flat.width) if wanted is None else wanted
    intended = holes(path_union(flat, chosen, width), narrowest)
    known, measured = (bead_union(flat, chosen & (flat.outline <= limit))
                       for limit in (Outline.INTERPOLATED, Outline.MEASURED))
    sigmas = _sigmas(flat, inked, printed)
    pores = []
    for hole, sigma in zip(printed, sigmas, strict=True):
        same = [other for other in intended if _is_same(hole, other)]
        told = share_off(hole.exterior, known) <= UNSEEN_SHARE
        pores.append(_pore(flat, layers, hole, sigma, same, told,
                           share_off(hole.exterior, measured) if told else np.nan,
                           wanted is not None))
    pores += [_missing(flat, layers, other, known, wanted is not None) for other in intended
              if not any(_is_same(hole, other) for hole in printed)]
    return _numbered(flat, pores, number)


def _is_same(one: shapely.Polygon, other: shapely.Polygon) -> bool:
    """Return whether most of the smaller of two pores lies in the other."""
    return bool(one.intersection(other).area > PART_SHARE * min(one.area, other.area))


def _pore(flat: FlatPrint, layers: tuple[int, ...], hole: shapely.Polygon, sigma: Array,
          intended: list[shapely.Polygon], told: bool, interpolated: float,
          with_width: bool) -> Pore:
    """Return a pore that is there."""
    notes = []
    ideal = intended_area = np.nan
    if len(intended) == 1:
        ideal = float(shape_factor(intended[0].area, intended[0].length))
        intended_area = intended[0].area if with_width else np.nan
    else:
        notes.append(f'in the place of {len(intended)} intended ones' if intended else
                     'the lines of the path enclose none there')
    if not told:
        notes.append('its outline is not seen all around')
    elif interpolated > 0:
        notes.append(f'{interpolated:.0%} of its outline are interpolated')
    area, perimeter = (hole.area, hole.length) if told else (np.nan, np.nan)
    sigma = np.hypot(sigma, _round_corners(hole, interpolated)) if told else np.full(3, np.nan)
    return Pore(
        0, layers, _centre(flat, hole), area, float(sigma[0]), perimeter, float(sigma[1]),
        float(shape_factor(area, perimeter)), float(sigma[2]), ideal, intended_area,
        len(intended), interpolated, len(hole.exterior.coords) - 1,
        flat.in_base(np.array(hole.exterior.coords)), '; '.join(notes))


def _round_corners(hole: shapely.Polygon, interpolated: float) -> Array:
    """Return how unsure (3,) area, perimeter and Pr are since corners are not seen.

    What is interpolated is taken to be four corners that are anything from sharp to cut off.
    """
    cut = interpolated * hole.length
    factor = hole.length**2 / (SQUARE * hole.area)
    return np.array((cut**2 / 32, CUT * cut, 2 * CUT * interpolated * factor)) / np.sqrt(12)


def _missing(flat: FlatPrint, layers: tuple[int, ...], intended: shapely.Polygon,
             known: shapely.Geometry, with_width: bool) -> Pore:
    """Return a pore that was intended and is not there: closed, or open to what is around."""
    closed = bool(intended.difference(known).buffer(-float(flat.sigma.mean())).is_empty)
    nan = np.nan
    return Pore(
        0, layers, _centre(flat, intended), 0.0 if closed else nan,
        nan, nan, nan, nan, nan, float(shape_factor(intended.area, intended.length)),
        intended.area if with_width else nan, 1, nan, 0, np.empty((0, 3)),
        'closed by ink' if closed else 'ink does not enclose it')


def _centre(flat: FlatPrint, shape: shapely.Polygon) -> Array:
    return flat.in_base(np.array(shape.centroid.coords))[0]


def _numbered(flat: FlatPrint, pores: list[Pore], number: int) -> list[Pore]:
    """Return pores row by row, along the first stroke, with numbers from ``number`` on."""
    def place(pore: Pore) -> tuple[float, float]:
        x, y = ((pore.centre - flat.origin) @ flat.axes.T / flat.width).tolist()
        return round(y), x

    return [replace(pore, number=number + place_in_order)
            for place_in_order, pore in enumerate(sorted(pores, key=place))]


def _sigmas(flat: FlatPrint, inked: Flags, pores: list[shapely.Polygon]) -> Array:
    """Return the 1-sigma uncertainties (P, 3) of area, perimeter and Pr.

    The sides of the beads are moved by errors by chance, the same each time. NaN for a pore that
    closes or opens then.
    """
    if not pores:
        return np.empty((0, 3))
    inner = [pore.representative_point() for pore in pores]
    drawn = []
    for errors in draw_side_errors(flat.sigma, flat.stroke, flat.spacing):
        found = shapely.STRtree(holes(bead_union(flat, inked, errors), 0.0))
        sizes = np.full((len(pores), 3), np.nan)
        for own, other in found.query(inner, 'within').T.tolist():
            hole = found.geometries[other]
            sizes[own] = hole.area, hole.length, shape_factor(hole.area, hole.length)
        drawn.append(sizes)
    return np.asarray(np.std(drawn, axis=0))
