"""Profiles, compared with the truth of the simulated print."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bpc_perception.core.arrays import Array
from bpc_perception.core.geometry import invert, transform
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_sim.printer.print_job import PrintJob

MILLIMETRE_M = 1e-3


@dataclass(frozen=True)
class Comparison:
    """A profile of a complete print, compared with the truth sample by sample.

    Attributes:
        profile: the measured profile.
        s: (N,) arc length of the point of the true curve nearest to each sample [m].
        width: (N,) true width there [m]; 0 in gaps.
        from_end: (N,) distance along the curve to the nearest end of a run of ink [m].
    """

    profile: ThicknessProfile
    s: Array
    width: Array
    from_end: Array

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Which samples (N,) carry a thickness."""
        return np.asarray(self.profile.status == Status.MEASURED)

    @property
    def gap(self) -> NDArray[np.bool_]:
        """Which samples (N,) are called a gap."""
        return np.asarray(self.profile.status == Status.GAP)

    @property
    def bare(self) -> NDArray[np.bool_]:
        """Which samples (N,) are seen without ink, whether it was commanded or not."""
        return np.asarray(np.isin(self.profile.status, (Status.GAP, Status.BARE)))

    @property
    def error(self) -> Array:
        """Measured less true thickness (N,) [m]; NaN where neither MEASURED nor GAP."""
        return self.profile.thickness - self.width


def compare(profile: ThicknessProfile, job: PrintJob) -> Comparison:
    """Compare a profile with its print."""
    s = job.commanded.curve.uniform(20001)
    points = transform(invert(job.T_base_surface), profile.points)
    distance, nearest = cKDTree(job.commanded.curve.points(s)).query(points[:, :2])
    astray = distance >= 0.5 * MILLIMETRE_M
    assert not astray.any(), (f'the recorded path leaves the true one at {points[astray]} '
                              f'of {len(points)} points, samples {np.flatnonzero(astray)}')
    s = s[nearest]
    ends = job.deposit.runs.ravel()
    return Comparison(profile, s, job.truth(s), np.abs(s[:, None] - ends).min(axis=1))


def pixel_size(job: PrintJob) -> float:
    """Return the length of a pixel's side on the bed, in the middle of the image [m]."""
    view = job.view
    distance = float(np.linalg.norm(view.T_base_camera[:3, 3] - job.T_base_surface[:3, 3]))
    return distance / view.camera.focal_length


def expect_the_truth(compared: Comparison, pixel: float) -> None:
    """Fail unless a complete profile is right everywhere, except next to the ends of its runs.

    An edge in the image is good to a fraction of a pixel. Within two pixels of the end of a run
    the blurred end mixes into what is seen across the path.
    """
    clear = compared.from_end > 2 * pixel
    inked = compared.width > 0
    assert clear.sum() > 0.9 * len(clear)
    # A wrong MEASURED is the worst of all errors: there must be none.
    assert not (clear & compared.measured & ~inked).any()
    assert not (clear & compared.bare & inked).any()
    # The complete print is in plain view.
    known = compared.measured | compared.bare
    unknown = clear & ~known
    assert known[clear].mean() > 0.98, np.column_stack((
        compared.s[unknown], compared.profile.status[unknown]))
    error = np.abs(compared.error[clear & compared.measured])
    assert error.mean() < 0.15 * pixel
    assert error.max() < 0.5 * pixel
