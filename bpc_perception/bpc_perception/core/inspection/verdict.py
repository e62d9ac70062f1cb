"""The verdict on each stroke, each layer and the whole print: pass, fail, or not enough seen."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from bpc_perception.core.arrays import Flags
from bpc_perception.core.config import ToleranceConfig
from bpc_perception.core.design.comparison import DesignComparison, DesignFindings
from bpc_perception.core.inspection.defects import (
    Check,
    checks_of,
    Defect,
    DefectKind,
    find_defects,
    inner,
    is_all_known,
    samples_of_strokes,
    skipped,
)
from bpc_perception.core.profile import Status, ThicknessProfile
from bpc_perception.core.targets import WidthTargets

LEAST_COUNTED = 0.5  # of a stroke: if more of it has no width by its nature, too little is seen


class Verdict(IntEnum):
    """Whether something is good; the numbers are those of PrintVerdict.msg."""

    NOT_ENOUGH_SEEN = 0
    PASS = 1
    FAIL = 2


@dataclass(frozen=True)
class PartVerdict:
    """The verdict on a stroke or a layer.

    Attributes:
        number: of the stroke, from 1, or of the layer, from 0.
        layer: that it is in.
        verdict: whether it is good.
        seen: share of its samples that could be judged, 0..1.
    """

    number: int
    layer: int
    verdict: Verdict
    seen: float


@dataclass(frozen=True)
class PrintVerdict:
    """The verdict on a print, as far as it was seen in one capture.

    Attributes:
        stamp_ns: stamp of the capture [ns].
        print_id: identifier of the print.
        ended: whether all of it was laid by then; before, it fails or is not enough seen.
        laying: whether ink was being laid at the capture.
        verdict: on the print.
        strokes, layers: in order.
        defects: in the order of the path, and then what of the design was skipped.
        judged: the kinds of defects that were looked for.
        enough: least share of a stroke that has to be seen for it to pass.
    """

    stamp_ns: int
    print_id: str
    ended: bool
    laying: bool
    verdict: Verdict
    strokes: tuple[PartVerdict, ...]
    layers: tuple[PartVerdict, ...]
    defects: tuple[Defect, ...]
    judged: frozenset[DefectKind]
    enough: float

    @classmethod
    def none(cls, stamp_ns: int) -> PrintVerdict:
        """Return that from this time on [ns] there is no print."""
        return cls(stamp_ns, '', True, False, Verdict.NOT_ENOUGH_SEEN, (), (), (), frozenset(),
                   0.0)

    def at_its_end(self, design: DesignFindings | None = None) -> PrintVerdict:
        """Return the verdict where nothing more comes: the last stroke may pass as well.

        Not where ink was being laid at the capture: then the end of the print was not seen.

        Args:
            design: the print beside its design; where not all of it is known, the print cannot
                pass. None = none is told.
        """
        if self.laying:
            return self
        strokes = tuple(
            replace(each, verdict=Verdict.PASS)
            if each.verdict == Verdict.NOT_ENOUGH_SEEN and self.judged and each.seen >= self.enough
            else each for each in self.strokes)
        defects = self.defects
        if design is not None and DefectKind.MISSING_STROKE in self.judged:
            defects = (*(each for each in defects if each.kind != DefectKind.SKIPPED),
                       *skipped(design, over=True))
        layers = _layers(strokes, defects)
        whole = _together(each.verdict for each in layers)
        if whole == Verdict.PASS and design is not None and not is_all_known(design):
            whole = Verdict.NOT_ENOUGH_SEEN
        return replace(self, ended=True, strokes=strokes, layers=layers, defects=defects,
                       verdict=Verdict.FAIL if defects else whole)


def judge(profile: ThicknessProfile, targets: WidthTargets | None, tolerance: ToleranceConfig,
          ended: bool, laying: bool = False,
          design: DesignComparison | None = None) -> PrintVerdict:
    """Judge a print by its profile.

    Args:
        profile: what is known of it.
        targets: widths wanted along the path; None = none, so that they are not judged.
        tolerance: how far it may be off.
        ended: whether the whole print was laid by then.
        laying: whether ink was being laid at the capture.
        design: the print beside its design; None = none is told.
    """
    checks = tuple(checks_of(profile, targets, tolerance, design))
    inside = inner(profile, tolerance.ends)
    defects = find_defects(profile, checks, inside, tolerance)
    findings = design.findings if design is not None else None
    missed = skipped(findings) if findings is not None and tolerance.missing_strokes else []
    wrong = {each.stroke for each in defects}
    seen = _seen(profile, checks, inside, tolerance.samples)
    judged = _judged(targets, tolerance, design is not None and design.pieces is not None)
    last = profile.stroke[-1] if len(profile) else 0
    strokes = []
    for number, own in zip(profile.strokes.number.tolist(), samples_of_strokes(profile),
                           strict=True):
        counted = own[profile.status[own] != Status.JUNCTION]
        # Where lines touch all along, nothing is judged.
        share = float(seen[counted].sum() / max(len(counted), LEAST_COUNTED * len(own)))
        enough = judged and number != last and share >= tolerance.coverage
        strokes.append(PartVerdict(
            number, int(profile.layer[own[len(own) // 2]]),
            Verdict.FAIL if number in wrong else
            Verdict.PASS if enough else Verdict.NOT_ENOUGH_SEEN, share))
    verdict = PrintVerdict(
        profile.stamp_ns, profile.print_id, False, laying and not ended,
        Verdict.FAIL if defects or missed else Verdict.NOT_ENOUGH_SEEN, tuple(strokes),
        _layers(strokes, (*defects, *missed)), (*defects, *missed), judged, tolerance.coverage)
    return verdict.at_its_end(findings) if ended else verdict


def _seen(profile: ThicknessProfile, checks: Sequence[Check], inside: Flags,
          fewest: int) -> Flags:
    """Return which samples (N,) every check could judge; where bed is seen there is no width."""
    gap = profile.status == Status.GAP
    seen = gap | (profile.status == Status.MEASURED)
    ends = ~inside
    for own in samples_of_strokes(profile):  # nothing else of a short stroke is judged
        ends[own] &= inside[own].sum() >= fewest
    for check in checks:
        seen &= gap | ends | (inside & ~np.isnan(check.excess))
    return seen


def _judged(targets: WidthTargets | None, tolerance: ToleranceConfig,
            designed: bool) -> frozenset[DefectKind]:
    """Return which kinds of defects are looked for; with a design that is found, some more."""
    height = bool(tolerance.height and tolerance.target_height)
    width = bool(targets is not None and tolerance.width)
    asked = {DefectKind.THIN: width, DefectKind.THICK: width, DefectKind.LOW: height,
             DefectKind.HIGH: height, DefectKind.OFF_PATH: tolerance.offset > 0,
             DefectKind.GAP: tolerance.gap_length > 0, DefectKind.NECK: tolerance.neck > 0,
             DefectKind.OOZE: tolerance.ooze_length > 0,
             DefectKind.MISSING_STROKE: tolerance.missing_strokes,
             DefectKind.OFF_DESIGN: designed and tolerance.offset > 0,
             DefectKind.SKIPPED: designed and tolerance.missing_strokes}
    return frozenset(kind for kind, wanted in asked.items() if wanted)


def _layers(strokes: Sequence[PartVerdict], defects: Sequence[Defect]) -> tuple[PartVerdict, ...]:
    """Return the verdicts on the layers; ink on travel counts to the layer before it."""
    layers = []
    beside_strokes = {each.layer for each in defects
                      if not each.stroke or each.kind == DefectKind.SKIPPED}
    for number in sorted({each.layer for each in strokes}):
        own = [each for each in strokes if each.layer == number]
        verdict = (Verdict.FAIL if number in beside_strokes
                   else _together(each.verdict for each in own))
        layers.append(PartVerdict(number, number, verdict,
                                  float(np.mean([each.seen for each in own]))))
    return tuple(layers)


def _together(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the verdict on what has these parts: it is as good as its worst."""
    found = set(verdicts)
    if Verdict.FAIL in found:
        return Verdict.FAIL
    return Verdict.PASS if found == {Verdict.PASS} else Verdict.NOT_ENOUGH_SEEN
