"""What the prints of a run were set up with, and how far advice has gone from it.

A print begins with what its controller commands by then: with what it was set up for, or with what
advice has made of that. Limits hold for both together, or each print would begin them anew.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bpc_perception.core.config import AdviceConfig

TOLERANCE = 0.05  # of the limits: so far off them, a controller may still have followed advice


@dataclass(frozen=True)
class Setup:
    """The setup of the newest prints. Amounts are logarithms.

    Attributes:
        gain: area wanted, as w^2, per volume commanded, as the first of them began; NaN = none
            has begun.
        followed: factor on the flow, all advice together, where the rate is not recorded: then
            it counts as followed.
    """

    gain: float = np.nan
    followed: float = 0.0

    def of_print(self, gain: float, config: AdviceConfig) -> Setup:
        """Return the setup of a print that begins with this gain.

        It is the one before if following advice leads from there to here; else another.
        """
        beyond = np.log1p(TOLERANCE)
        from_setup = self.gain - gain
        if (np.log(config.minimum_scale) - beyond <= from_setup
                <= np.log(config.maximum_scale) + beyond):
            return self
        return Setup(gain)

    def after(self, change: float) -> Setup:
        """Return the setup after advice to change the flow [logarithm] that nobody records."""
        return replace(self, followed=self.followed + change)
