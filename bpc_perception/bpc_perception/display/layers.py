"""Which samples are shown with which layer."""

from __future__ import annotations

import numpy as np

from bpc_perception.core.arrays import Flags, Index
from bpc_perception.core.profile import ThicknessProfile

NEWEST = -1  # the layer that is laid last, whichever it is


def layers_of(profile: ThicknessProfile) -> list[tuple[int, Flags]]:
    """Return the layers, and which samples (N,) each has, for what is shown by layer.

    Travel goes with the layer before it.
    """
    layer = layer_or_before(profile)
    return [(number, layer == number) for number in np.unique(layer).tolist()]


def in_layer(profile: ThicknessProfile, layer: int = NEWEST) -> Flags:
    """Return which samples (N,) are of a layer, travel with that of the stroke before it."""
    of = layer_or_before(profile)
    return np.asarray(of == (of.max(initial=0) if layer == NEWEST else layer))


def layer_or_before(profile: ThicknessProfile) -> Index:
    """Return the layer of each sample (N,); of travel, that of the stroke before it."""
    laid = profile.layer >= 0
    last = np.maximum.accumulate(np.where(laid, np.arange(len(profile)), 0))
    return np.maximum(profile.layer[last], 0)
