"""The content of summary.json."""

from __future__ import annotations

from typing import Any

from bpc_perception.core.amounts import amount_of
from bpc_perception.display.plain_json import plain
from bpc_perception.display.units import MM_PER_M
from bpc_perception.display.wording import lost_in_words
from bpc_perception.report.entries import (
    advice_entry,
    amount_entry,
    design_entry,
    layer_entries,
    repair_entry,
    stroke_entries,
    verdict_entry,
)
from bpc_perception.report.print_log import PrintLog
from bpc_perception.report.provenance import Provenance
from bpc_perception.report.uniformity import uniformity


def summarize(log: PrintLog, provenance: Provenance) -> dict[str, Any]:
    """Return the result that is reported, an entry for every capture, and the provenance."""
    result = log.reported
    assert result is not None
    profile = result.profile
    assert profile is not None
    assert result.advice is not None
    assert result.verdict is not None
    statistics, camera = profile.summary, result.capture.camera
    evenness = uniformity(profile, provenance.targets_of(result))
    content = {
        **log.entries[log.place],
        'verdict': verdict_entry(result.verdict),
        **({'design': design_entry(result.design.findings)} if result.design else {}),
        **({'repair': repair_entry(result.repair)} if result.repair else {}),
        'method': profile.method,
        'thickness_q1_mm': statistics.thickness_q1 * MM_PER_M,
        'thickness_median_mm': statistics.thickness_median * MM_PER_M,
        'thickness_q3_mm': statistics.thickness_q3 * MM_PER_M,
        'thickness_variation': evenness.variation,
        'within_10_percent': evenness.within,
        'gaps': [{'start_mm': start, 'end_mm': end}
                 for start, end in (profile.gaps * MM_PER_M).tolist()],
        'ooze': [{'start_mm': start, 'end_mm': end}
                 for start, end in (profile.ooze * MM_PER_M).tolist()],
        'strokes': stroke_entries(profile),
        'layers': layer_entries(profile),
        'ink': amount_entry(amount_of(profile, profile.stroke > 0)),
        'offset_mean_mm': statistics.offset_mean * MM_PER_M,
        'offset_rms_mm': statistics.offset_rms * MM_PER_M,
        'warnings': [*log.warnings, *filter(None, (result.warning, lost_in_words(profile)))],
        'advice': advice_entry(result.advice),
        'captures': log.entries,
        'bag': provenance.bag,
        'camera': {'width_px': camera.width, 'height_px': camera.height,
                   'focal_length_px': camera.focal_length},
        'hand_eye': provenance.hand_eye,
        'settings': provenance.settings,
        'contents': provenance.contents,
        'versions': provenance.versions,
        'fingerprint': provenance.fingerprint,
    }
    summary: dict[str, Any] = plain(content)
    return summary
