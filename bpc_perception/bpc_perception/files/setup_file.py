"""Keep what prints were set up with on disk: limits of advice hold over restarts."""

from __future__ import annotations

import json
from pathlib import Path

from bpc_perception.core.advice.setup import Setup

LONGEST_KEPT_NS = 12 * 3600 * 10**9  # a working day; then it is set up anew


def save_setup(file: Path, setup: Setup, now_ns: int) -> None:
    """Write a setup whole, at a time [ns]. Raises OSError."""
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix('.part')
    part.write_text(json.dumps({'gain': setup.gain, 'followed': setup.followed,
                                'stamp_ns': now_ns}) + '\n', 'utf-8')
    part.replace(file)


def load_setup(file: Path, now_ns: int) -> Setup:
    """Return the setup in a file that is not too old at a time [ns]; else one of no print."""
    try:
        content = json.loads(file.read_text('utf-8'))
        if not 0 <= now_ns - content['stamp_ns'] <= LONGEST_KEPT_NS:
            return Setup()
        return Setup(float(content['gain']), float(content['followed']))
    except (OSError, ValueError, LookupError, TypeError):
        return Setup()
