"""Numbers by which bioink laboratories tell how well an ink prints, from a measured profile."""
