"""A profile beside the truth, and the figures that say how far to trust the profile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from bpc_perception.core.arrays import Array
from bpc_perception.core.config import ThicknessConfig
from bpc_perception.core.measurement.measure import measure, MeasurementError
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.stress.stress_scene import StressScene
from bpc_sim.stress.truth import Categories, Truth

# A larger error than both is wrong: absolute, and as a share of the width.
WRONG_ERROR_M, WRONG_SHARE = 0.3e-3, 0.2
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Comparison:
    """N samples of one print or of several, measured by one method.

    Attributes:
        true: (N,) width of the pass [m], 0 in gaps.
        expected: (N,) values of Truth.
        status: (N,) values of Status.
        thickness: (N,) measured thickness [m]; 0 where GAP, NaN unless MEASURED or GAP.
        sigma: (N,) reported standard deviation [m].
        time: (P,) time that each of the P prints took [s].
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
        """Measured less true width (N,) [m] where both are MEASURED; NaN elsewhere."""
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
        """Share of the samples with an answer among those that are MEASURED or GAP in truth."""
        return _share(self.given, (self.expected == Truth.MEASURED) | (self.expected == Truth.GAP))

    @property
    def wrong(self) -> float:
        """Share of samples that are MEASURED and off, among those with one right answer."""
        return _share((self.status == Status.MEASURED) & self._off, self.expected != Truth.EDGE)

    @property
    def confidently_wrong(self) -> float:
        """As ``wrong``, but with material that is called GAP included."""
        return _share(self._off, self.expected != Truth.EDGE)

    @property
    def unknowable(self) -> int:
        """Number of samples without a single width that can be seen."""
        return int(np.isin(self.expected, (Truth.JUNCTION, Truth.HIDDEN)).sum())

    @property
    def guessed(self) -> float:
        """Share of these samples that have an answer all the same; NaN = there are none."""
        return _share(self.given, np.isin(self.expected, (Truth.JUNCTION, Truth.HIDDEN)))

    @property
    def gap_called_material(self) -> int:
        """Number of samples in gaps that are MEASURED."""
        return int(((self.expected == Truth.GAP) & (self.status == Status.MEASURED)).sum())

    @property
    def material_called_gap(self) -> int:
        """Number of samples on ink that are GAP."""
        return int(((self.expected == Truth.MEASURED) & (self.status == Status.GAP)).sum())

    def within(self, sigmas: float) -> float:
        """Return the share of errors that are within this number of their own sigmas."""
        return _share(np.abs(self.error) <= sigmas * self.sigma, np.isfinite(self.error))

    @property
    def _off(self) -> Mask:
        """Which samples (N,) are off by more than is tolerated."""
        limit = np.maximum(WRONG_ERROR_M, WRONG_SHARE * self.true)
        off: Mask = np.abs(self.thickness - self.true) > limit
        return off


def merge(parts: Sequence[Comparison]) -> Comparison:
    """Return all samples of several prints as one comparison."""
    return Comparison(*(np.concatenate([getattr(part, field.name) for part in parts])
                        for field in fields(Comparison)))


def compare_scene(scene: StressScene, method: str) -> Comparison:
    """Measure a scene by a method; a sample that is missing in the profile is NO_DATA."""
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
    """Compare a profile with the true widths (N,) [m], all of which can be known."""
    expected = np.where(true > 0, Truth.MEASURED, Truth.GAP).astype(np.uint8)
    return Comparison(true, expected, profile.status, profile.thickness, profile.sigma,
                      np.array((profile.processing_time,)))


def _share(flags: Mask, among: Mask) -> float:
    """Return the share of set flags (N,) among chosen samples; NaN = none chosen."""
    return float(flags[among].mean()) if among.any() else np.nan


def _mean(values: Array) -> float:
    """Return the mean of finite values; NaN = there are none."""
    return float(np.nanmean(values)) if np.isfinite(values).any() else np.nan
