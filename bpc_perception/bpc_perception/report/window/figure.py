"""The window of an ink as a figure for papers."""

from __future__ import annotations

from functools import partial
import math

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import Status
from bpc_perception.core.window.assess import InkWindow
from bpc_perception.core.window.sweep import column, Drive, SweepLine
from bpc_perception.core.window.window import MET
from bpc_perception.display.legend import STATUS_COLOURS, TARGET_COLOUR
from bpc_perception.display.units import MM_PER_M
from bpc_perception.report.publication_figures import save, STYLE
from bpc_perception.report.window.rows import DRIVES, ticks

HEIGHT_MM = 75.0
WINDOW_COLOUR = '#CDE8DD'
FAILED_COLOUR = STATUS_COLOURS[Status.GAP]
TITLES = {Drive.FLOW: 'flow [mm³/s]', Drive.PRESSURE: 'pressure [kPa]'}
MARGIN = 0.04  # of an axis, about the lines
WIDTHS = 7  # curves of equal width


def draw_window(window: InkWindow) -> dict[str, bytes]:
    """Return the figure as files by name: ``window.pdf`` and ``window.svg``."""
    with rc_context(STYLE):  # type: ignore[arg-type,unused-ignore]
        return {f'window.{kind}': data
                for kind, data in save(HEIGHT_MM, partial(draw_map, window=window)).items()}


def draw_map(axes: Axes, window: InkWindow) -> None:
    """Draw window, curves of equal width, lines and the recommended setting."""
    grid, factor = window.grid, DRIVES[window.proven.drive][2]
    handles: list[Artist] = []
    speed, drive = grid.speed * MM_PER_M, grid.drive * factor
    axes.contourf(speed, drive, np.nan_to_num(grid.chance).T, levels=(MET, 1.1),
                  colors=[WINDOW_COLOUR])
    handles.append(Patch(color=WINDOW_COLOUR, label=f'in tolerance, chance ≥ {MET:.0%}'))
    width = np.where(grid.proven, grid.width, np.nan).T * MM_PER_M
    curves = axes.contour(speed, drive, width, levels=WIDTHS, colors='#9A9A9A', linewidths=0.5)
    axes.clabel(curves, fmt='%.3g', fontsize=5)
    axes.contour(speed, drive, width, levels=(window.wanted.width * MM_PER_M,),
                 colors=TARGET_COLOUR, linewidths=1.2)
    handles += axes.plot(*_places(window.proven.good, window), 'o', markersize=3,
                         color='#0072B2', label='line')
    if window.proven.failed:
        handles += axes.plot(*_places(window.proven.failed, window), 'x', markersize=4,
                             color=FAILED_COLOUR, label='line without a width')
    handles += axes.plot(window.speed * MM_PER_M, window.drive * factor, '*', markersize=9,
                         color=TARGET_COLOUR, label='recommended')
    _label(axes, window)
    axes.legend(handles=handles, loc='lower center', bbox_to_anchor=(0.5, 1), ncols=2,
                handlelength=1)


def _places(lines: tuple[SweepLine, ...], window: InkWindow) -> tuple[Array, Array]:
    drive = window.proven.drive
    return (column(lines, 'speed') * MM_PER_M,
            column(lines, drive.value) * DRIVES[drive][2])


def _label(axes: Axes, window: InkWindow) -> None:
    """Label both axes, which are logarithmic, with plain numbers."""
    axes.set_xscale('log')
    axes.set_yscale('log')
    factor = DRIVES[window.proven.drive][2]
    drives, speeds = window.proven.limits
    for axis, (low, high), unit in ((axes.xaxis, speeds, MM_PER_M), (axes.yaxis, drives, factor)):
        margin = (high / low)**MARGIN
        shown = low * unit / margin, high * unit * margin
        (axes.set_xlim if axis is axes.xaxis else axes.set_ylim)(*shown)
        axis.set_major_locator(FixedLocator(ticks(*shown)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f'{value:.3g}'))
        axis.set_minor_locator(NullLocator())
    axes.set_xlabel('speed [mm/s]')
    axes.set_ylabel(TITLES[window.proven.drive])
    target = f'{window.wanted.width * MM_PER_M:.4g} mm ± {100 * window.wanted.tolerance:.3g} %'
    degrees = ('' if math.isnan(window.wanted.temperature)
               else f', {window.wanted.temperature - 273.15:.3g} °C')
    axes.set_title(f'{target}{degrees}', loc='right', fontsize=6, pad=2)
