"""The figure of the pores of a print: coloured by their shape, over the beads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
import numpy as np

from bpc_perception.core.arrays import Flags
from bpc_perception.core.printability.assess import Printability
from bpc_perception.core.printability.flat_print import FlatPrint, Outline
from bpc_perception.core.printability.pores import Pore
from bpc_perception.display.legend import (
    ON_TARGET_COLOUR,
    TARGET_COLOUR,
    TOO_THICK_COLOUR,
    TOO_THIN_COLOUR,
)
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.publication_figures import save, STYLE

HEIGHT_MM = 75.0
# Of beads, by what is known of their outline.
COLOURS = {Outline.MEASURED: '#CCCCCC', Outline.INTERPOLATED: '#56B4E9',
           Outline.UNKNOWN: '#F0E442'}
LEAST_RANGE = 0.05  # of Pr to either side of 1
NUMBERED = 100  # pores, up to which each has its number


def draw_pores(found: Printability) -> dict[str, bytes]:
    """Draw the pores of each pair of layers.

    Returns:
        Files by name, as ``pores.pdf``, or ``pores_layers_0_1.pdf`` where there are several pairs.
    """
    groups = sorted({pore.layers for pore in found.pores}) or [
        tuple(np.unique(found.flat.layer).tolist())]
    files: dict[str, bytes] = {}
    with rc_context(STYLE):  # type: ignore[arg-type,unused-ignore]
        for layers in groups:
            name = 'pores' if len(groups) == 1 else f'pores_layers_{"_".join(map(str, layers))}'
            draw: Callable[[Axes], None] = partial(
                draw_map, flat=found.flat, chosen=np.isin(found.flat.layer, layers),
                pores=[pore for pore in found.pores if pore.layers == layers])
            files |= {f'{name}.{kind}': data for kind, data in save(HEIGHT_MM, draw).items()}
    return files


def draw_map(axes: Axes, flat: FlatPrint, chosen: Flags, pores: Sequence[Pore]) -> None:
    """Draw beads of chosen samples (N,) and pores in the plane of the print."""
    for outline, colour in COLOURS.items():
        own = chosen & (flat.outline == outline)
        if own.any():
            axes.add_collection(_beads(flat, own, colour, outline.name.lower()))
    shapes = [(pore.outline - flat.origin) @ flat.axes.T * MM_PER_M for pore in pores
              if len(pore.outline)]
    values = np.array([pore.printability for pore in pores if len(pore.outline)])
    reach = max(LEAST_RANGE, float(np.nanmax(np.abs(values - 1), initial=0.0)))
    colours = LinearSegmentedColormap.from_list(
        'bpc', (TOO_THIN_COLOUR, ON_TARGET_COLOUR, TOO_THICK_COLOUR)).with_extremes(bad='white')
    drawn = PolyCollection(shapes, cmap=colours, edgecolors=TARGET_COLOUR, linewidths=0.4)
    drawn.set_array(np.ma.masked_invalid(values))
    drawn.set_clim(1 - reach, 1 + reach)
    axes.add_collection(drawn)
    for pore in pores if len(pores) <= NUMBERED else ():
        x, y = ((pore.centre - flat.origin) @ flat.axes.T * MM_PER_M).tolist()
        value = f'\n{pore.printability:.3f}' if np.isfinite(pore.printability) else ''
        axes.text(x, y, f'{pore.number}{value}', ha='center', va='center', fontsize=5)
    axes.autoscale_view()
    axes.set_aspect('equal')
    axes.set_xlabel('along the first stroke [mm]')
    axes.set_ylabel('across [mm]')
    axes.legend(loc='lower center', bbox_to_anchor=(0.5, 1), ncols=3, handlelength=1)
    figure = axes.get_figure()
    assert figure is not None
    bar = figure.colorbar(drawn, ax=axes, shrink=0.8, label='Pr = L² / (16 A)')
    assert bar.solids is not None
    bar.solids.set(rasterized=False, edgecolor='face')


def _beads(flat: FlatPrint, chosen: Flags, colour: str, name: str) -> PolyCollection:
    """Return what the side points of neighbours span where one is chosen (N,) and none is bare."""
    left, right = (side * MM_PER_M for side in flat.sides())
    inked = flat.outline != Outline.BARE
    start = np.flatnonzero((chosen[:-1] | chosen[1:]) & inked[:-1] & inked[1:]
                           & (flat.stroke[:-1] == flat.stroke[1:]))
    corners = np.stack((left[start], right[start], right[start + 1], left[start + 1]), axis=1)
    return PolyCollection(list(corners), facecolors=colour, edgecolors=colour, linewidths=0.2,
                          label=name)
