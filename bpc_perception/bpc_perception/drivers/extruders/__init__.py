"""Extruders on a wire: what they say, and how the connection is kept."""
