"""What pairs of strands and turns tell."""

from __future__ import annotations

from itertools import groupby

import numpy as np

from bpc_perception.core.amounts import lengths
from bpc_perception.core.arrays import Array, Flags
from bpc_perception.core.printability.flat_print import FlatPrint, lay_flat, Outline
from bpc_perception.core.printability.fusion import FARTHEST, fusion_metrics
from bpc_perception.core.printability.turns import NARROWEST, WIDEST
from bpc_perception.core.printability.uncertainty import sigma_of_mean
from bpc_perception.core.profile import Status
from bpc_perception.core.testprints.finding import Finding
from bpc_perception.core.testprints.matching import MatchedPrint
from bpc_perception.core.testprints.plan import Part

FUSED = 0.5  # share of what lies beside each other, from which on strands fuse
AROUND_APEX = 0.5  # widths of path to either side of an apex, that tell its width
LEG_FROM = 2.0  # widths from the apex, where a leg begins


def judge_fusion(matched: MatchedPrint) -> list[Finding]:
    """Return how far each pair of strands is fused, and at which distance they begin to."""
    strands = matched.test.numbers(Part.STRAND)
    flat = lay_flat(matched.profile_of(*strands))
    of_sample = matched.stroke[flat.index]
    junction = matched.profile.status[flat.index] == Status.JUNCTION
    nozzle = matched.test.nozzle
    found, shares = [], []
    for pair, grouped in groupby(strands, key=lambda index: matched.test.plans[index].pair):
        members = list(grouped)
        own = np.isin(of_sample, members)
        distance = matched.test.plans[members[-1]].distance
        part = flat.where(own)
        metrics = fusion_metrics(part, junction[own], nozzle)
        # The first is the distance, which is planned.
        found += [Finding.of_metric(metric, f'pair {pair}', distance, 'm')
                  for metric in metrics[1:]]
        share = _share(part, metrics[1].value, metrics[1].sigma, distance, pair)
        found.append(share)
        shares.append(share)
    return [_fusing_distance(shares), *found]


def _share(flat: FlatPrint, fused: float, sigma: float, distance: float, pair: int) -> Finding:
    """Return which share of a pair is fused; NaN where that is not known.

    Strands that lie nearer than a pixel are told from the path alone: as far apart as a strand is
    wide, or less, they touch; whether they do beyond that is not seen.
    """
    of, name = f'pair {pair}', 'fused_share'
    step = lengths(flat.arc_length, flat.stroke)
    length = float(step.sum()) / 2
    if len(np.unique(flat.stroke)) != 2:
        note = 'the pair is not printed'
    elif distance > FARTHEST * flat.width:  # no neighbours: nothing is fused
        return Finding(of, distance, 'm', name, 0.0, flat.spacing / length, '',
                       len(flat.stroke))
    elif np.isnan(fused):
        note = 'too little of it is seen beside the other'
    elif (fused > 0 and distance > flat.width
          and float(step[flat.outline == Outline.MEASURED].sum()) < length):
        note = 'they lie too near for the camera to see whether they touch'
    else:
        return Finding(of, distance, 'm', name, min(fused / length, 1.0), sigma / length, '',
                       len(flat.stroke))
    return Finding(of, distance, 'm', name, np.nan, np.nan, '', 0, note)


def _fusing_distance(shares: list[Finding]) -> Finding:
    """Return the distance between the lines of strands, below which they fuse.

    It lies between the nearest pair that is apart and the farthest that is fused, anywhere.
    """
    name = 'fusing_distance'
    known = sorted((share.at, share.value) for share in shares if not np.isnan(share.value))
    fused = [at for at, value in known if value >= FUSED]
    apart = [at for at, value in known if value < FUSED]
    if not known:
        return Finding.of_print(name, np.nan, np.nan, 'm', 0, 'no pair is seen')
    if not fused or not apart:
        side = (f'all are apart, to {1e3 * known[0][0]:g} mm' if not fused else
                f'all are fused, to {1e3 * known[-1][0]:g} mm')
        return Finding.of_print(name, np.nan, np.nan, 'm', len(known),
                                f'{side}; print other distances')
    if max(fused) > min(apart):
        return Finding.of_print(name, np.nan, np.nan, 'm', len(known),
                                'a pair is fused that lies farther apart than one that is not')
    between = min(apart) - max(fused)
    return Finding.of_print(name, (min(apart) + max(fused)) / 2, between / np.sqrt(12), 'm',
                            len(known))


def judge_turns(matched: MatchedPrint) -> list[Finding]:
    """Return how wide each turn is at its apex, and where its bead lies there."""
    flat = lay_flat(matched.profile_of(*matched.test.numbers(Part.TURN)))
    of_sample, along = matched.stroke[flat.index], matched.along[flat.index]
    measured = matched.profile.status[flat.index] == Status.MEASURED
    found, good = [], []
    for index in matched.test.numbers(Part.TURN):
        plan = matched.test.plans[index]
        of = f'turn of {np.degrees(plan.angle):.0f} deg, radius {1e3 * plan.radius:.2f} mm'
        apex = matched.test.design.strokes[index].length / 2
        away = np.where(of_sample == index, np.abs(along - apex), np.inf)
        relative = _relative_width(flat, measured, away, of, float(np.degrees(plan.angle)))
        found += relative
        if not np.isnan(relative[0].value):
            good.append(NARROWEST <= relative[0].value <= WIDEST)
    return [_fidelity(good, len(matched.test.numbers(Part.TURN))), *found]


def _relative_width(flat: FlatPrint, measured: Flags, away: Array, of: str,
                    angle: float) -> list[Finding]:
    """Return the width at an apex as a share of that of its legs, and the offset of the bead.

    Args:
        flat: the print.
        measured: (N,) samples.
        away: (N,) from the apex, along the stroke [m]; infinite on others.
        of: which turn it is.
        angle: of it [deg].
    """
    near = away <= max(AROUND_APEX * flat.width, 1.5 * flat.spacing)
    leg = np.isfinite(away) & (away >= LEG_FROM * flat.width) & measured
    names = 'relative_width_at_apex', 'offset_to_left_at_apex'
    units = '', 'm'
    seen = near & measured
    if not np.isfinite(flat.width) or not leg.any() or not seen.any():
        note = ('its legs are not measured' if not leg.any() else
                'at its apex the width is not measured')
        return [Finding(of, angle, 'deg', name, np.nan, np.nan, unit, 0, note)
                for name, unit in zip(names, units, strict=True)]
    width = (flat.left + flat.right)
    usual, count = float(np.median(width[leg])), int(seen.sum())
    value = float(width[seen].mean()) / usual
    sigma = sigma_of_mean(flat.sigma[seen], flat.spacing * count, 1) / usual
    offset = float(((flat.left - flat.right) / 2)[seen].mean())
    return [Finding(of, angle, 'deg', names[0], value, float(sigma), units[0], count),
            Finding(of, angle, 'deg', names[1], offset, float(sigma * usual / 2), units[1], count)]


def _fidelity(good: list[bool], planned: int) -> Finding:
    """Return the share of turns whose width at the apex is as it should be."""
    name = 'turn_fidelity'
    if not good:
        return Finding.of_print(name, np.nan, np.nan, '', 0,
                                'at none of the turns is the width measured')
    share = float(np.mean(good))
    fair = (share * len(good) + 1) / (len(good) + 2)  # never surely 0 or 1
    note = f'{planned - len(good)} more turns are not measured' * (len(good) < planned)
    return Finding.of_print(name, share, float(np.sqrt(fair * (1 - fair) / (len(good) + 3))), '',
                            len(good), note)
