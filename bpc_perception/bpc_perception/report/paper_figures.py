"""Figures for papers: PDF and SVG, sizes in millimetres, letters of their own fonts inside.

The same file for the same result, byte by byte: no dates, no random names.
"""

from __future__ import annotations

from collections.abc import Callable
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

from bpc_perception.core.advice.targets import WidthTargets
from bpc_perception.core.arrays import Array
from bpc_perception.core.profile import run_extents, Status, ThicknessProfile
from bpc_perception.core.session import Result
from bpc_perception.display.legend import COLOURS, FULL, LEFT, RIGHT, RIGHT_ON, TARGET, THICK, THIN
from bpc_perception.display.overlay import LENGTHS, path_pixels, pixel_size
from bpc_perception.display.wording import label
from bpc_perception.report.figures import ceiling, offset_range, pen_up
from bpc_perception.report.uniformity import reference

MM = 1e3  # [mm/m]
INCH = 25.4  # [mm]
WIDTH = 85.0  # of a column [mm]
# Fonts as TrueType in PDF, which journals ask for, and as outlines in SVG, which needs none then.
STYLE: dict[str, Any] = {
    'pdf.fonttype': 42, 'svg.fonttype': 'path', 'svg.hashsalt': 'bpc', 'font.size': 7,
    'font.family': 'sans-serif', 'font.sans-serif': ['DejaVu Sans'], 'axes.linewidth': 0.5,
    'lines.linewidth': 0.8, 'xtick.major.width': 0.5, 'ytick.major.width': 0.5,
    'legend.frameon': False, 'axes.spines.top': False, 'axes.spines.right': False,
    'figure.constrained_layout.use': True, 'image.interpolation': 'none', 'savefig.dpi': 300}
KINDS: dict[str, dict[str, Any]] = {
    'pdf': {'CreationDate': None}, 'svg': {'Date': None}}


def draw_figures(result: Result, targets: WidthTargets | None) -> dict[str, bytes]:
    """Files by name: overlay, thickness, offset, map and histogram of a measured result."""
    profile = result.profile
    assert profile is not None
    camera = result.capture.camera
    figures: dict[str, tuple[float, Callable[[Axes], None]]] = {
        'overlay': (WIDTH * camera.height / camera.width + 6, lambda axes: overlay(axes, result)),
        'thickness': (50.0, lambda axes: thickness(axes, profile, targets)),
        'offset': (40.0, lambda axes: offset(axes, profile)),
        'map': (70.0, lambda axes: plan(axes, profile, targets)),
        'histogram': (50.0, lambda axes: histogram(axes, profile, targets))}
    with rc_context(STYLE):  # type: ignore[arg-type,unused-ignore]
        return {f'{name}.{kind}': data for name, (height, draw) in figures.items()
                for kind, data in _save(height, draw).items()}


def _save(height: float, draw: Callable[[Axes], None]) -> dict[str, bytes]:
    """One figure of this height [mm] as files of all kinds."""
    figure = Figure((WIDTH / INCH, height / INCH))
    FigureCanvasAgg(figure)
    draw(figure.add_subplot())
    files = {}
    for kind, metadata in KINDS.items():
        buffer = BytesIO()
        figure.savefig(buffer, format=kind, metadata=metadata)
        files[kind] = buffer.getvalue()
    return files


def overlay(axes: Axes, result: Result) -> None:
    """The image with side points and what was not measured, and a scale bar."""
    profile, camera = result.profile, result.capture.camera
    assert profile is not None
    axes.imshow(result.capture.image)
    for status in Status:
        if status != Status.MEASURED:
            _run(axes, path_pixels(result, profile.points), profile.status == status,
                 COLOURS[status], label(status))
    measured = profile.status == Status.MEASURED
    _run(axes, path_pixels(result, profile.left_points), measured, LEFT, 'left side')
    _run(axes, path_pixels(result, profile.right_points), measured, RIGHT, 'right side')
    _scale_bar(axes, pixel_size(result), camera.width, camera.height)
    axes.set_xlim(-0.5, camera.width - 0.5)
    axes.set_ylim(camera.height - 0.5, -0.5)
    axes.set_axis_off()
    _legend(axes, loc='upper center', bbox_to_anchor=(0.5, 0), ncols=4, handlelength=1)


def _scale_bar(axes: Axes, pixel: float, width: int, height: int) -> None:
    """A length at the bottom of an image, whose pixels have this size [m]."""
    if not pixel > 0:  # the path is not in front of the camera
        return
    length = max((each for each in LENGTHS if each <= 0.2 * width * pixel), default=LENGTHS[0])
    left, bottom = 0.03 * width, 0.95 * height
    axes.plot((left, left + length / pixel), (bottom, bottom), color=TARGET, linewidth=2,
              solid_capstyle='butt')
    axes.text(left, bottom - 0.02 * height, f'{length * MM:g} mm', color=TARGET)


