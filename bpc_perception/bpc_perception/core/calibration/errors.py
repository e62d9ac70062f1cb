"""What keeps a calibration from being found."""

from __future__ import annotations


class CalibrationError(ValueError):
    """A calibration cannot be had from what was given; the message says what is missing."""
