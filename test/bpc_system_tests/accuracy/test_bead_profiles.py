"""Heights of beads in real laser profiles, with points that lie far off.

They were taken of layer 25 of a thin wall during deposition: 399 scans of up to 56 points across,
lateral place and range in millimetres. They lie in ``data/bead_profiles`` of the folder ``shared``
beside the repository, with their own licence. There is no truth: what the eye sees is a flat top,
which most scans show in many points.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from bpc_perception.core.arrays import Array
from bpc_perception.core.measurement.cross_section.height import fit_shapes
from bpc_system_tests.accuracy.published import beside_repository

FILE = Path('shared/data/bead_profiles/Representative_Layer_raw_points.csv')
MM = 1e-3
HALF_M = 0.95 * MM  # of the bead, which its points show where nothing is missing
STEP_M = 0.1 * MM  # along the wall, from scan to scan; only the order matters
MOST_POINTS = 56
LEAST_TOP = 8  # points of a flat top that tell by eye how high it is


@pytest.fixture(scope='module')
def scans() -> list[Array]:
    """Places and heights (K, 2) of the points of each scan [m]."""
    file = beside_repository(FILE)
    if file is None:
        pytest.skip('the published profiles are not beside the repository')
    points: dict[str, list[tuple[float, float]]] = {}
    with file.open(encoding='utf-8', newline='') as stream:
        for row in csv.DictReader(stream):
            points.setdefault(row['ScanID'], []).append((float(row['X']), -float(row['Z'])))
    return [np.array(scan) * MM for scan in points.values()]


@pytest.fixture(scope='module')
def crest(scans: list[Array]) -> Array:
    """The heights (S,) that the fit tells [m]."""
    u, height = np.full((2, len(scans), MOST_POINTS), np.nan)
    level = np.median([np.median(scan[:, 1]) for scan in scans])
    for number, scan in enumerate(scans):
        u[number, :len(scan)] = (scan[:, 0] - np.median(scan[:, 0])) / HALF_M
        height[number, :len(scan)] = scan[:, 1] - level
    piece = np.zeros(len(scans), np.intp)
    return fit_shapes(u, height, piece, STEP_M, np.full(len(scans), 5 * MM)).crest[0] + level


def by_eye(scan: Array) -> float:
    """The flat top of a scan [m]: where most points are, of the upper half; NaN = not seen."""
    height = scan[:, 1]
    near = np.sort(height[np.abs(height - np.median(height)) < 1 * MM])
    if len(near) < 2 * LEAST_TOP:
        return np.nan
    spread = near[LEAST_TOP:] - near[:-LEAST_TOP]
    densest = int(np.argmin(spread))
    return float(near[densest:densest + LEAST_TOP].mean())


def test_heights_are_those_of_the_tops_that_are_seen(scans: list[Array], crest: Array) -> None:
    seen = np.array([by_eye(scan) for scan in scans])
    told = np.isfinite(crest) & np.isfinite(seen)
    assert told.sum() > 0.5 * len(scans)
    off = np.abs(crest - seen)[told]
    assert np.median(off) < 0.1 * MM
    assert np.quantile(off, 0.9) < 0.3 * MM


def test_points_far_off_do_not_move_a_height(scans: list[Array], crest: Array) -> None:
    """The series goes on evenly although single points are up to 8 mm off."""
    outliers = sum(int((np.abs(scan[:, 1] - np.median(scan[:, 1])) > 2 * MM).sum())
                   for scan in scans)
    assert outliers > 100
    steps = np.abs(np.diff(crest))
    assert np.nanmedian(steps) < 0.05 * MM
    assert np.nanquantile(steps, 0.99) < 0.6 * MM
