"""Thickness from the image across the path: the default method.

The image is read along a line across each path point. Where it passes half-way from ink to what
lies beside it, there is the edge, to a fraction of a pixel. Which edge is meant the path says: the
first on either side, going outwards from it. What ink and bed look like is taken from the
image itself, near each point: ink lies along the path, bed far from all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.capture.capture import Capture
from bpc_perception.core.config import CrossSectionConfig, ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.cross_section.appearance import (
    Contrast,
    find_light,
    ink_share,
)
from bpc_perception.core.measurement.cross_section.edges import Edges, find_edges
from bpc_perception.core.measurement.cross_section.judgement import ends_within_pixel, judge
from bpc_perception.core.measurement.cross_section.sampling import (
    lay_sections,
)
from bpc_perception.core.measurement.scale import step_within_window
from bpc_perception.core.measurement.side_points import SidePoints
from bpc_perception.core.profile import Status, StatusArray


@dataclass(frozen=True)
class CrossSections:
    """What is known of N path points.

    Attributes:
        sides: their side points.
        status: (N,) values of Status.
        sigma: (N,) 1-sigma uncertainty of the width between them [m].
        contrast: of ink and bed in all of the print; None = nothing is told apart.
    """

    sides: SidePoints
    status: StatusArray
    sigma: Array
    contrast: Contrast | None


def measure_cross_sections(
    capture: Capture, points: Array, extruding: Flags, T_base_camera: Array, bed: Plane,
    config: ThicknessConfig, index: Index | None = None, known: Contrast | None = None,
) -> CrossSections:
    """Measure a path (P, 3), or only its points of an ``index`` (N,); see ``measure``.

    Of a part alone, its ends are not known well, and the contrast of the whole print has to be.
    """
    index = np.arange(len(points)) if index is None else index
    sections = lay_sections(capture, points, index, T_base_camera, bed, config)
    # Light changes slowly along the path.
    step = step_within_window(sections.spacing)
    near = np.minimum((np.arange(len(index)) + step // 2) // step, (len(index) - 1) // step)
    light = find_light(sections.every(step), extruding[index][::step], known).at(near)
    ink = ink_share(sections, light)
    right, left = find_edges(sections, light.noise, ink)
    status = judge(sections, ink, left, right, light.noise > config.cross_section.maximum_noise)
    status[ends_within_pixel(capture, sections, light, T_base_camera, bed.normal)
           & ((status == Status.MEASURED) | (status == Status.GAP))] = Status.LOW_CONFIDENCE
    sigma = width_sigma(left, right, sections.pixel, config.cross_section)
    sides = SidePoints(sections.foot + left.distance[:, None] * sections.lateral,
                       sections.foot - right.distance[:, None] * sections.lateral,
                       left.distance, right.distance)
    return CrossSections(sides, status, sigma, light.contrast)


def width_sigma(left: Edges, right: Edges, pixel: float, config: CrossSectionConfig) -> Array:
    """1-sigma uncertainty (N,) of the width between two edges [m].

    The noise of both edges; what sampling leaves; and the light on the bead, which shades its
    edges and shines on its ridge: the fewer pixels the bead has, the less of that is seen apart.
    """
    noise = config.noise_gain * np.hypot(left.sigma, right.sigma)
    width = left.distance + right.distance
    narrow = config.light_sigma * (10 * pixel / width) ** 2
    return np.sqrt(noise**2 + (config.edge_sigma * pixel) ** 2 + (narrow * pixel) ** 2)
