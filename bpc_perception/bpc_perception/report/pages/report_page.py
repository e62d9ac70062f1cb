"""The report of a measurement."""

from __future__ import annotations

from typing import Any

from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.core.targets import WidthTargets
from bpc_perception.display.layers import layers_of
from bpc_perception.display.legend import STATUS_COLOURS
from bpc_perception.display.repair_words import NOT_FILLED, repairs_in_words
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.verdict_words import (
    defect_in_words,
    NAMES,
    not_judged,
    place_in_words,
    TONES,
    verdict_in_words,
)
from bpc_perception.display.wording import (
    advice_in_words,
    cause_counts,
    CAUSES,
    label,
    MEANINGS,
)
from bpc_perception.report.figures.deviation_map import map_figure
from bpc_perception.report.figures.histogram import histogram_figure
from bpc_perception.report.figures.image import data_uri, image_figure
from bpc_perception.report.figures.offset import offset_figure
from bpc_perception.report.figures.thickness import thickness_figure
from bpc_perception.report.pages.page import mm, page, share, utc
from bpc_perception.report.print_log import PrintLog


def render(log: PrintLog, summary: dict[str, Any], targets: WidthTargets | None = None) -> str:
    """Make the page about a measured result.

    Args:
        log: with a result to report.
        summary: content of summary.json, lengths in mm.
        targets: the thickness wanted along the path; None = none.
    """
    result = log.reported
    assert result is not None
    profile, advice = result.profile, result.advice
    assert profile is not None
    assert advice is not None
    assert result.verdict is not None
    frames = capture_frames(log)
    return page(
        'report.html.j2',
        {'image': image_figure(result),
         'thickness': thickness_figure(result, targets,
                                       float(summary['settings'].get('advice.dead_band', 0))),
         'offset': offset_figure(profile),
         'map': map_figure(profile, targets),
         'histogram': histogram_figure(profile, targets)},
        summary=summary, **verdict_content(result.verdict), repair=repair_content(result.repair),
        advice_words=advice_in_words(advice),
        statuses=[(status.name, label(status), STATUS_COLOURS[status], MEANINGS[status])
                  for status in Status],
        causes=[(*CAUSES[cause], count) for cause, count in cause_counts(profile).items()],
        layers=layer_choices(profile),
        aspect=f'{result.capture.camera.width} / {result.capture.camera.height}',
        reference='median' if targets is None else 'target',
        frames=frames, shown=next(number for number, frame in enumerate(frames)
                                  if not frame['source']))


def verdict_content(verdict: PrintVerdict) -> dict[str, Any]:
    """Return what the page says of the verdict."""
    return {'verdict': verdict, 'verdict_words': verdict_in_words(verdict),
            'not_judged': not_judged(verdict), 'names': NAMES, 'tones': TONES,
            'defects': [(place_in_words(each), defect_in_words(each), each.layer, each.samples)
                        for each in verdict.defects]}


def repair_content(plan: RepairPlan | None) -> dict[str, Any] | None:
    """Return what the page says of the repair; None = nothing is finished."""
    if plan is None or not plan.finished:
        return None
    return {'lines': repairs_in_words(plan),
            'reasons': {each.name: words for each, words in NOT_FILLED.items()}}


def layer_choices(profile: ThicknessProfile) -> list[dict[str, Any]]:
    """Return the layers to choose from, and between which arc lengths [mm] each lies."""
    arc = profile.arc_length * MM_PER_M
    return [{'layer': layer, 'from': float(arc[own].min()), 'to': float(arc[own].max())}
            for layer, own in layers_of(profile)]


def capture_frames(log: PrintLog) -> list[dict[str, object]]:
    """Return the captures to leaf through: picture, time and words of each.

    The capture that is reported has no picture (its ``source`` is empty): it is drawn in full.
    """
    frames = []
    for place in sorted({*log.thumbnails.pictures, log.place}):
        entry = log.entries[place]
        picture = '' if place == log.place else data_uri(log.thumbnails.pictures[place], 'jpeg')
        frames.append({**_frame_words(entry), 'time': utc(entry['stamp_ns']), 'source': picture})
    return frames


def _frame_words(entry: dict[str, Any]) -> dict[str, object]:
    """Return what is said below the picture of a capture, and its number if it was measured."""
    if 'refusal' in entry:
        return {'words': f'refused: {entry["refusal"]}'}
    return {'words': f'{mm(entry["thickness_mean_mm"])} ± {mm(entry["thickness_std_mm"])}, '
                     f'{share(entry["coverage"])} known',
            'capture': entry['capture']}
