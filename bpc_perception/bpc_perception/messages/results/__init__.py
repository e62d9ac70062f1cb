"""Conversions of what comes of a capture."""
