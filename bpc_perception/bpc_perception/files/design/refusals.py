"""How what is wrong in a line is said."""

from __future__ import annotations

from bpc_perception.core.design.design import DesignError


def refusal(line: int, expected: str, found: str, what_to_do: str) -> DesignError:
    """Return the error of a line; who knows the file puts its name before it."""
    return DesignError(f'line {line}: expected {expected}, found {found}; {what_to_do}')
