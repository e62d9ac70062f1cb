"""Values as strict JSON knows them."""

from __future__ import annotations

from collections.abc import Mapping
import math
from typing import Any

DIGITS = 12  # of a number; beyond them is what arithmetic leaves, such as 3.600000000000103
LARGEST_ROUNDED = 1e6  # times in seconds have more digits that mean something


def plain(value: object) -> Any:
    """Return a value as strict JSON knows it: NaN and infinity become None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        if abs(value) < LARGEST_ROUNDED:
            return float(f'{value:.{DIGITS}g}')
        return float(value) if math.isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)
