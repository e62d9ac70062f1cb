"""The identifier of a print: when it started, in UTC."""

from __future__ import annotations

from datetime import datetime, timezone

FORM = '%Y%m%dT%H%M%S.%fZ'


def print_id_of(start_ns: int) -> str:
    """Return the identifier of a print that starts at a time [ns]."""
    start = datetime.fromtimestamp(start_ns // 10**9, timezone.utc)
    return f'{start:%Y%m%dT%H%M%S}.{start_ns % 10**9 // 10**6:03d}Z'


def start_of(print_id: str) -> datetime | None:
    """Return when a print started, to the millisecond; None = its identifier does not say it."""
    try:
        return datetime.strptime(print_id, FORM).replace(tzinfo=timezone.utc)
    except ValueError:
        return None
