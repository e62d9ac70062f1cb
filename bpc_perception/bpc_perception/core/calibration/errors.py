"""What keeps a calibration from being found."""

from __future__ import annotations


class CalibrationError(ValueError):
    """No calibration can be found from what was given; the message says what is missing."""
