"""Hold warnings until the end of a command."""

from __future__ import annotations

import logging


class HeldWarnings(logging.Handler):
    """Keeps each warning once for the end, when its consequences are known."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: dict[str, None] = {}

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the message."""
        self.texts[record.getMessage()] = None
