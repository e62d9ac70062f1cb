"""How much of each sample of the sections is ink."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Flags, Floats
from bpc_perception.core.measurement.cross_section.appearance.appearance import Appearance, weighed
from bpc_perception.core.measurement.cross_section.sections.sections import (
    SAMPLE_STEP_PX,
    Sections,
)

SPECK_PX2 = 4.0  # glare on a smaller area is noise,
SURE_GLARE = 2.0  # unless it exceeds the bed by this factor of what makes glare
HALO_PX = 2.5  # the lens spreads the light of glare this far


def ink_share(sections: Sections, appearance: Appearance) -> Floats:
    """Return how much of each sample (N, M) is ink: 0 = bed, 1 = ink; NaN where it is not seen.

    In and around glare the colour of what shines is not seen either.
    """
    share = weighed(sections.colour, appearance.weight)
    glare, sure = np.zeros(share.shape, np.uint8), np.zeros(share.shape, bool)
    brightness = np.asarray(cv2.transform(sections.colour, np.full((1, 3), 1 / 3)))
    sides = slice(None, sections.on_path), slice(sections.on_path, None)
    for part, bed, least in zip(sides, appearance.bed, appearance.glare_from, strict=True):
        share[:, part] -= (bed * appearance.weight).sum(axis=1).astype(np.float32)[:, None]
        most = least + (SURE_GLARE - 1) * (least - bed.mean(axis=1))
        glare[:, part] = brightness[:, part] > least[:, None]
        sure[:, part] = brightness[:, part] > most[:, None]
    area = SPECK_PX2 / SAMPLE_STEP_PX * sections.pixel / sections.spacing
    glare = without_specks(glare, sure, area)
    across = 2 * round(HALO_PX / SAMPLE_STEP_PX) + 1
    along = 2 * round(HALO_PX * sections.pixel / sections.spacing) + 1
    glare = np.asarray(cv2.dilate(glare, np.ones((along, across), np.uint8)), np.uint8)
    share[~sections.visible | (glare > 0)] = np.nan
    return share


def without_specks(glare: NDArray[np.uint8], sure: Flags, area: float) -> NDArray[np.uint8]:
    """Return glare (N, M) without its specks.

    A speck hangs together on less than an area [samples], and is nowhere sure (N, M) to be glare.
    """
    if not cv2.countNonZero(glare):
        return glare
    _, label, found, _ = cv2.connectedComponentsWithStats(glare)
    kept = found[:, cv2.CC_STAT_AREA] >= area
    kept[label[sure]] = True
    kept[0] = False
    return np.asarray(kept[label], np.uint8)
