"""Figures for papers: PDF and SVG, sizes in millimetres, fonts embedded.

The same result gives the same file, byte by byte: no dates, no random names.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from io import BytesIO
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.result import Result
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.layers import layers_of
from bpc_perception.display.legend import (
    as_shown,
    FULL_COLOUR_DEVIATION,
    HEIGHT_COLOUR,
    LEFT_COLOUR,
    ON_TARGET_COLOUR,
    RIGHT_COLOUR,
    STATUS_COLOURS,
    TARGET_COLOUR,
    TOO_THICK_COLOUR,
    TOO_THIN_COLOUR,
)
from bpc_perception.display.overlay import (
    path_pixels,
    pixel_size,
    scale_bar_length,
    SCALE_BAR_SHARE,
)
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.wording import label
from bpc_perception.report.figures.data import offset_range, on_map, pen_up, thickness_ceiling
from bpc_perception.report.uniformity import reference

MM_PER_INCH = 25.4
COLUMN_WIDTH_MM = 85.0
LEGEND_HEIGHT_MM = 6  # below the image
BIN_COUNT = 40
PERCENT = 100
MEASURED_COLOUR = STATUS_COLOURS[Status.MEASURED]
# Fonts as TrueType in PDF, as journals ask for, and as outlines in SVG, which then needs none.
STYLE: dict[str, Any] = {
    'pdf.fonttype': 42, 'svg.fonttype': 'path', 'svg.hashsalt': 'bpc', 'font.size': 7,
    'font.family': 'sans-serif', 'font.sans-serif': ['DejaVu Sans'], 'axes.linewidth': 0.5,
    'lines.linewidth': 0.8, 'xtick.major.width': 0.5, 'ytick.major.width': 0.5,
    'legend.frameon': False, 'axes.spines.top': False, 'axes.spines.right': False,
    'figure.constrained_layout.use': True, 'image.interpolation': 'none', 'savefig.dpi': 300}
# Metadata by format: without dates.
FORMATS: dict[str, dict[str, Any]] = {'pdf': {'CreationDate': None}, 'svg': {'Date': None}}


def draw_figures(result: Result, targets: WidthTargets | None) -> dict[str, bytes]:
    """Draw overlay, thickness, offset, map and histogram of a measured result.

    Returns:
        Files by name, each figure in each of FORMATS; of a print in layers, an overlay and a map
        of each.
    """
    profile = result.profile
    assert profile is not None
    camera = result.capture.camera
    image_height_mm = COLUMN_WIDTH_MM * camera.height / camera.width
    # The height [mm], and what draws into the axes.
    figures: dict[str, tuple[float, Callable[[Axes], None]]] = {
        'thickness': (50.0, lambda axes: draw_thickness(axes, profile, targets)),
        'offset': (40.0, lambda axes: draw_offset(axes, profile)),
        'histogram': (50.0, lambda axes: draw_histogram(axes, profile, targets))}
    layers = layers_of(profile)
    for layer, own in layers:
        name = f'_layer_{layer}' if len(layers) > 1 else ''
        figures[f'overlay{name}'] = (image_height_mm + LEGEND_HEIGHT_MM,
                                     partial(draw_overlay, result=result, own=own))
        figures[f'map{name}'] = 70.0, partial(draw_map, profile=profile, targets=targets, own=own)
    with rc_context(STYLE):  # type: ignore[arg-type,unused-ignore]
        return {f'{name}.{kind}': data for name, (height_mm, draw) in figures.items()
                for kind, data in save(height_mm, draw).items()}


def save(height_mm: float, draw: Callable[[Axes], None]) -> dict[str, bytes]:
    """Return a figure of this height, which a function draws, as files in all formats."""
    figure = Figure((COLUMN_WIDTH_MM / MM_PER_INCH, height_mm / MM_PER_INCH))
    FigureCanvasAgg(figure)
    draw(figure.add_subplot())
    files = {}
    for kind, metadata in FORMATS.items():
        buffer = BytesIO()
        figure.savefig(buffer, format=kind, metadata=metadata)
        files[kind] = buffer.getvalue()
    return files


def draw_overlay(axes: Axes, result: Result, own: Flags) -> None:
    """Draw the image with side points of some samples (N,), their statuses, and a scale bar."""
    profile, camera = result.profile, result.capture.camera
    assert profile is not None
    axes.imshow(result.capture.image)
    profile = as_shown(profile)
    for status in Status:
        if status != Status.MEASURED:
            _draw_runs(axes, path_pixels(result, profile.feet),
                       own & (profile.status == status), STATUS_COLOURS[status], label(status))
    measured = own & (profile.status == Status.MEASURED)
    _draw_runs(axes, path_pixels(result, profile.left_points), measured, LEFT_COLOUR, 'left side')
    _draw_runs(axes, path_pixels(result, profile.right_points), measured, RIGHT_COLOUR,
               'right side')
    _draw_scale_bar(axes, pixel_size(result), camera.width, camera.height)
    axes.set_xlim(-0.5, camera.width - 0.5)
    axes.set_ylim(camera.height - 0.5, -0.5)
    axes.set_axis_off()
    _add_legend(axes, loc='upper center', bbox_to_anchor=(0.5, 0), ncols=4, handlelength=1)


def _draw_scale_bar(axes: Axes, pixel: float, width: int, height: int) -> None:
    """Draw a length at the bottom of an image whose pixels have this size [m]."""
    if not pixel > 0:  # the path is not in front of the camera
        return
    length = scale_bar_length(SCALE_BAR_SHARE * width * pixel)
    left, bottom = 0.03 * width, 0.95 * height
    axes.plot((left, left + length / pixel), (bottom, bottom), color=TARGET_COLOUR, linewidth=2,
              solid_capstyle='butt')
    axes.text(left, bottom - 0.02 * height, f'{length * MM_PER_M:g} mm', color=TARGET_COLOUR)


def _add_legend(axes: Axes, **look: Any) -> None:
    """Add a legend, unless it would be empty."""
    if axes.get_legend_handles_labels()[1]:
        axes.legend(**look)


def _draw_runs(axes: Axes, places: Array, chosen: NDArray[np.bool_], colour: str,
               name: str) -> None:
    """Draw a line through the places (N, 2) that are chosen (N,), if any is."""
    if chosen.any():
        axes.plot(*pen_up(places, chosen).T, color=colour, label=name)


def draw_thickness(axes: Axes, profile: ThicknessProfile, targets: WidthTargets | None) -> None:
    """Draw thickness over arc length with one standard deviation, height, and the target."""
    arc, thickness, sigma = (values * MM_PER_M for values in (
        profile.arc_length, profile.thickness, profile.sigma))
    _shade_statuses(axes, profile)
    axes.fill_between(arc, thickness - sigma, thickness + sigma, color=MEASURED_COLOUR, alpha=0.3,
                      linewidth=0, label='± 1 sigma')
    axes.plot(arc, np.where(profile.status == Status.MEASURED, thickness, np.nan),
              color=MEASURED_COLOUR, label='thickness')
    if np.isfinite(profile.height_sigma).any():
        axes.plot(arc, np.where(np.isfinite(profile.height_sigma), profile.height, np.nan)
                  * MM_PER_M, color=HEIGHT_COLOUR, label='height')
    if targets is not None:
        axes.plot(arc, targets.at(profile.arc_length) * MM_PER_M, color=TARGET_COLOUR,
                  linestyle='--', label='target')
    axes.set_xlabel('arc length [mm]')
    axes.set_ylabel('thickness, height [mm]')
    axes.set_ylim(0, thickness_ceiling(profile, targets))
    axes.margins(x=0)
    _add_legend(axes, loc='lower left', ncols=3, handlelength=1)


def draw_offset(axes: Axes, profile: ThicknessProfile) -> None:
    """Draw how far the middle of the deposit lies to the left of the path, over arc length."""
    _shade_statuses(axes, profile)
    axes.axhline(0, color=TARGET_COLOUR, linewidth=0.5)
    axes.plot(profile.arc_length * MM_PER_M, (profile.left - profile.right) / 2 * MM_PER_M,
              color=MEASURED_COLOUR)
    axes.set_xlabel('arc length [mm]')
    axes.set_ylabel('left of the path [mm]')
    axes.set_ylim(*offset_range(profile))
    axes.margins(x=0)


def _shade_statuses(axes: Axes, profile: ThicknessProfile) -> None:
    """Shade the stretches without a thickness by status."""
    profile = as_shown(profile)
    for status in Status:
        if status != Status.MEASURED:
            for index, (start, end) in enumerate(profile.extents(status) * MM_PER_M):
                axes.axvspan(start, end, color=STATUS_COLOURS[status], alpha=0.25, linewidth=0,
                             label=label(status) if index == 0 else None)


def draw_map(axes: Axes, profile: ThicknessProfile, targets: WidthTargets | None,
             own: Flags) -> None:
    """Draw samples (N,) along the z axis of the base frame, coloured by their deviation."""
    ribbon = _ribbon(profile, targets, own)
    axes.add_collection(ribbon)
    drawn = own & on_map(profile)
    for status in Status:
        if status != Status.MEASURED:
            _draw_runs(axes, profile.points[:, :2] * MM_PER_M,
                       drawn & (profile.status == status), STATUS_COLOURS[status], label(status))
    axes.autoscale_view()
    axes.set_aspect('equal')
    axes.set_xlabel('x [mm]')
    axes.set_ylabel('y [mm]')
    figure = axes.get_figure()
    assert figure is not None
    bar = figure.colorbar(ribbon, ax=axes, shrink=0.8,
                          label=f'off the {"median" if targets is None else "target"} [%]')
    assert bar.solids is not None
    bar.solids.set(rasterized=False, edgecolor='face')


def _ribbon(profile: ThicknessProfile, targets: WidthTargets | None,
            own: Flags) -> PolyCollection:
    """Return a polygon from each sample (N,) chosen to the next where both are measured."""
    measured = own & (profile.status == Status.MEASURED)
    stroke = profile.stroke
    starts = np.flatnonzero(measured[:-1] & measured[1:] & (stroke[:-1] == stroke[1:]))
    left = profile.left_points[:, :2] * MM_PER_M
    right = profile.right_points[:, :2] * MM_PER_M
    corners = np.stack((left[starts], right[starts], right[starts + 1], left[starts + 1]), axis=1)
    deviation = PERCENT * (profile.thickness / reference(profile, targets) - 1)
    colours = LinearSegmentedColormap.from_list(
        'bpc', (TOO_THIN_COLOUR, ON_TARGET_COLOUR, TOO_THICK_COLOUR))
    # Give edges the same colour: otherwise a viewer shows the paper between neighbours.
    ribbon = PolyCollection(list(corners), cmap=colours, linewidths=0.2, edgecolors='face')
    ribbon.set_array(deviation[starts])
    ribbon.set_clim(-PERCENT * FULL_COLOUR_DEVIATION, PERCENT * FULL_COLOUR_DEVIATION)
    return ribbon


def draw_histogram(axes: Axes, profile: ThicknessProfile, targets: WidthTargets | None) -> None:
    """Draw how often each thickness was measured, and the quartiles."""
    summary = profile.summary
    axes.hist(profile.thickness[profile.status == Status.MEASURED] * MM_PER_M, bins=BIN_COUNT,
              color=MEASURED_COLOUR, alpha=0.6)
    for name, value, style in (('Q1', summary.thickness_q1, ':'),
                               ('Q2', summary.thickness_median, '-'),
                               ('Q3', summary.thickness_q3, ':')):
        if np.isfinite(value):
            axes.axvline(value * MM_PER_M, color=TARGET_COLOUR, linestyle=style,
                         label=f'{name} {value * MM_PER_M:.3f}')
    if targets is not None and np.ptp(targets.thickness) == 0:
        axes.axvline(targets.thickness[0] * MM_PER_M, color=TARGET_COLOUR, linestyle='--',
                     label='target')
    axes.set_xlabel('thickness [mm]')
    axes.set_ylabel('samples')
    _add_legend(axes, loc='lower center', bbox_to_anchor=(0.5, 1), ncols=4, handlelength=1.5)
