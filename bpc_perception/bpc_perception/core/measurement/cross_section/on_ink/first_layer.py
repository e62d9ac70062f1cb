"""What the first layer tells of all above: how high the nozzle passes, how wide beads are."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Index
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.geometry import Plane
from bpc_perception.core.measurement.bed import bed_beside
from bpc_perception.core.measurement.cross_section.by_cloud.rough_beads import rough_beads
from bpc_perception.core.measurement.cross_section.height import Roundness
from bpc_perception.core.measurement.cross_section.on_ink.below import Below, normals_by_path
from bpc_perception.core.measurement.cross_section.sections.sampling import Footing, lay_sections
from bpc_perception.core.measurement.samples import Samples
from bpc_perception.core.measurement.track import Track
from bpc_perception.core.measurement.view import View
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status

EVEN_M = 1e-4  # by which the height of the nozzle above a plane bed may differ, in the median
LEAST_PATH = 20  # points of the first layer that tell it


def first_layer_measured(samples: Samples, path: DepositionPath, layer: Index,
                         bed: Plane) -> Below | None:
    """Return what the ink on the bed says, as it was measured; None = it was not.

    Args:
        samples: N samples.
        path: their points.
        layer: (N,) of each.
        bed: plane of the bed.
    """
    known = np.flatnonzero((layer == 0) & (samples.status == Status.MEASURED))
    if not len(known):
        return None
    sides, sizes = samples.of(known).sides, samples.of(known).sizes
    feet = (sides.left + sides.right) / 2
    bend = np.nan_to_num(sizes.crest - sizes.height)  # of the bed, higher below the bead
    width = sides.width
    return Below(clearance=float(np.median((path.points[known] - feet) @ bed.normal - bend)),
                 width=float(np.median(width)),
                 roundness=Roundness.like(sizes.area, sizes.height, width))


def first_layer_unseen(view: View, samples: Samples, path: DepositionPath, layer: Index,
                       track: Track, bed: Plane, config: ThicknessConfig) -> Below | None:
    """Return the same of a first layer that was covered before anybody saw it; None = unknown.

    So it is after a node was started again amid a print. The nozzle kept its height above the
    bed. Ink below is as wide as that measured above it, or as the cloud shows the newest.

    Args:
        view: the capture.
        samples: N samples.
        path: their points.
        layer: (N,) of each.
        track: P points that are in view.
        bed: plane of the bed.
        config: how to measure.
    """
    first = path.points[layer == 0]
    newest = np.flatnonzero(track.layer == track.layer[-1:].max(initial=0))
    if len(first) < LEAST_PATH or len(newest) < LEAST_PATH or not track.layer[newest[0]]:
        return None
    height = bed_beside(view, track.points, bed).height(first)
    clearance = float(np.median(height))
    if np.median(np.abs(height - clearance)) > EVEN_M:
        return None  # the bed is no plane
    sides = samples.of(np.flatnonzero(samples.status == Status.MEASURED)).sides
    if len(sides.left_distance):
        return Below(clearance, float(np.median(sides.width)))
    sections = lay_sections(view, track, newest, bed, config,
                            Footing(clearance, normals_by_path(track, newest, bed)))
    _, width = rough_beads(sections)
    known = width[np.isfinite(width) & (width > 0)]
    return Below(clearance, float(np.median(known))) if len(known) >= LEAST_PATH else None
