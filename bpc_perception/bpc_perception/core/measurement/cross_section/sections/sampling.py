"""Sections laid across the path: where they run, and what is seen along them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.filters import masked_median, running_mean, running_median
from bpc_perception.core.geometry import Plane, unit_vectors
from bpc_perception.core.measurement.cross_section.sections.lines import (
    colours_at,
    distances_along,
    heights,
    Lines,
    pixels_along,
    points_at,
)
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)
from bpc_perception.core.measurement.cross_section.sections.surface import follow_surface
from bpc_perception.core.measurement.cross_section.sections.territory import find_territory
from bpc_perception.core.measurement.scale import steady_window
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.tangents import smoothed_tangents, typical_spacing

COARSE_STEP = 4  # what varies slowly across the path is looked at in every n-th sample
RAISED_M = 0.0004  # what stands higher above the bed is no bed
LEAST_DEPTH = 0.1  # share of the samples of a section that have depth, if the surface is known
NOISE_SIGMAS = 4.0  # of the cloud, that a raised middle has to exceed


@dataclass(frozen=True)
class Footing:
    """Where the feet of beads are whose surroundings do not tell.

    Attributes:
        clearance: how high above them the nozzle passed [m].
        normal: (N, 3) of the surface below each section.
    """

    clearance: float
    normal: Array


def lay_sections(view: View, track: Track, index: Index, bed: Plane,
                 config: ThicknessConfig, footing: Footing | None = None) -> Sections:
    """Lay a section across a track at each point of an index.

    Args:
        view: the capture.
        track: all that other ink may come from.
        index: (N,) of the points that get a section.
        bed: plane of the bed.
        config: how to measure.
        footing: where the feet of the bead are; None = the surface beside the path tells.
    """
    points, piece = track.points, track.piece[index]
    tangent = smoothed_tangents(points, track.piece, index, config.cross_section.tangent_length)
    normal = bed.normal if footing is None else footing.normal
    lateral = unit_vectors(np.cross(normal, tangent))
    spacing, pixel = typical_spacing(points), view.pixel_size(points[index])
    offset = sample_offsets(config.cross_section.reach, pixel)
    coarse = Lines(points[index], lateral, offset[::COARSE_STEP])
    territory = find_territory(bed.coordinates(points), track.along, track.layer, index,
                               bed.coordinates(lateral), coarse.offset, spacing)
    if footing is None:
        lines = follow_surface(view, coarse, piece, spacing, territory.beside, bed.normal,
                               config.obstacle_height)
    else:
        lines = replace(coarse, foot=coarse.foot - footing.clearance * footing.normal)
    lines = replace(lines, offset=offset)
    foreign, nearing = territory.passes_at(offset)
    uv = pixels_along(view, lines)
    seen = points_at(view.capture.cloud, uv)
    height = heights(view, seen, lines, normal)
    return Sections(
        piece=piece, along=track.along[index], foot=lines.foot, lateral=lines.lateral,
        lean=ridge_lean(view, lines, height, tangent, bed.normal, pixel, spacing, piece),
        in_row=kept_in_row(uv[:, :, len(offset) // 2], spacing, piece),
        offset=offset, pixel=pixel, spacing=spacing,
        inside=view.capture.camera.contains(np.moveaxis(uv, 0, -1)),
        hidden=hidden_samples(height > config.obstacle_height, config.obstacle_margin, pixel,
                              spacing),
        depth=np.count_nonzero(np.isfinite(height), axis=1) > LEAST_DEPTH * len(offset),
        raised=raised_middle(height, offset, pixel, territory.beside),
        beside=territory.beside_at(offset), clearance=territory.clearance,
        foreign=foreign, nearing=nearing,
        colour=colours_at(view, uv), height=height,
        place=distances_along(view, seen, lines))


def sample_offsets(reach: float, pixel: float) -> Array:
    """Return the distances (M,) of a section's samples from the path, as far as the reach [m]."""
    count = int(np.ceil(reach / (SAMPLE_STEP_PX * pixel)))
    return np.linspace(-count, count, 2 * count + 1) * (SAMPLE_STEP_PX * pixel)


def hidden_samples(obstacle: Flags, margin: float, pixel: float, spacing: float) -> Flags:
    """Return where (N, M) an obstacle (N, M) stands in front, or is within a margin [pixels]."""
    across = 2 * round(margin / SAMPLE_STEP_PX) + 1
    along = 2 * round(margin * pixel / spacing) + 1
    grown = cv2.dilate(obstacle.view(np.uint8), np.ones((along, across), np.uint8))
    return np.asarray(grown).view(bool)


def ridge_lean(view: View, lines: Lines, height: Floats, tangent: Array, normal: Array,
               pixel: float, spacing: float, piece: Index) -> Array:
    """Return how far (N,) the ridge of the bead seems to be shifted along the path [m].

    Seen from where the camera stands, and positive forward. 0 where the height (N, M) is unknown.
    """
    central = np.abs(lines.offset) <= pixel
    ridge = running_median(masked_median(height[:, central], np.isfinite(height[:, central])),
                           steady_window(spacing), piece)
    to_camera = view.viewpoint - lines.foot
    lean = -ridge * np.einsum('nk,nk->n', to_camera, tangent) / (to_camera @ normal)
    return np.where(np.isfinite(lean), lean, 0.0)


def kept_in_row(uv: Floats, spacing: float, piece: Index) -> Array:
    """Return how well (N,) pixels (2, N) keep to their place between rows, or columns, of pixels.

    It is the squared length of the mean of what turns once from row to row; see Sections.
    """
    turn = 2 * np.pi * uv.T.astype(np.float64)
    mean = running_mean(np.concatenate((np.cos(turn), np.sin(turn)), axis=1),
                        steady_window(spacing), piece)
    return np.asarray((mean[:, :2]**2 + mean[:, 2:]**2).max(axis=1))


def raised_middle(height: Floats, offset: Array, pixel: float, beside: Flags) -> Flags:
    """Return where (N,) the middle of a section stands above the bed by more than noise explains.

    Args:
        height: (N, M) above the surface [m].
        offset: (M,) from the path [m].
        pixel: length of a pixel's side on the surface [m].
        beside: (N, K) where bed is to be expected, at every ``COARSE_STEP``-th offset.
    """
    coarse = height[:, ::COARSE_STEP]
    at_bed = coarse[beside & np.isfinite(coarse)]
    noise = 1.4826 * float(np.median(np.abs(at_bed - np.median(at_bed)))) if len(at_bed) else 0.0
    middle = height[:, np.abs(offset) <= 2 * pixel]
    return masked_median(middle, np.isfinite(middle)) > max(RAISED_M, NOISE_SIGMAS * noise)
