"""What came of a sweep, beside what the law of its ink says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Outcome:
    """What came of an ink.

    Attributes:
        by: 'flow' or 'pressure', or 'camera'.
        error: true width with the recommended setting less the target, as a share; NaN = refused.
        mean_covered: whether the true width is in the 95 % interval of the mean.
        lines_covered: share of new lines in the 95 % interval of a line.
        chance: that was stated of a line to be within tolerance.
        within: share of new lines that are.
        in_window: chance of a line, by the law, to be within tolerance, in the mean over settings
            of the window; NaN = it is empty.
        broken: share of these settings at which lines break.
        refusal: why nothing was recommended; empty = it was.
    """

    by: str
    error: float = np.nan
    mean_covered: bool = False
    lines_covered: float = np.nan
    chance: float = np.nan
    within: float = np.nan
    in_window: float = np.nan
    broken: float = np.nan
    refusal: str = ''
