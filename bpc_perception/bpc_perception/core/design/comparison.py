"""A print beside its design: where it lies, how far off it is, and what is missing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.design.design import Design
from bpc_perception.core.design.deviation import Deviations, deviations_of, placed, Spread
from bpc_perception.core.design.layer_fidelity import LayerFidelity, layers_of
from bpc_perception.core.design.pieces import Pieces
from bpc_perception.core.design.presence import Missing, missing_in, presence_of
from bpc_perception.core.design.registration import register, Registration
from bpc_perception.core.path.deposition_path import DepositionPath
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

MOST_BESIDE = 0.5  # share of the ink that may lie beside a design whose place is told
# A design that was found is looked for anew when there is so much more ink.
GROWN = 1.2


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
class DesignFindings:
    """How far a print is from its design.

    Attributes:
        name: of the design's file.
        registration: where the design lies; where it is not found, nothing else is known.
        nozzle, bead: how far the nozzle's path and the bead's middle are off, to the left > 0 [m].
        width: by how much the bead is wider than the design wants it [m].
        layers: how well each layer is printed.
        missing: parts of the design's strokes that are not printed, as far as is known.
        surplus: (R, 2) arc lengths of ink where no design is [m].
    """

    name: str
    registration: Registration
    nozzle: Spread
    bead: Spread
    width: Spread
    layers: tuple[LayerFidelity, ...]
    missing: tuple[Missing, ...]
    surplus: Array


@dataclass(frozen=True)
class DesignComparison:
    """A print beside its design, sample by sample.

    Attributes:
        wanted: the design.
        findings: in numbers.
        pieces: of the design, in the base frame; None = not known.
        deviations: of each sample from them; None alike.
    """

    wanted: WantedDesign
    findings: DesignFindings
    pieces: Pieces | None = None
    deviations: Deviations | None = None

    def warning(self, profile: ThicknessProfile) -> str:
        """Return why the place is not found, where a stroke of the print is long enough to.

        Or that the ink lies elsewhere than where the design is told to lie.
        """
        first = self.wanted.design.strokes[0].length
        strokes = profile.strokes.commanded
        ink = float(np.diff(strokes, axis=1).sum())
        refusal = self.findings.registration.refusal
        if not refusal and self.deviations is not None and self.wanted.place is not None:
            beside = float(self.deviations.surplus.sum() / max((profile.stroke > 0).sum(), 1))
            refusal = (f'expected ink on it, found {beside:.0%} of the ink beside where it is '
                       'told to lie; correct design.place or --design-at, or leave it out'
                       if beside > MOST_BESIDE else '')
        return f'design: {refusal}' if refusal and ink > first else ''

    def targets(self, arc_length: Array, others: WidthTargets | None) -> WidthTargets | None:
        """Return the widths that are wanted along a print: the design's where it tells them.

        None where it tells some, and it is not known which: it is not found, or no ink is on it.

        Args:
            arc_length: (N,) of the profile's samples [m].
            others: that hold elsewhere; None = none.
        """
        piece = np.empty(0, np.intp) if self.deviations is None else self.deviations.piece
        at = np.flatnonzero(piece >= 0)
        if self.pieces is None or not len(at):
            return None if self.wanted.design.tells_widths else others
        arc, width = arc_length[at], self.pieces.width[piece[at]]
        # Advice looks ahead along the stroke.
        last = int(piece[at[-1]])
        coming = np.flatnonzero(self.pieces.stroke == self.pieces.stroke[last])
        coming = coming[coming > last]
        ahead = arc_length[at[-1]] + self.pieces.ink[coming] - self.pieces.ink[last]
        arc, width = np.append(arc, ahead), np.append(width, self.pieces.width[coming])
        # On travel, and beside the design, the target before it goes on.
        return WidthTargets.told(arc, width, others)


def compare_with_design(profile: ThicknessProfile, wanted: WantedDesign,
                        path: DepositionPath | None = None,
                        place: Registration | None = None) -> DesignComparison:
    """Compare a print with its design.

    Args:
        profile: of the print.
        wanted: its design.
        path: as far as it is known; None = the print is over, and the profile has all of it.
        place: where the design was found; None = it is told, or looked for.
    """
    place = place or wanted.place or register(
        wanted.design, profile.points, profile.stroke, path is None or path.finished)
    if place.refusal:
        nothing = Spread.of(np.empty(0))
        return DesignComparison(wanted, DesignFindings(
            wanted.name, place, nothing, nothing, nothing, (), (), np.empty((0, 2))))
    pieces, up = placed(wanted.design, place.T_base_design)
    found = deviations_of(profile, pieces, up)
    presence = presence_of(profile, path or path_of(profile, True), pieces, found)
    measured = profile.status == Status.MEASURED  # a gap is no thin bead
    findings = DesignFindings(
        wanted.name, place, Spread.of(found.nozzle), Spread.of(found.bead),
        Spread.of((profile.thickness - found.width)[measured]),
        layers_of(pieces, found, presence, up), missing_in(pieces, presence),
        profile.runs_of(found.surplus))
    return DesignComparison(wanted, findings, pieces, found)


class DesignFollower:
    """Compares prints that grow with their design; where it lies is kept while it fits.

    Attributes:
        wanted: the design.
    """

    def __init__(self, wanted: WantedDesign) -> None:
        self.wanted = wanted
        self._print_id = ''
        self._tried = 0, False  # with how many samples the place was looked for, of all the print
        self._place: Registration | None = None

    def compare(self, profile: ThicknessProfile, path: DepositionPath) -> DesignComparison:
        """Compare a print with its design, by its profile and its path as far as it is known."""
        if profile.print_id != self._print_id:
            self._print_id, self._tried, self._place = profile.print_id, (0, False), None
        ink = int((profile.stroke > 0).sum())
        ended = path.finished and len(profile) == len(path)
        before, over = self._tried
        if self.wanted.place is None and (ink > GROWN * before or (ended and not over)):
            self._tried = ink, ended
            self._place = register(self.wanted.design, profile.points, profile.stroke, ended,
                                   None if ended else self._place)
        return compare_with_design(profile, self.wanted, path, self._place)


def path_of(profile: ThicknessProfile, finished: bool) -> DepositionPath:
    """Return the path of a print of which a profile has all that is known."""
    unknown = np.full(len(profile), np.nan)
    end = float(profile.time[-1]) if len(profile) else 0.0
    return DepositionPath(profile.print_id, profile.print_start_ns, end, finished, profile.time,
                          profile.arc_length, profile.points, unknown, unknown,
                          profile.extruding, profile.extruder_known)
