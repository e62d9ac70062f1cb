"""Step 3: the edges of the ink, to a fraction of a pixel."""
