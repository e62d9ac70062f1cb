"""Strokes that lie on ink."""
