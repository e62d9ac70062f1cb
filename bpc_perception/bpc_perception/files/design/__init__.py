"""Designs as slicers, bioprinters and people write them: G-code, and tables of points."""
