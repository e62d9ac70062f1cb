"""A profile beside the truth, and the figures that say how far to trust it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.measure import measure, MeasurementError
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.stress.truth import Categories, StressScene, Truth

OFF = (0.3e-3, 0.2)  # an error beyond the larger of these, [m] and of the width, is wrong
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Comparison:
    """N samples of one print or of several, measured by one method.

    Attributes:
        true: (N,) width of the pass [m], 0 in gaps.
        expected: (N,) values of Truth.
        status: (N,) values of Status.
        thickness: (N,) as measured [m]; NaN unless MEASURED, or GAP (0).
        sigma: (N,) as reported [m].
        time: (P,) that each of the P prints took [s].
    """

    true: Array
    expected: Categories
    status: NDArray[np.uint8]
    thickness: Array
    sigma: Array
    time: Array

    @property
    def given(self) -> Mask:
        """Which samples (N,) are MEASURED or GAP."""
        return np.isfinite(self.thickness)

    @property
    def error(self) -> Array:
        """Measured less true width (N,) [m], where either says MEASURED; NaN elsewhere."""
        material = (self.status == Status.MEASURED) & (self.expected == Truth.MEASURED)
        return np.where(material, self.thickness - self.true, np.nan)

    @property
    def mae(self) -> float:
        """Mean absolute error [m]."""
        return _mean(np.abs(self.error))

    @property
    def median_error(self) -> float:
        """Median absolute error [m]."""
        size = np.abs(self.error[np.isfinite(self.error)])
        return float(np.median(size)) if len(size) else np.nan

    @property
    def largest_error(self) -> float:
        """Largest absolute error [m]."""
        size = np.abs(self.error[np.isfinite(self.error)])
        return float(size.max()) if len(size) else np.nan

    @property
    def answered(self) -> float:
        """Share given of what can be known: of those that are MEASURED or GAP in truth."""
        return _share(self.given, (self.expected == Truth.MEASURED) | (self.expected == Truth.GAP))

    @property
    def wrong(self) -> float:
        """Share of samples that are MEASURED and off, of all for which an answer is right."""
        return _share((self.status == Status.MEASURED) & self._off, self.expected != Truth.EDGE)

    @property
    def confidently_wrong(self) -> float:
        """As ``wrong``, material called GAP included."""
        return _share(self._off, self.expected != Truth.EDGE)

    @property
    def unknowable(self) -> int:
        """How many samples have no single width, or none that is seen."""
        return int(np.isin(self.expected, (Truth.JUNCTION, Truth.HIDDEN)).sum())

    @property
    def guessed(self) -> float:
        """Share given of those; NaN without any."""
        return _share(self.given, np.isin(self.expected, (Truth.JUNCTION, Truth.HIDDEN)))

    @property
    def gap_called_material(self) -> int:
        """How many samples of gaps are MEASURED."""
        return int(((self.expected == Truth.GAP) & (self.status == Status.MEASURED)).sum())

    @property
    def material_called_gap(self) -> int:
        """How many samples on ink are GAP."""
        return int(((self.expected == Truth.MEASURED) & (self.status == Status.GAP)).sum())

    def within(self, sigmas: float) -> float:
        """Share of errors within so many times their own sigma."""
        return _share(np.abs(self.error) <= sigmas * self.sigma, np.isfinite(self.error))

    @property
    def _off(self) -> Mask:
        limit = np.maximum(OFF[0], OFF[1] * self.true)
        off: Mask = np.abs(self.thickness - self.true) > limit
        return off


def together(parts: Sequence[Comparison]) -> Comparison:
    """All samples of several prints."""
    return Comparison(*(np.concatenate([getattr(part, field.name) for part in parts])
                        for field in fields(Comparison)))


def compare(scene: StressScene, method: str) -> Comparison:
    """Measure a scene; what comes without a sample is NO_DATA."""
    status = np.full(len(scene), Status.NO_DATA, np.uint8)
    thickness, sigma = np.full((2, len(scene)), np.nan)
    time = np.nan
    try:
        profile = measure(scene.capture, scene.path, scene.T_base_camera,
                          ThicknessConfig(method=method))
    except MeasurementError:
        pass
    else:
        index = np.searchsorted(scene.arc_length, profile.arc_length)
        status[index] = profile.status
        thickness[index], sigma[index] = profile.thickness, profile.sigma
        time = profile.processing_time
    return Comparison(scene.thickness, scene.expected, status, thickness, sigma,
                      np.array((time,)))


def compare_profile(profile: ThicknessProfile, true: Array) -> Comparison:
    """A profile of a print of which all points can be known; their widths (N,) are true [m]."""
    expected = np.where(true > 0, Truth.MEASURED, Truth.GAP).astype(np.uint8)
    return Comparison(true, expected, profile.status, profile.thickness, profile.sigma,
                      np.array((profile.processing_time,)))


def _share(flags: Mask, among: Mask) -> float:
    return float(flags[among].mean()) if among.any() else np.nan


def _mean(values: Array) -> float:
    return float(np.nanmean(values)) if np.isfinite(values).any() else np.nan
