"""Lines on the surface across the path, and what camera and cloud show along them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import running_median, thinned
from bpc_perception.core.measurement.scale import steady_window

SAMPLE_STEP_PX = 0.5  # between samples of a section
# The fields with one entry a section, along their first axis.
PER_SECTION = ('piece', 'along', 'foot', 'lateral', 'lean', 'in_row', 'inside', 'hidden', 'depth',
               'raised', 'beside', 'foreign', 'nearing', 'colour', 'height', 'place')


@dataclass(frozen=True)
class Sections:
    """Lines across N path points, M samples each, from right to left of the direction of travel.

    Attributes:
        piece: (N,) number of the piece of path that each is on, never falling.
        along: (N,) length along the ink, see Track [m].
        foot: (N, 3) points of the surface below the nozzle tip, in the base frame [m].
        lateral: (N, 3) unit vectors along the surface to the left.
        lean: (N,) how far a bead's ridge seems to be shifted along the path, seen from where
            the camera stands, positive forward [m]; 0 where its height is not known.
        in_row: (N,) how well the path keeps to its place between two rows, or columns, of pixels:
            1 = all along the steady length, 0 = it passes all places alike.
        offset: (M,) distances from the path, positive to the left [m].
        pixel: length of a pixel's side on the surface [m].
        spacing: between path points [m].
        inside: (N, M) whether a sample lies in the image.
        hidden: (N, M) whether something stands in front of it.
        depth: (N,) whether the cloud knows the surface there.
        raised: (N,) whether the cloud has something there that stands above the bed.
        beside: (N, M) whether it lies so far from all of the path that bed is to be expected.
        clearance: (2, N) how far that is from the path, on the right and the left [m].
        foreign: (N, M) whether another pass of the same layer is nearer than this one,
        nearing: (N, M) and the section comes nearer to it outward.
        colour: (N, M, 3) RGB.
        height, place: (N, M) of the cloud at each sample: above the foot, and how far to the left
            of the path, which height makes differ from the offset [m]; NaN = no point.
    """

    piece: Index
    along: Array
    foot: Array
    lateral: Array
    lean: Array
    in_row: Array
    offset: Array
    pixel: float
    spacing: float
    inside: Flags
    hidden: Flags
    depth: Flags
    raised: Flags
    beside: Flags
    clearance: Array
    foreign: Flags
    nearing: Flags
    colour: Floats
    height: Floats
    place: Floats

    def of(self, index: Index, step: int) -> Sections:
        """Return the sections of an increasing index (K,), which are about ``step`` apart."""
        if len(index) == len(self.piece):
            return replace(self, spacing=self.spacing * step)
        some = {name: getattr(self, name)[index] for name in PER_SECTION}
        return replace(self, **some, clearance=self.clearance[:, index],
                       spacing=self.spacing * step)

    @property
    def visible(self) -> Flags:
        """Where (N, M) the surface is seen."""
        return self.inside & ~self.hidden

    @property
    def on_path(self) -> int:
        """Which of the M samples lies on the path."""
        return len(self.offset) // 2

    @property
    def a_pixel_apart(self) -> Index:
        """Which sections (K,) are no closer together than points of the cloud."""
        return thinned(self.piece, max(1, int(self.pixel / self.spacing)))

    def steady(self, values: Array) -> Array:
        """Return the running median (N, ...) of values (N, ...) over the steady length of a piece.

        Unknown stretches, NaN, take the nearest known values; all is NaN where nothing is known.
        """
        return running_median(values, steady_window(self.spacing), self.piece)
