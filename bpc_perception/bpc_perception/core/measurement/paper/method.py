"""The published method: Zobeidi et al., IROS 2026, from capture and path to side points.

Its steps are in ``delineation`` (Sec. III-A) and ``thickness`` (Sec. III-B). It is for pictures of
finished prints: while an obstacle stands among the print, nothing is judged.
"""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.capture.capture import sample_cloud
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Plane, transform
from bpc_perception.core.measurement.paper.delineation import delineate
from bpc_perception.core.measurement.paper.thickness import (
    containing_contour,
    cut_contours,
    fit_plane,
)
from bpc_perception.core.measurement.paper.visibility import (
    find_obstacles,
    obstacle_near_path,
    visibility,
)
from bpc_perception.core.measurement.samples import Samples, Sizes
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.verdicts import Verdicts
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.tangents import tangents
from bpc_perception.core.profile import Cause, Status


def measure_as_published(view: View, track: Track, bed: Plane,
                         config: ThicknessConfig) -> Samples:
    """Measure a track by the published method."""
    points = track.points
    contours = contours_3d(view, config)
    plane = surface_plane(contours, view, bed)
    containing = containing_contour(
        plane.coordinates(points), [plane.coordinates(contour) for contour in contours])
    sides = cut_contours(points, tangents(points, track.piece), contours, containing, plane.normal)

    one_sided = np.isnan(sides.width)
    obstacle = find_obstacles(view, bed, config.obstacle_height)
    seen = visibility(view, bed, obstacle, points, round(config.obstacle_margin))
    # The outline of an obstacle among the print merges with that of the print.
    among = np.full(len(points), obstacle_near_path(obstacle, view, points))
    verdicts = Verdicts.by_first(
        [((seen.status == Status.MEASURED) & holds, status, cause) for holds, status, cause in (
            (among, Status.LOW_CONFIDENCE, Cause.OBSTACLE),
            (containing < 0, Status.GAP, Cause.NONE),
            (one_sided, Status.LOW_CONFIDENCE, Cause.NO_EDGE))], seen)
    distance = np.linalg.norm(points - view.viewpoint, axis=1)
    return Samples(sides, verdicts, pixel_edge_sigma(distance, view.capture.camera.focal_length),
                   Sizes.unknown(len(points)), np.full(len(points), view.number))


def contours_3d(view: View, config: ThicknessConfig) -> list[Array]:
    """Return the fused contours (N_i, 3) in the base frame [m].

    Vertices without a point of the cloud are left out.
    """
    contours = []
    for contour in delineate(view.capture.image, config.segmentation).fused:
        points = sample_cloud(view.capture.cloud, contour.astype(np.float64))
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) >= 3:
            contours.append(transform(view.T_base_camera, points))
    return contours


def surface_plane(contours: list[Array], view: View, bed: Plane) -> Plane:
    """Return the plane through all contours; the bed's where nothing is delineated."""
    try:
        return fit_plane(np.concatenate(contours), view.viewpoint)
    except ValueError:
        return bed


def pixel_edge_sigma(distance: Array, focal_length: float) -> Array:
    """Return the 1-sigma uncertainty (N,) of a width between two edges known to whole pixels [m].

    Each edge is uniformly distributed over one pixel, whose side is distance / focal_length.

    Args:
        distance: (N,) from the camera [m].
        focal_length: [pixels].
    """
    return distance / focal_length * np.sqrt(2 / 12)
