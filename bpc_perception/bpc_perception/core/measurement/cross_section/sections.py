"""Lines on the surface across the path, and what camera and cloud show along them."""

from __future__ import annotations

from dataclasses import dataclass

from bpc_perception.core.arrays import Array, Flags, Floats, Index
from bpc_perception.core.filters import running_median
from bpc_perception.core.measurement.scale import WINDOW

STEP = 0.5  # between samples of a section [pixels]


@dataclass(frozen=True)
class Sections:
    """Lines across N path points, M samples each, from right to left of the direction of travel.

    Attributes:
        index: (N,) of the path points.
        foot: (N, 3) points of the surface below the nozzle tip [m].
        lateral: (N, 3) unit vectors along the surface to the left.
        lean: (N,) how far a bead's ridge seems to be shifted along the path, seen from where
            the camera stands, positive forward [m]; 0 where its height is not known.
        offset: (M,) distances from the path, positive to the left [m].
        pixel: length of a pixel's side on the surface [m].
        spacing: between path points [m].
        inside: (N, M) whether a sample lies in the image.
        hidden: (N, M) whether something stands in front of it.
        depth: (N,) whether the cloud knows the surface there.
        raised: (N,) whether the cloud has something there that stands above the bed.
        beside: (N, M) whether it lies so far from all of the path that bed is to be expected.
        clearance: (2, N) how far that is from the path, on the right and the left [m].
        foreign: (N, M) whether another pass of the path is nearer than this one.
        colour: (N, M, 3) RGB.
    """

    index: Index
    foot: Array
    lateral: Array
    lean: Array
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
    colour: Floats

    def every(self, step: int) -> Sections:
        """Only every so manieth of the sections."""
        chosen = slice(None, None, step)
        return Sections(
            self.index[chosen], self.foot[chosen], self.lateral[chosen], self.lean[chosen],
            self.offset, self.pixel, self.spacing * step, self.inside[chosen],
            self.hidden[chosen], self.depth[chosen], self.raised[chosen], self.beside[chosen],
            self.clearance[:, chosen], self.foreign[chosen], self.colour[chosen])

    @property
    def visible(self) -> Flags:
        """Where (N, M) the surface is seen."""
        return self.inside & ~self.hidden

    def steady(self, values: Array) -> Array:
        """Running median (N, ...) along the path of values (N, ...) with NaN = unknown.

        Unknown stretches take what is known nearest by; all NaN where nothing is.
        """
        return running_median(values, 2 * round(WINDOW / 2 / self.spacing) + 1)
