"""The section of a bead: how high it is, and how much ink it holds.

Between the edges that the picture shows, u = -1 .. 1, a bead is h = d + s (1 - u^2)(1 + r u^2)
above the feet of its section. r = 0 is a parabola, which describes a laid bead as well as an arc
or a cosine [Suryakumar et al. 2011; Xiong et al. 2013, of welded beads]; r near 1 is a flat one
with round edges. The shape r is that of a centimetre of path, and about that of all other beads.
Rise s and level d are fitted to the cloud of a millimetre: the cloud is noisier than a bead is
uneven. So missing flanks are bridged.

A cloud that lies below the surface of the ink, as it does where light goes into it, meets the feet
before the edges: d is below 0. Then nothing is told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bpc_perception.core.arrays import Array, Flags, Index
from bpc_perception.core.filters import masked_median, running_median, windows_around
from bpc_perception.core.measurement.cross_section.pooled_fit import (
    fit_without_outliers,
    pooled_fit,
    PooledFit,
    UNKNOWN_M,
    without_outliers,
)

# To either side along the path: of height, of shape, of how deep light goes.
POOLED_M, SHAPED_M, DEEP_M = 7e-4, 5e-3, 2e-2
FITTED = 0.85  # of half a width; farther out points are rare, and mixed with what lies beside
CENTRAL = 0.3
ROUNDS = 3
WILD_M = 2e-3  # from what is usual along the path: no point of the bead
# Neighbours in a cloud err alike, and a bead is not quite of this shape: sigmas are so much larger
# than those of points by themselves. Found with simulated beads, of 0.6 to 2.5 mm.
SIGMA_GAIN = 1.35
ROUNDNESS_SIGMA, LEAST_ROUND, MOST_ROUND = 0.3, -0.4, 1.5  # of r, as it is among beads
ROUNDNESS_VARIES = 0.1  # from bead to bead of one ink, and from layer to layer
RISE_SIGMA = 0.08  # by which a bead is higher than around it, as a share of its height
# So far below its feet comes the cloud of ink that light goes into; of a flat bead that is less
# surely known.
TOO_DEEP_SIGMAS, TOO_DEEP_M, FLAT_TOO_DEEP_M = 3.0, 5e-5, 1e-4


@dataclass(frozen=True)
class Shapes:
    """The sections of N beads; NaN where the cloud does not tell.

    Attributes:
        level: (N,) d, height of the bead's feet above those of its section [m].
        rise: (N,) s [m].
        roundness: (N,) r.
        covariance: (N, 2, 2) of level and rise [m^2].
        deep: (N,) whether the cloud lies below the surface of the ink.
    """

    level: Array
    rise: Array
    roundness: Array
    covariance: Array
    deep: Flags

    def at(self, u: Array) -> Array:
        """Return how high the ink is above the feet of the sections (N, K) at places (K,) [m]."""
        return self.level[:, None] + self.rise[:, None] * shape(u, self.roundness[:, None])

    @property
    def crest(self) -> tuple[Array, Array]:
        """How high the highest place is above the feet of the sections, and its sigma (N,) [m]."""
        with np.errstate(invalid='ignore', divide='ignore'):
            place = np.sqrt(np.where(self.roundness > 1, (1 - 1 / self.roundness) / 2, 0.0))
        high = shape(place, self.roundness)
        return self.level + self.rise * high, self.sigma_of(np.ones_like(high), high)

    def sigma_of(self, of_level: Array, of_rise: Array) -> Array:
        """Return the 1-sigma uncertainty (N,) of sums of level and rise [m]."""
        part = np.stack((of_level, of_rise), axis=1)
        variance = np.einsum('ni,nij,nj->n', part, self.covariance, part)
        return np.sqrt(np.maximum(variance, 0.0))


def shape(u: Array, roundness: Array) -> Array:
    """Return the height of a bead of rise 1 at u, -1 .. 1 from edge to edge."""
    return np.asarray((1 - u**2) * (1 + roundness * u**2))


@dataclass(frozen=True)
class Roundness:
    """What is known beforehand of how round beads are: r, and its 1-sigma uncertainty."""

    usual: float = 0.0
    sigma: float = ROUNDNESS_SIGMA

    @classmethod
    def like(cls, area: Array, rise: Array, width: Array) -> Roundness:
        """Return that beads are as round as others of this ink.

        Args:
            area: (N,) of the cross-sections of the others [m^2].
            rise: (N,) height of their crests above their feet [m].
            width: (N,) [m].
        """
        with np.errstate(invalid='ignore', divide='ignore'):
            filled = area / (rise * width)  # (2/3 + 2/15 r) of a bead that is highest amid
        known = np.isfinite(filled)
        if not known.any():
            return cls()
        usual = np.clip(7.5 * float(np.median(filled[known])) - 5, LEAST_ROUND, MOST_ROUND)
        return cls(float(usual), ROUNDNESS_VARIES)


ANY_ROUNDNESS = Roundness()


def fit_shapes(u: Array, height: Array, piece: Index, spacing: float, foot_sigma: Array,
               repeated: float = 1.0, round_like: Roundness = ANY_ROUNDNESS) -> Shapes:
    """Fit sections of beads to points of the cloud.

    Args:
        u: (N, M) of points across N beads, -1 .. 1 from edge to edge; NaN = none.
        height: (N, M) of the same points above the feet of the sections [m].
        piece: (N,) number of the piece of path that each is on, never falling.
        spacing: between path points [m].
        foot_sigma: (N,) 1-sigma uncertainty of the feet of the sections [m].
        repeated: how often each point of the cloud is among those given.
        round_like: what is known of how round they are.
    """
    near, wide = (windows_around(piece, round(reach / spacing)) for reach in (POOLED_M, SHAPED_M))
    usual = running_median(masked_median(height, np.abs(u) < CENTRAL),
                           2 * round(SHAPED_M / spacing) + 1, piece)
    fitted = (np.abs(u) <= FITTED) & (np.abs(height - usual[:, None]) < WILD_M)
    basis = (np.ones_like(u), 1 - u**2, u**2 * (1 - u**2))
    bend_sigma = ROUNDNESS_SIGMA * np.abs(usual)
    free, fitted = fit_without_outliers(
        basis, height, fitted, wide, WILD_M * float(np.sqrt(repeated)),
        (UNKNOWN_M, UNKNOWN_M, bend_sigma), repeated, ROUNDS)
    fitted, noise = without_outliers(free.residual(basis, height), fitted, repeated)
    # No ink is more pointed than a parabola: fitted by one, its feet would lie too high.
    parabola = pooled_fit(basis[:2], height, fitted, wide, noise, (UNKNOWN_M, UNKNOWN_M))
    along = 2 * round(DEEP_M / spacing) + 1, piece
    deep = (_below_feet(parabola, foot_sigma, TOO_DEEP_M, *along)
            | _below_feet(free, foot_sigma, FLAT_TOO_DEEP_M, *along))
    level, rise, roundness = _fit_alike(u, height, fitted, wide, noise, usual, foot_sigma,
                                        round_like)
    profile = shape(u, roundness[:, None])
    known = fitted & np.isfinite(roundness)[:, None]
    # A bead hangs now lower, now higher, but is about as high as before and behind.
    here = pooled_fit((basis[0], profile), height - level[:, None] - rise[:, None] * profile,
                      known, near, noise, (foot_sigma, RISE_SIGMA * np.abs(rise)))
    level, rise = level + here.values[:, 0], rise + here.values[:, 1]
    good = (rise > 0) & ~deep
    level, rise, roundness = (np.where(good, values, np.nan)
                              for values in (level, rise, roundness))
    return Shapes(level, rise, roundness,
                  np.where(good[:, None, None], SIGMA_GAIN**2 * here.covariance, np.nan),
                  deep)


def _fit_alike(u: Array, height: Array, fitted: Flags, window: tuple[Index, Index],
               noise: float, usual: Array, foot_sigma: Array,
               round_like: Roundness) -> Array:
    """Return level, rise and roundness (3, N) of beads that are about as round as the others.

    Beads of one ink and nozzle are alike, and a single one tells its roundness badly: where a
    strand hangs, so do its feet.
    """
    basis = (np.ones_like(u), shape(u, np.full(1, round_like.usual)), u**2 * (1 - u**2))
    alone = pooled_fit(basis, height, fitted, window, noise,
                       (foot_sigma, UNKNOWN_M, round_like.sigma * np.abs(usual)))
    alike = round_like.usual + _mean_bend(alone, round_like.sigma, usual, window)
    basis = basis[0], shape(u, np.full(1, alike)), basis[2]
    level, rise, bend = pooled_fit(
        basis, height, fitted, window, noise,
        (foot_sigma, UNKNOWN_M, ROUNDNESS_VARIES * np.abs(usual))).values.T
    with np.errstate(invalid='ignore', divide='ignore'):
        roundness = np.clip(alike + bend / rise, LEAST_ROUND, MOST_ROUND)
    return np.stack((level, rise, roundness))


def _mean_bend(fit: PooledFit, sigma: float, usual: Array, window: tuple[Index, Index]) -> float:
    """Return the mean bend of beads per rise, weighed by what each tells of it.

    Args:
        fit: level, rise and bend of N beads, fitted over windows.
        sigma: how far from 0 it may be, as was known beforehand.
        usual: (N,) rise of the beads [m].
        window: first row of each, and that behind its last.
    """
    rise, bend, variance = fit.values[:, 1], fit.values[:, 2], fit.covariance[:, 2, 2]
    share = rise / (window[1] - window[0])  # each point is in as many windows
    with np.errstate(invalid='ignore', divide='ignore'):
        told = share * bend / variance
        weight = share * rise * np.maximum(
            1 / variance - 1 / (sigma * usual)**2, 0)
        known = np.isfinite(told + weight) & (rise > 0)
    return float(told[known].sum() / (weight[known].sum() + 1 / sigma**2))


def _below_feet(fit: PooledFit, foot_sigma: Array, least: float, window: int,
                piece: Index) -> Flags:
    """Return where (N,) beads come down to their edges below their feet, at least so far [m].

    Light goes into ink everywhere: what is usual along a window counts.
    """
    unsure = SIGMA_GAIN * np.sqrt(fit.covariance[:, 0, 0] + foot_sigma**2)
    level = running_median(fit.values[:, 0], window, piece)
    return np.asarray(level < -np.maximum(least, TOO_DEEP_SIGMAS * unsure))
