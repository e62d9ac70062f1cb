"""Ink as it is laid: curves, strands, beads, and what an extruder delivers."""
