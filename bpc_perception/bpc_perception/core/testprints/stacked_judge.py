"""What a lattice, a line over lines, and a wall tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.printability.assess import assess, Conditions
from bpc_perception.core.printability.collapse import collapse_metrics
from bpc_perception.core.printability.flat_print import lay_flat
from bpc_perception.core.printability.strands import strand_metrics
from bpc_perception.core.printability.uncertainty import OF_PRINT, sigma_of_mean
from bpc_perception.core.profile import Status
from bpc_perception.core.testprints.finding import Finding
from bpc_perception.core.testprints.matching import MatchedPrint
from bpc_perception.core.testprints.plan import Part

OF_LATTICE = ('pore_area', 'pore_printability', 'mesh_printability', 'pore_size_accuracy',
              'width', 'filament_to_nozzle_ratio', 'continuity', 'uniformity', 'stability')
OF_STRAND = ('width', 'continuity')


def judge_lattice(matched: MatchedPrint) -> list[Finding]:
    """Return the pores of a lattice, and how wide and even its strands are."""
    profile = matched.profile_of(*matched.test.numbers(Part.STRAND))
    target = np.full(len(profile), float(matched.test.design.strokes[-1].widths[0]))
    result = assess(profile, Conditions(matched.test.nozzle, target))
    found = [Finding.of_metric(metric) for metric in result.metrics
             if metric.of == 'print' and metric.name in OF_LATTICE]
    for pore in result.pores:
        of, note = f'pore {pore.number}', pore.note or 'it is not told'
        found += [
            Finding(of, np.nan, '', 'pore_area', pore.area, pore.area_sigma, 'm^2', pore.samples,
                    note if np.isnan(pore.area) else pore.note),
            Finding(of, np.nan, '', 'pore_printability', pore.printability,
                    pore.printability_sigma, '', pore.samples,
                    note if np.isnan(pore.printability) else pore.note)]
    return found


def judge_line_over_lines(matched: MatchedPrint, cloud: Array | None) -> list[Finding]:
    """Return how far a line sags between the lines below, and how wide and even both are.

    Args:
        matched: the print.
        cloud: (M, 3) points of the last capture in the base frame [m]; None = not at hand.
    """
    supports = matched.test.numbers(Part.SUPPORT)
    spans = matched.test.numbers(Part.SPAN)
    profile = matched.profile_of(*supports, *spans)
    # As planned: where little is seen, the path alone does not tell.
    layer = np.where(np.isin(matched.stroke, spans), 1, np.where(profile.stroke > 0, 0, -1))
    flat = lay_flat(replace(profile, layer=layer))
    sags = collapse_metrics(flat, profile.height[flat.index], cloud)
    distances = [matched.test.plans[index].distance for index in supports[1:]]
    found = ([Finding.of_metric(metric, f'span {number}', distance, 'm')
              for number, (metric, distance) in enumerate(zip(sags, distances, strict=True), 1)]
             if len(sags) == len(distances) and sags[0].of != 'print'
             else [Finding.of_metric(metric) for metric in sags])
    for name, indices in (('lines below', supports), ('line across', spans)):
        chosen = np.isin(matched.stroke[flat.index], indices)
        if not chosen.any():
            found.append(Finding(name, np.nan, '', 'continuity', np.nan, np.nan, '', 0,
                                 'it is not printed'))
            continue
        found += [Finding.of_metric(metric, name) for metric in strand_metrics(
            flat, chosen, name, matched.test.nozzle, None) if metric.name in OF_STRAND]
    return found


def judge_wall(matched: MatchedPrint) -> list[Finding]:
    """Return how high and wide each layer of a wall is, and how high the wall is."""
    profile = matched.profile
    found, heights, sigmas = [], [], []
    for index in matched.test.numbers(Part.WALL):
        of, planned = f'layer {index}', matched.test.layer_height
        middle = matched.judged(index) & (profile.status == Status.MEASURED)
        for quantity, value, sigma in (
                ('layer_height', profile.height, profile.height_sigma),
                ('width', profile.thickness, profile.sigma)):
            own = middle & np.isfinite(value)
            at = planned if quantity == 'layer_height' else np.nan
            if not own.any():
                found.append(Finding(of, at, 'm' * (at == at), quantity, np.nan, np.nan, 'm', 0,
                                     'it is not seen before the next layer covers it'))
                continue
            length = float(np.median(np.diff(profile.arc_length))) * float(own.sum())
            mean, unsure = float(value[own].mean()), sigma_of_mean(sigma[own], length, 1)
            found.append(Finding(of, at, 'm' * (at == at), quantity, mean, unsure, 'm',
                                 int(own.sum())))
            if quantity == 'layer_height':
                heights.append(mean)
                sigmas.append(unsure)
    return [_wall_height(matched, np.array(heights), np.array(sigmas)), *found]


def _wall_height(matched: MatchedPrint, heights: Array, sigmas: Array) -> Finding:
    """Return the height of a wall by those of its layers [m].

    What is wrong alike in all of them adds up.
    """
    planned = len(matched.test.numbers(Part.WALL))
    if len(heights) < planned:
        return Finding.of_print('wall_height', np.nan, np.nan, 'm', len(heights),
                                f'of {planned - len(heights)} of {planned} layers the height is '
                                'not known')
    alike = np.sqrt(OF_PRINT) * sigmas.sum()
    apart = np.sqrt((1 - OF_PRINT) * np.sum(sigmas**2))
    return Finding.of_print('wall_height', float(heights.sum()), float(np.hypot(alike, apart)),
                            'm', planned)
