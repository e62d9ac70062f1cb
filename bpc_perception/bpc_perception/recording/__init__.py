"""Recordings: written, read whole or torn, and measured without a graph."""
