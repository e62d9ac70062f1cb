"""Words for verdicts and defects, the same wherever they are shown."""

from __future__ import annotations

from collections.abc import Sequence
import math

from bpc_perception.core.inspection.defects import Defect, DefectKind
from bpc_perception.core.inspection.verdict import PrintVerdict, Verdict
from bpc_perception.display.units import MM_PER_M

NAMES = {Verdict.PASS: 'good', Verdict.FAIL: 'not good',
         Verdict.NOT_ENOUGH_SEEN: 'not enough seen'}
TONES = {Verdict.PASS: 'good', Verdict.FAIL: 'bad', Verdict.NOT_ENOUGH_SEEN: 'old'}
DEFECTS = {
    DefectKind.THIN: 'thin', DefectKind.THICK: 'thick', DefectKind.LOW: 'low',
    DefectKind.HIGH: 'high', DefectKind.OFF_PATH: 'off path', DefectKind.GAP: 'gap',
    DefectKind.NECK: 'neck', DefectKind.OOZE: 'ooze', DefectKind.MISSING_STROKE: 'missing stroke',
    DefectKind.OFF_DESIGN: 'off design', DefectKind.SKIPPED: 'skipped'}
LEAST = {DefectKind.THIN, DefectKind.LOW, DefectKind.NECK}  # whose limit is the least allowed


def verdict_in_words(verdict: PrintVerdict) -> str:
    """Return the verdict on a print, and why, as a sentence."""
    if verdict.verdict == Verdict.FAIL:
        return f'{NAMES[Verdict.FAIL]}: {_counted(verdict.defects)}'
    if verdict.verdict == Verdict.PASS:
        return NAMES[Verdict.PASS]
    if not verdict.judged or not any(each.seen for each in verdict.strokes):
        return NAMES[Verdict.NOT_ENOUGH_SEEN]
    if not verdict.ended:
        return 'good so far'
    unseen = [each for each in verdict.strokes if each.verdict == Verdict.NOT_ENOUGH_SEEN]
    return (f'{NAMES[Verdict.NOT_ENOUGH_SEEN]}: no defect is seen, but of {len(unseen)} of '
            f'{len(verdict.strokes)} strokes too little')


def not_judged(verdict: PrintVerdict) -> str:
    """Return what was not looked for; empty = everything was."""
    kinds = [DEFECTS[kind] for kind in DefectKind if kind not in verdict.judged]
    return f'not judged: {", ".join(kinds)}' if kinds else ''


def defect_in_words(defect: Defect) -> str:
    """Return what is wrong, and by how much."""
    name, worst = DEFECTS[defect.kind], defect.worst * MM_PER_M
    if defect.kind in (DefectKind.MISSING_STROKE, DefectKind.SKIPPED):
        return f'{name} of {worst:.1f} mm'
    limit = abs(defect.limit) * MM_PER_M
    if defect.kind in (DefectKind.GAP, DefectKind.OOZE):
        return f'{name} of {worst:.1f} mm, at most {limit:.1f}'
    if math.isnan(limit):  # no width is known that it could be a part of
        return f'{name}: {abs(worst):.3f} mm'
    return (f'{name}: {abs(worst):.3f} mm, {"at least" if defect.kind in LEAST else "at most"} '
            f'{limit:.3f}')


def place_in_words(defect: Defect) -> str:
    """Return where a defect is: its stroke, and the arc lengths between which it lies."""
    where = f'stroke {defect.stroke}' if defect.stroke else 'travel'
    if defect.kind == DefectKind.SKIPPED:
        where += ' of the design'
    return f'{where}, {defect.start * MM_PER_M:.1f} to {defect.end * MM_PER_M:.1f} mm'


def _counted(defects: Sequence[Defect]) -> str:
    """Return how many defects of each kind there are."""
    counts = {kind: sum(each.kind == kind for each in defects) for kind in DefectKind}
    return ', '.join(f'{count} × {DEFECTS[kind]}' for kind, count in counts.items() if count)
