"""Captures and advice in plain numbers, for summary.json and the lines of ``--json``.

Lengths are in millimetres, as everything that people read.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from bpc_perception.core.advice.rate_advice import RateAdvice
from bpc_perception.core.amounts import Amount, amount_of
from bpc_perception.core.design.comparison import DesignFindings
from bpc_perception.core.design.deviation import Spread
from bpc_perception.core.inspection.verdict import PrintVerdict
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.repair.plan import RepairPlan
from bpc_perception.core.result import Result
from bpc_perception.display.units import MM_PER_M, NS_PER_S, UL_PER_M3
from bpc_perception.display.wording import cause_counts


def result_entry(result: Result) -> dict[str, Any]:
    """Return the entry of a capture, which was measured or refused."""
    if result.profile is None:
        return {'capture': None, **_time(result.capture.stamp_ns), 'refusal': result.refusal}
    return profile_entry(result.profile)


def profile_entry(profile: ThicknessProfile) -> dict[str, Any]:
    """Return the entry of a capture that was measured."""
    counts = np.bincount(profile.status, minlength=len(Status))
    summary = profile.summary
    return {
        'print_id': profile.print_id, 'capture': profile.capture, **_time(profile.stamp_ns),
        'processing_time_s': profile.processing_time, 'samples': len(profile),
        'path_length_mm': float(np.ptp(profile.arc_length)) * MM_PER_M if len(profile) else 0.0,
        'thickness_mean_mm': summary.thickness_mean * MM_PER_M,
        'thickness_std_mm': summary.thickness_std * MM_PER_M,
        'coverage': summary.coverage,
        'gap_count': summary.gap_count,
        'gap_length_mm': summary.gap_length * MM_PER_M,
        'ooze_count': summary.ooze_count,
        'ooze_length_mm': summary.ooze_length * MM_PER_M,
        'bare_length_mm': summary.bare_length * MM_PER_M,
        'counts': {status.name: int(counts[status]) for status in Status},
        'causes': {cause.name: count for cause, count in cause_counts(profile).items()},
    }


def stroke_entries(profile: ThicknessProfile) -> list[dict[str, Any]]:
    """Return an entry for each stroke; None where the begin or end of its ink was not seen."""
    strokes = profile.strokes
    columns = np.concatenate((strokes.commanded, strokes.ink, strokes.lag), axis=1) * MM_PER_M
    names = ('start_mm', 'end_mm', 'ink_start_mm', 'ink_end_mm', 'start_lag_mm', 'end_lag_mm')
    entries = []
    for number, row in zip(strokes.number.tolist(), columns.tolist(), strict=True):
        own = profile.stroke == number
        entries.append({'stroke': number, **dict(zip(names, row, strict=True)),
                        'layer': int(np.bincount(profile.layer[own]).argmax()),
                        **amount_entry(amount_of(profile, own))})
    return entries


def verdict_entry(verdict: PrintVerdict) -> dict[str, Any]:
    """Return the entry of a verdict, with its defects."""
    return {
        'verdict': verdict.verdict.name, 'ended': verdict.ended,
        'judged': sorted(kind.name for kind in verdict.judged),
        'strokes': [{'stroke': each.number, 'layer': each.layer, 'verdict': each.verdict.name,
                     'seen': each.seen} for each in verdict.strokes],
        'layers': [{'layer': each.number, 'verdict': each.verdict.name, 'seen': each.seen}
                   for each in verdict.layers],
        'defects': [{'kind': each.kind.name, 'stroke': each.stroke, 'layer': each.layer,
                     'start_mm': each.start * MM_PER_M, 'end_mm': each.end * MM_PER_M,
                     'worst_mm': each.worst * MM_PER_M, 'limit_mm': each.limit * MM_PER_M,
                     'samples': each.samples} for each in verdict.defects]}


def design_entry(found: DesignFindings) -> dict[str, Any]:
    """Return the entry of a print beside its design."""
    place, name = found.registration, found.name
    if place.refusal:
        return {'file': name, 'refusal': place.refusal}
    x, y, z = (place.T_base_design[:3, 3] * MM_PER_M).tolist()
    yaw, _, _ = Rotation.from_matrix(place.T_base_design[:3, :3]).as_euler('zyx', degrees=True)
    return {
        'file': name, 'refusal': '', 'x_mm': x, 'y_mm': y, 'z_mm': z, 'yaw_degrees': float(yaw),
        'residual_mm': place.residual * MM_PER_M,
        **{f'{what}_off': _spread_entry(spread) for what, spread in (
            ('nozzle', found.nozzle), ('bead', found.bead), ('width', found.width))},
        'layers': [{'layer': each.layer, 'fidelity': each.fidelity, 'known': each.known,
                    'designed': each.designed, 'hausdorff_mm': each.hausdorff * MM_PER_M,
                    'to_print_95_mm': each.to_print.most_of_95 * MM_PER_M,
                    'to_design_95_mm': each.to_design.most_of_95 * MM_PER_M}
                   for each in found.layers],
        'missing': [{'stroke': each.stroke + 1, 'layer': each.layer,
                     'presence': each.presence.name, 'start_mm': each.start * MM_PER_M,
                     'end_mm': each.end * MM_PER_M} for each in found.missing],
        'surplus': [{'start_mm': start, 'end_mm': end} for start, end in (
            found.surplus * MM_PER_M).tolist()]}


def design_numbers(summary: dict[str, Any]) -> dict[str, float | None]:
    """Return from a summary how far a print is from its design; None = not known, or none."""
    design = summary.get('design')
    if not isinstance(design, dict) or design.get('refusal'):
        return {'design_off_mm': None, 'layer_fidelity': None}
    known = [layer for layer in design['layers'] if layer['fidelity'] is not None]
    points = sum(layer['known'] for layer in known)
    fidelity = (sum(layer['fidelity'] * layer['known'] for layer in known) / points if points
                else None)
    return {'design_off_mm': design['bead_off']['most_of_95_mm'], 'layer_fidelity': fidelity}


def _spread_entry(spread: Spread) -> dict[str, Any]:
    return {'samples': spread.count, 'mean_mm': spread.mean * MM_PER_M,
            'rms_mm': spread.rms * MM_PER_M, 'most_mm': spread.most * MM_PER_M,
            'most_of_95_mm': spread.most_of_95 * MM_PER_M}


def repair_entry(plan: RepairPlan) -> dict[str, Any]:
    """Return the entry of what is proposed for the finished layers of a print."""
    finished = plan.finished
    return {
        'layers': [{
            'layer': each.number, 'next_layer': each.state.next_layer.name,
            'obstacles': [obstacle.name for obstacle in each.state.obstacles],
            'seen': each.state.seen, 'longest_gap_mm': each.state.longest_gap * MM_PER_M,
            'longest_unseen_mm': each.state.longest_unseen * MM_PER_M,
            'height_mm': each.state.height * MM_PER_M,
            'highest_mm': each.state.highest * MM_PER_M,
            'lowest_mm': each.state.lowest * MM_PER_M} for each in finished],
        'fills': [{
            'fill': number, 'kind': each.kind.name, 'layer': each.layer, 'stroke': each.stroke,
            'start_mm': each.start * MM_PER_M, 'end_mm': each.end * MM_PER_M,
            'volume_mm3': each.volume * MM_PER_M**3, 'speed_mm_s': each.speed * MM_PER_M,
            'largest_flow_mm3_s': float(each.flow.max()) * MM_PER_M**3}
            for number, each in enumerate(plan.fills, 1)],
        'unfilled': [{
            'kind': each.kind.name, 'layer': each.layer, 'stroke': each.stroke,
            'start_mm': each.start * MM_PER_M, 'end_mm': each.end * MM_PER_M,
            'reason': each.reason.name} for layer in finished for each in layer.unfilled]}


def layer_entries(profile: ThicknessProfile) -> list[dict[str, Any]]:
    """Return an entry for each layer, from the bed upward."""
    entries = []
    for number in np.unique(profile.layer[profile.layer >= 0]).tolist():
        own = profile.layer == number
        gaps = profile.runs_of(profile.missing & own)
        entries.append({'layer': number, **amount_entry(amount_of(profile, own)),
                        'gap_count': len(gaps),
                        'gap_length_mm': float(np.diff(gaps).sum()) * MM_PER_M})
    return entries


def amount_entry(amount: Amount) -> dict[str, Any]:
    """Return the entry of the ink along a part of a print."""
    return {
        'length_mm': amount.length * MM_PER_M, 'known': amount.known,
        'thickness_mean_mm': amount.thickness * MM_PER_M,
        'height_mean_mm': amount.height * MM_PER_M, 'area_mean_mm2': amount.area * MM_PER_M**2,
        'volume_mm3': amount.volume * MM_PER_M**3,
        'volume_sigma_mm3': amount.volume_sigma * MM_PER_M**3,
        'commanded_mm3': amount.commanded * MM_PER_M**3,
        'delivered': amount.delivered, 'delivered_sigma': amount.delivered_sigma}


def _time(stamp_ns: int) -> dict[str, Any]:
    """Return a stamp in seconds and in nanoseconds: a float of seconds cannot hold all of it."""
    return {'time_s': stamp_ns / NS_PER_S, 'stamp_ns': stamp_ns}


def advice_entry(advice: RateAdvice) -> dict[str, Any]:
    """Return the entry of an advice."""
    return {
        'valid': advice.valid,
        'reason': advice.reason.name,
        'flow_rate_scale': advice.flow_rate_scale,
        'speed_scale': advice.speed_scale,
        'target_thickness_mm': advice.target_thickness * MM_PER_M,
        'measured_thickness_mm': advice.measured_thickness * MM_PER_M,
        'expected_thickness_mm': advice.expected_thickness * MM_PER_M,
        'by_volume': advice.by_volume,
        'measured_area_mm2': advice.measured_area * MM_PER_M**2,
        'spreading_per_s': advice.spreading,
        'delivery': advice.delivery,
        'delivery_sigma': advice.delivery_sigma,
        'lag_s': round(advice.lag, 6),
        'flow_rate_in_force_ul_per_s': advice.flow_rate_in_force * UL_PER_M3,
        'speed_in_force_mm_per_s': advice.speed_in_force * MM_PER_M,
        'window_start_mm': advice.window[0] * MM_PER_M,
        'window_end_mm': advice.window[1] * MM_PER_M,
        'sample_count': advice.sample_count,
        'confidence': advice.confidence,
        'measurement_age_s': advice.measurement_age,
        'valid_until_s': advice.valid_until_ns / NS_PER_S,
        'valid_until_ns': advice.valid_until_ns,
    }
