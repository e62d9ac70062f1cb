"""Pictures of beads by a ray tracer: light, lens and materials that the suite does not draw."""
