"""Data that others published, which lies beside the repository and not in it."""

from __future__ import annotations

import os
from pathlib import Path


def beside_repository(file: Path) -> Path | None:
    """Return where a file is, or None where it is not beside the repository."""
    here = os.environ.get('BPC_ROOT', Path(__file__).resolve().parents[3])
    found = Path(here).parent / file
    return found if found.is_file() else None