def _legend(axes: Axes, **look: Any) -> None:
    """A legend, if there is anything to tell."""
    if axes.get_legend_handles_labels()[1]:
        axes.legend(**look)


def _run(axes: Axes, uv: Array, chosen: NDArray[np.bool_], colour: str, name: str) -> None:
    if chosen.any():
        axes.plot(*pen_up(uv, chosen).T, color=colour, label=name)


def thickness(axes: Axes, profile: ThicknessProfile, targets: WidthTargets | None) -> None:
    """Thickness over arc length, one sigma, the target."""
    arc, width, sigma = (values * MM for values in (
        profile.arc_length, profile.thickness, profile.sigma))
    _shade(axes, profile)
    axes.fill_between(arc, width - sigma, width + sigma, color=COLOURS[Status.MEASURED],
                      alpha=0.3, linewidth=0, label='± 1 sigma')
    axes.plot(arc, np.where(profile.status == Status.MEASURED, width, np.nan),
              color=COLOURS[Status.MEASURED], label='thickness')
    if targets is not None:
        axes.plot(arc, targets.at(profile.arc_length) * MM, color=TARGET, linestyle='--',
                  label='target')
    axes.set_xlabel('arc length [mm]')
    axes.set_ylabel('thickness [mm]')
    axes.set_ylim(0, ceiling(profile, targets))
    axes.margins(x=0)
    _legend(axes, loc='lower left', ncols=3, handlelength=1)


def offset(axes: Axes, profile: ThicknessProfile) -> None:
    """How far the deposit's middle lies to the left of the path, over arc length."""
    _shade(axes, profile)
    axes.axhline(0, color=TARGET, linewidth=0.5)
    axes.plot(profile.arc_length * MM, (profile.left - profile.right) / 2 * MM,
              color=COLOURS[Status.MEASURED])
    axes.set_xlabel('arc length [mm]')
    axes.set_ylabel('left of the path [mm]')
    axes.set_ylim(*offset_range(profile))
    axes.margins(x=0)


def _shade(axes: Axes, profile: ThicknessProfile) -> None:
    for status in Status:
        extents = run_extents(profile.status == status, profile.arc_length * MM)
        if status != Status.MEASURED:
            for index, (start, end) in enumerate(extents):
                axes.axvspan(start, end, color=COLOURS[status], alpha=0.25, linewidth=0,
                             label=label(status) if index == 0 else None)


def plan(axes: Axes, profile: ThicknessProfile, targets: WidthTargets | None) -> None:
    """The filament seen along the base frame's z axis, coloured by its deviation."""
    measured = profile.status == Status.MEASURED
    starts = np.flatnonzero(measured[:-1] & measured[1:])
    left, right = profile.left_points[:, :2] * MM, profile.right_points[:, :2] * MM
    corners = np.stack((left[starts], right[starts], right[starts + 1], left[starts + 1]), axis=1)
    off = 100 * (profile.thickness / reference(profile, targets) - 1)
    colours = LinearSegmentedColormap.from_list('bpc', (THIN, RIGHT_ON, THICK))
    # Edges of the same colour: between neighbours a viewer would show the paper.
    ribbon = PolyCollection(list(corners), cmap=colours, linewidths=0.2, edgecolors='face')
    ribbon.set_array(off[starts])
    ribbon.set_clim(-100 * FULL, 100 * FULL)
    axes.add_collection(ribbon)
    for status in Status:
        if status != Status.MEASURED:
            _run(axes, profile.points[:, :2] * MM, profile.status == status, COLOURS[status],
                 label(status))
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


def histogram(axes: Axes, profile: ThicknessProfile, targets: WidthTargets | None) -> None:
    """How often each thickness was measured, and its quartiles."""
    found = profile.summary
    axes.hist(profile.thickness[profile.status == Status.MEASURED] * MM, bins=40,
              color=COLOURS[Status.MEASURED], alpha=0.6)
    for name, value, style in (('Q1', found.thickness_q1, ':'),
                               ('Q2', found.thickness_median, '-'),
                               ('Q3', found.thickness_q3, ':')):
        if np.isfinite(value):
            axes.axvline(value * MM, color=TARGET, linestyle=style,
                         label=f'{name} {value * MM:.3f}')
    if targets is not None and np.ptp(targets.thickness) == 0:
        axes.axvline(targets.thickness[0] * MM, color=TARGET, linestyle='--', label='target')
    axes.set_xlabel('thickness [mm]')
    axes.set_ylabel('samples')
    _legend(axes, loc='lower center', bbox_to_anchor=(0.5, 1), ncols=4, handlelength=1.5)
