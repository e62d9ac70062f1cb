"""Control charts of the prints of one kind, in the order in which they were made."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np

from bpc_perception.core.arrays import Array
from bpc_perception.core.control.capability import Capability, capability, share_bounds
from bpc_perception.core.control.individuals import control_limits, ControlLimits
from bpc_perception.core.control.rules import Alarm, find_alarms
from bpc_perception.core.inspection.verdict import Verdict
from bpc_perception.report.control.setup import Band, number_of, Setup
from bpc_perception.report.result_folder import part_of


@dataclass(frozen=True)
class ChartedPrint:
    """What a chart shows of a print.

    Attributes:
        name: for people.
        print_id: tells it from all others.
        stamp_ns: time of the capture that is reported [ns].
        width, height: means over what is measured of it [mm]; NaN = not known.
        verdict: whether it is good; None = not judged.
        setup: what it was made with.
    """

    name: str
    print_id: str
    stamp_ns: int
    width: float
    height: float
    verdict: Verdict | None
    setup: Setup

    @classmethod
    def of(cls, name: str, summary: dict[str, Any]) -> ChartedPrint:
        """Return the print of this name, by its summary."""
        said, stamp_ns = str(part_of(summary, 'verdict').get('verdict')), summary.get('stamp_ns')
        return cls(
            name, str(summary['print_id']), stamp_ns if isinstance(stamp_ns, int) else 0,
            number_of(summary.get('thickness_mean_mm')),
            number_of(part_of(summary, 'ink').get('height_mean_mm')),
            Verdict[said] if said in Verdict.__members__ else None, Setup.of(summary))


@dataclass(frozen=True)
class Chart:
    """A control chart of one number a print.

    Attributes:
        quantity: its name.
        values: (N,) in the order of time [mm]; NaN = not known.
        limits: control limits [mm].
        alarms: where it is not by chance.
        tolerance: least and largest value that is good [mm]; NaN = none.
        capability: see there.
    """

    quantity: str
    values: Array
    limits: ControlLimits
    alarms: tuple[Alarm, ...]
    tolerance: tuple[float, float]
    capability: Capability

    @property
    def target(self) -> float:
        """The middle of the tolerance [mm]; NaN = none."""
        return sum(self.tolerance) / 2


@dataclass(frozen=True)
class ControlGroup:
    """Prints that were made and measured with the same.

    Attributes:
        number: from 1, in the order of the first prints.
        prints: N in the order of time.
        charts: of width, and of height where that is known.
        baseline: the limits are set by the first so many; None = all.
        twice: names of those left out, since they are the same print as another.
    """

    number: int
    prints: tuple[ChartedPrint, ...]
    charts: tuple[Chart, ...]
    baseline: int | None
    twice: tuple[str, ...]

    @property
    def good(self) -> Array:
        """1 for each print (N,) that is good, 0 for one that is not, NaN where that is open."""
        marks = {Verdict.PASS: 1.0, Verdict.FAIL: 0.0}
        return np.array([math.nan if each.verdict is None else marks.get(each.verdict, math.nan)
                         for each in self.prints])

    @property
    def good_share(self) -> Array:
        """Share of good ones (N,) among the prints judged up to each; NaN before the first."""
        judged = np.isfinite(self.good).cumsum()
        good = np.nan_to_num(self.good).cumsum()
        return np.divide(good, judged, out=np.full(len(judged), np.nan), where=judged > 0)

    @property
    def good_bounds(self) -> tuple[float, float]:
        """Between which the share of good prints lies at 95 % confidence."""
        return share_bounds(int(np.nansum(self.good)), int(np.isfinite(self.good).sum()))


def control_groups(prints: Iterable[ChartedPrint],
                   baseline: int | None = None) -> list[ControlGroup]:
    """Return charts of prints, those of each setup by themselves.

    Args:
        prints: in any order. Of those with one print_id in a group the first counts.
        baseline: the first so many prints of each group set its limits; None = all.
    """
    groups: list[list[ChartedPrint]] = []
    for each in sorted(prints, key=lambda print_: print_.stamp_ns):
        for group in groups:
            if group[0].setup.is_like(each.setup):
                group.append(each)
                break
        else:
            groups.append([each])
    return [_group(number, group, baseline) for number, group in enumerate(groups, 1)]


def _group(number: int, prints: Sequence[ChartedPrint], baseline: int | None) -> ControlGroup:
    first: dict[str, ChartedPrint] = {}
    for each in prints:
        first.setdefault(each.print_id, each)
    once = tuple(first.values())
    setup = once[0].setup
    charts = [_chart('width', [each.width for each in once], setup.width(), baseline)]
    height = [each.height for each in once]
    if np.isfinite(height).any():
        charts.append(_chart('height', height, setup.height(), baseline))
    return ControlGroup(number, once, tuple(charts), baseline, tuple(
        each.name for each in prints if first[each.print_id] is not each))


def _chart(quantity: str, numbers: Sequence[float], band: Band, baseline: int | None) -> Chart:
    values, (low, high, reason) = np.array(numbers), band
    limits = control_limits(values, baseline)
    found = capability(values, (low, high))
    if reason:
        found = replace(found, reason=reason)
    return Chart(quantity, values, limits, tuple(find_alarms(values, limits)), (low, high), found)
