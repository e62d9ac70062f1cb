"""A finished print beside its design: where it lies, how far off it is, and what is missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.design import Design
from bpc_perception.core.design.deviation import deviations_of, placed, Spread
from bpc_perception.core.design.layer_fidelity import LayerFidelity, layers_of
from bpc_perception.core.design.presence import Missing, missing_in, presence_of
from bpc_perception.core.design.registration import register, Registration
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import ThicknessProfile


@dataclass(frozen=True)
class WantedDesign:
    """What a print was to be.

    Attributes:
        name: of the file.
        design: its strokes.
        place: where it lies; None = it is found from the path.
    """

    name: str
    design: Design
    place: Registration | None = None


@dataclass(frozen=True)
class DesignComparison:
    """A print beside its design.

    Attributes:
        registration: where the design lies; where it is not found, nothing else is known.
        nozzle, bead: how far the nozzle's path and the bead's middle are off, to the left > 0 [m].
        width: by how much the bead is wider than the design wants it [m].
        layers: how well each layer is printed.
        missing: parts of the design's strokes that are not printed, as far as is known.
        surplus: (R, 2) arc lengths of ink where no design is [m].
    """

    registration: Registration
    nozzle: Spread
    bead: Spread
    width: Spread
    layers: tuple[LayerFidelity, ...] = ()
    missing: tuple[Missing, ...] = ()
    surplus: Array | None = None


def compare_with_design(profile: ThicknessProfile, wanted: WantedDesign) -> DesignComparison:
    """Compare a print that is over with its design, by its profile."""
    place = wanted.place or register(wanted.design, profile.points, profile.stroke, finished=True)
    if place.refusal:
        nothing = Spread.of(np.empty(0))
        return DesignComparison(place, nothing, nothing, nothing)
    pieces, up = placed(wanted.design, place.T_base_design)
    found = deviations_of(profile, pieces, up)
    presence = presence_of(profile, _path_of(profile), pieces, found)
    return DesignComparison(
        place, Spread.of(found.nozzle), Spread.of(found.bead),
        Spread.of(profile.thickness - found.width), layers_of(pieces, found, presence, up),
        missing_in(pieces, presence), profile.runs_of(found.surplus))


def _path_of(profile: ThicknessProfile) -> DepositionPath:
    """Return the path of a print that is over, of which a profile has all."""
    unknown = np.full(len(profile), np.nan)
    end = float(profile.time[-1]) if len(profile) else 0.0
    return DepositionPath(profile.print_id, profile.print_start_ns, end, True, profile.time,
                          profile.arc_length, profile.points, unknown, unknown,
                          profile.extruding, profile.extruder_known)
