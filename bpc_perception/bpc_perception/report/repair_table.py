"""The table repair.csv: the points of the strokes that fill, in millimetres and seconds."""

from __future__ import annotations

from bpc_perception.core.repair.plan import Fill, RepairPlan
from bpc_perception.display.units import MM_PER_M

REPAIR = 'repair.csv'
COLUMNS = ('fill', 'kind', 'layer', 'stroke', 'arc_length_mm', 'x_mm', 'y_mm', 'z_mm',
           'speed_mm_s', 'volume_per_length_mm2', 'flow_mm3_s')


def repair_csv(plan: RepairPlan) -> str:
    """Return the strokes that fill finished layers as CSV with a header, a row for each point.

    Volume and flow hold from a point to the next. Numbers have as many digits as it takes to read
    the same number back.
    """
    rows = [','.join(COLUMNS)]
    for number, fill in enumerate(plan.fills, 1):
        rows += _rows(number, fill)
    return '\n'.join(rows) + '\n'


def _rows(number: int, fill: Fill) -> list[str]:
    head = f'{number},{fill.kind.name},{fill.layer},{fill.stroke}'
    columns = (fill.arc_length * MM_PER_M, *(fill.points * MM_PER_M).T,
               fill.area * 0 + fill.speed * MM_PER_M, fill.area * MM_PER_M**2,
               fill.flow * MM_PER_M**3)
    return [','.join((head, *map(repr, values))) for values in zip(
        *(column.tolist() for column in columns), strict=True)]
