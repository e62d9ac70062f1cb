"""One number that a test print tells."""

from __future__ import annotations

from dataclasses import dataclass
import math

from bpc_perception.core.printability.metric import Metric

UNITS = ('m', 'm^2', '%', 's', '')


@dataclass(frozen=True)
class Finding:
    """One number, and what it is about.

    Attributes:
        of: what it is about, as 'pair 3'.
        at: what was planned there, as a distance; NaN = nothing.
        at_unit: of that: 'm', 'deg' or empty.
        quantity: what it is.
        value: NaN = not known.
        sigma: its 1-sigma uncertainty; NaN = not known.
        unit: of both; see UNITS.
        samples: that it is made from.
        note: why it is not known, else what has to be said beside it; empty = nothing.

    Raises:
        ValueError: it is not known for no reason.
    """

    of: str
    at: float
    at_unit: str
    quantity: str
    value: float
    sigma: float
    unit: str
    samples: int
    note: str = ''

    def __post_init__(self) -> None:
        if math.isnan(self.value) and not self.note:
            raise ValueError(f'{self.quantity}: expected a number or a reason, found neither')

    @classmethod
    def of_metric(cls, metric: Metric, of: str = '', at: float = math.nan,
                  at_unit: str = '') -> Finding:
        """Return what a metric of printability tells, about what it names, or ``of``."""
        return cls(of or metric.of, at, at_unit, metric.name, metric.value, metric.sigma,
                   metric.definition.unit, metric.samples, metric.note)

    @classmethod
    def of_print(cls, quantity: str, value: float, sigma: float, unit: str, samples: int,
                 note: str = '') -> Finding:
        """Return what is told of the print as a whole."""
        return cls('print', math.nan, '', quantity, value, sigma, unit, samples, note)
