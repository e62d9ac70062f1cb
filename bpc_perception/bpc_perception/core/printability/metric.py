"""One number of printability, with all that has to stand beside it."""

from __future__ import annotations

from dataclasses import dataclass
import math

from bpc_perception.core.printability.definitions import Definition, DEFINITIONS


@dataclass(frozen=True)
class Metric:
    """One number about a part of a print.

    Attributes:
        name: key of DEFINITIONS, where its unit, definition and source are.
        of: what it is about, as 'print' or 'stroke 3'.
        value: in the unit of its definition; NaN = not known.
        sigma: its 1-sigma uncertainty; NaN = not known.
        samples: number of samples, turns or pores that it is made from.
        note: why it is not known, else what has to be said beside it; empty = nothing.
        spread: standard deviation of what it is the mean of; NaN = it is no mean.

    Raises:
        ValueError: it has no definition, or is not known for no reason.
    """

    name: str
    of: str
    value: float
    sigma: float
    samples: int
    note: str = ''
    spread: float = math.nan

    def __post_init__(self) -> None:
        if self.name not in DEFINITIONS:
            raise ValueError(f'metric: expected one with a definition, found {self.name}')
        if math.isnan(self.value) and not self.note:
            raise ValueError(f'{self.name}: expected a number or a reason, found neither')

    @classmethod
    def unknown(cls, name: str, of: str, reason: str, samples: int = 0) -> Metric:
        """Return a metric that is not known, and why."""
        return cls(name, of, math.nan, math.nan, samples, reason)

    @property
    def definition(self) -> Definition:
        """What it means, in which unit, and who says so."""
        return DEFINITIONS[self.name]
